//! HDF5, as MATLAB, h5py and the NetCDF library read it.
//!
//! The library writes no references within attributes, which dimension scales would need: a variable
//! names its dimensions in its attribute `dimensions` instead, and the coordinates are variables of the
//! dimensions' names. Zarr groups have dimensions that programs see.

use std::io::Write;

use hdf5_pure::{AttrValue, FileBuilder};
use num_complex::Complex32;

use crate::dataset::{Attribute, Dataset, Values, Variable};
use crate::error::CubeError;

/// Values of a chunk along each dimension at most.
const CHUNK_SIDE: usize = 512;
/// Values of a chunk of an array of one dimension at most.
const CHUNK_LINE: usize = 1 << 16;
/// Arrays of fewer values are not compressed.
const LEAST_COMPRESSED: usize = 1024;
/// Level of compression.
const DEFLATE_LEVEL: u32 = 4;

/// Writes a dataset as HDF5. Complex variables become two, `NAME_real` and `NAME_imag`: MATLAB has no
/// complex numbers in files. The whole file is held in memory.
///
/// # Errors
/// Names or lengths that do not fit, a file that cannot be written.
pub fn write_hdf5(mut out: impl Write, dataset: &Dataset<'_>) -> Result<(), CubeError> {
    dataset.check()?;
    let mut file = FileBuilder::new();
    for (name, value) in &dataset.attributes {
        file.set_attr(name, attribute(value));
    }
    for variable in &dataset.variables {
        let shape = dataset.shape(variable)?;
        let Values::Complex32(values) = &variable.values else {
            add(&mut file, variable, &shape);
            continue;
        };
        for part in ["real", "imag"] {
            let of = |z: &Complex32| if part == "real" { z.re } else { z.im };
            let half = Variable {
                name: format!("{}_{part}", variable.name),
                dimensions: variable.dimensions.clone(),
                values: values.iter().map(of).collect::<Vec<_>>().into(),
                attributes: variable.attributes.clone(),
            };
            add(&mut file, &half, &shape);
        }
    }
    out.write_all(&file.finish()?)?;
    Ok(out.flush()?)
}

fn add(file: &mut FileBuilder, variable: &Variable<'_>, shape: &[usize]) {
    let array = file.create_dataset(&variable.name);
    match &variable.values {
        Values::Real32(v) => array.with_f32_data(v),
        Values::Real64(v) => array.with_f64_data(v),
        Values::Whole(v) => array.with_i32_data(v),
        // Split into its parts by the caller.
        Values::Complex32(_) => array,
    };
    let lengths: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
    array.with_shape(&lengths);
    if variable.values.len() >= LEAST_COMPRESSED {
        let most = if shape.len() == 1 {
            CHUNK_LINE
        } else {
            CHUNK_SIDE
        };
        let chunks: Vec<u64> = shape.iter().map(|n| (*n).clamp(1, most) as u64).collect();
        array
            .with_chunks(&chunks)
            .with_shuffle()
            .with_deflate(DEFLATE_LEVEL);
    }
    for (name, value) in &variable.attributes {
        array.set_attr(name, attribute(value));
    }
    if !variable.dimensions.is_empty() {
        let dimensions = AttrValue::AsciiString(variable.dimensions.join(" "));
        array.set_attr("dimensions", dimensions);
    }
}

fn attribute(value: &Attribute) -> AttrValue {
    match value {
        Attribute::Text(text) => AttrValue::VarLenString(text.clone()),
        Attribute::Number(number) => AttrValue::F64(*number),
        Attribute::Numbers(numbers) => AttrValue::F64Array(numbers.clone()),
        Attribute::WholeNumbers(numbers) => AttrValue::I32Array(numbers.clone()),
    }
}
