//! Arrays of the file and their attributes, as described by the arrays' headers.

use super::array::Place;
use super::datatype::{self, real32, real64, whole32};
use super::heap::{Heap, Held};
use super::object::{Messages, length32};
use super::scale::Scale;
use crate::dataset::Attribute;
use crate::error::CubeError;

/// An array of the file, written but for its header.
#[derive(Debug)]
pub(super) struct Object {
    pub link: String,
    pub shape: Vec<usize>,
    pub datatype: Vec<u8>,
    pub place: Place,
    pub attributes: Vec<(String, Property)>,
    /// Dimensions, as numbers in the order of the dataset.
    pub dimensions: Vec<usize>,
    /// The number of the dimension whose scale it is.
    pub scale_of: Option<usize>,
    /// Whether the object represents a dimension only, without values.
    pub is_bare: bool,
}

/// The value of an attribute.
#[derive(Debug)]
pub(super) enum Property {
    Text(Held),
    Number(f64),
    Numbers(Vec<f64>),
    WholeNumbers(Vec<i32>),
}

impl Object {
    /// Placeholder of a dimension without coordinates.
    pub(super) fn bare_dimension(name: &str, number: usize, length: usize) -> Self {
        Self {
            link: name.to_owned(),
            shape: vec![length],
            datatype: real32(),
            place: Place::nowhere(4 * length as u64),
            attributes: Vec::new(),
            dimensions: Vec::new(),
            scale_of: Some(number),
            is_bare: true,
        }
    }

    pub(super) fn header(
        &self,
        scale: Option<&Scale>,
        list: Option<Vec<u8>>,
        heap_at: &[u64],
    ) -> Vec<u8> {
        let mut messages = Messages::default();
        messages.dataspace(&self.shape);
        messages.datatype(&self.datatype);
        messages.fill_with_zeros();
        self.place.describe(&mut messages);
        if let Some(scale) = scale {
            scale.describe(&mut messages);
        }
        if let Some(list) = list {
            let shape = [self.dimensions.len()];
            messages.attribute("DIMENSION_LIST", &datatype::references(), &shape, &list);
        }
        describe(&mut messages, &self.attributes, heap_at);
        messages.header()
    }
}

/// Bytes of its name and numbers that an attribute may have: a message of a header holds 64 KiB, types and
/// shape included.
const MOST_BYTES: usize = 60_000;

/// Attributes with their texts put into the heap.
///
/// # Errors
/// A name or a list of numbers that no header holds.
pub(super) fn held_texts(
    attributes: &[(String, Attribute)],
    heap: &mut Heap,
) -> Result<Vec<(String, Property)>, CubeError> {
    for (name, value) in attributes {
        let numbers = match value {
            Attribute::Text(_) | Attribute::Number(_) => 0,
            Attribute::Numbers(v) => size_of_val(v.as_slice()),
            Attribute::WholeNumbers(v) => size_of_val(v.as_slice()),
        };
        let found = name.len() + numbers;
        if found > MOST_BYTES {
            return Err(CubeError::Attribute {
                name: name.chars().take(64).collect(),
                most: MOST_BYTES,
                found,
            });
        }
    }
    let mut property = |value: &Attribute| match value {
        Attribute::Text(text) => {
            let bytes = text.as_bytes().to_vec();
            let length = length32(bytes.len());
            Property::Text(heap.hold(bytes, length))
        }
        Attribute::Number(number) => Property::Number(*number),
        Attribute::Numbers(numbers) => Property::Numbers(numbers.clone()),
        Attribute::WholeNumbers(numbers) => Property::WholeNumbers(numbers.clone()),
    };
    Ok(attributes
        .iter()
        .map(|(name, value)| (name.clone(), property(value)))
        .collect())
}

/// Adds attributes to the messages of an object.
pub(super) fn describe(
    messages: &mut Messages,
    attributes: &[(String, Property)],
    heap_at: &[u64],
) {
    for (name, value) in attributes {
        match value {
            Property::Text(held) => {
                messages.attribute(name, &datatype::text(), &[], &held.pointer(heap_at));
            }
            Property::Number(v) => {
                messages.attribute(name, &real64(), &[], &v.to_le_bytes());
            }
            Property::Numbers(v) => {
                let bytes: Vec<u8> = v.iter().flat_map(|v| v.to_le_bytes()).collect();
                messages.attribute(name, &real64(), &[v.len()], &bytes);
            }
            Property::WholeNumbers(v) => {
                let bytes: Vec<u8> = v.iter().flat_map(|v| v.to_le_bytes()).collect();
                messages.attribute(name, &whole32(), &[v.len()], &bytes);
            }
        }
    }
}
