//! The metadata documents of Zarr v3 (zarr-specs, core version 3.0).

use serde_json::{Map, Value, json};

use crate::dataset::{Attribute, Values, Variable};

/// Values of a chunk along each of the two fastest dimensions at most.
const CHUNK_SIDE: usize = 512;
/// Values of a chunk of an array of one dimension at most.
const CHUNK_LINE: usize = 1 << 16;
/// Level of compression: most of the attainable reduction at a third of the highest level's cost.
pub(super) const GZIP_LEVEL: u32 = 4;

/// An array's document, and the shape of its chunks.
pub(super) struct ArrayMetadata {
    pub json: Value,
    pub chunk: Vec<usize>,
}

impl ArrayMetadata {
    /// An array whose chunks are cut by its shape and compressed.
    pub fn of(variable: &Variable<'_>, shape: &[usize]) -> Self {
        let gzip = json!({"name": "gzip", "configuration": {"level": GZIP_LEVEL}});
        Self::with_chunks(variable, shape, chunk_shape(shape), Some(gzip))
    }

    /// An array with these chunks, compressed or uncompressed.
    pub fn with_chunks(
        variable: &Variable<'_>,
        shape: &[usize],
        chunk: Vec<usize>,
        compression: Option<Value>,
    ) -> Self {
        let bytes = json!({"name": "bytes", "configuration": {"endian": "little"}});
        let codecs: Vec<Value> = std::iter::once(bytes).chain(compression).collect();
        let (data_type, fill_value) = match &variable.values {
            Values::Real32(_) => ("float32", json!("NaN")),
            Values::Real64(_) => ("float64", json!("NaN")),
            Values::Complex32(_) => ("complex64", json!(["NaN", "NaN"])),
            Values::Whole(_) => ("int32", json!(0)),
        };
        let json = json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": shape,
            "data_type": data_type,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": fill_value,
            "codecs": codecs,
            "attributes": attributes_json(&variable.attributes),
            "dimension_names": variable.dimensions,
            "storage_transformers": [],
        });
        Self { json, chunk }
    }
}

/// Planes of the two fastest dimensions are cut into squares.
fn chunk_shape(shape: &[usize]) -> Vec<usize> {
    let rank = shape.len();
    let most = |axis: usize| match rank {
        1 => CHUNK_LINE,
        _ if axis + 2 >= rank => CHUNK_SIDE,
        _ => 1,
    };
    let lengths = shape.iter().enumerate();
    lengths.map(|(axis, n)| (*n).clamp(1, most(axis))).collect()
}

pub(super) fn attributes_json(attributes: &[(String, Attribute)]) -> Value {
    let value = |attribute: &Attribute| match attribute {
        Attribute::Text(text) => json!(text),
        Attribute::Number(number) => json!(number),
        Attribute::Numbers(numbers) => json!(numbers),
        Attribute::WholeNumbers(numbers) => json!(numbers),
    };
    let members = attributes.iter().map(|(name, a)| (name.clone(), value(a)));
    Value::Object(members.collect())
}

/// The group's document, with the documents of its arrays.
pub(super) fn group_json(attributes: Value, arrays: Map<String, Value>) -> String {
    let group = json!({
        "zarr_format": 3,
        "node_type": "group",
        "attributes": attributes,
        "consolidated_metadata": {
            "kind": "inline",
            "must_understand": false,
            "metadata": arrays,
        },
    });
    format!("{group:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_squares_of_planes() {
        assert_eq!(chunk_shape(&[]), [0; 0]);
        assert_eq!(chunk_shape(&[100]), [100]);
        assert_eq!(chunk_shape(&[700, 100]), [512, 100]);
        assert_eq!(chunk_shape(&[30, 700, 600]), [1, 512, 512]);
        assert_eq!(chunk_shape(&[0]), [1]);
    }
}
