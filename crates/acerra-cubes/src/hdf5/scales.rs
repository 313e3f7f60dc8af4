//! Dimension scales: which array holds the coordinates of which dimension of which other.

use super::heap::{Heap, Held};
use super::record::Object;
use super::scale::Scale;

/// The scales of a file, and the arrays attached to them.
#[derive(Debug)]
pub(super) struct Scales {
    /// For each object: the dimension whose scale it is.
    dimension: Vec<Option<usize>>,
    /// For each dimension: the NAME attribute of its scale, and the index of the object that is its scale.
    scale: Vec<(String, usize)>,
    /// For each object that is no scale: its dimensions and where the heap holds the references.
    attached: Vec<Vec<(usize, Held)>>,
}

impl Scales {
    pub(super) fn of(dimensions: &[(String, usize)], objects: &[Object], heap: &mut Heap) -> Self {
        let dimension: Vec<Option<usize>> = objects.iter().map(|o| o.scale_of).collect();
        let scale = dimensions.iter().enumerate().map(|(d, (name, length))| {
            let object = dimension
                .iter()
                .position(|own| *own == Some(d))
                .unwrap_or(0);
            let label = if objects[object].is_bare {
                format!("This is a netCDF dimension but not a netCDF variable.{length:>11}")
            } else {
                name.clone()
            };
            (label, object)
        });
        let scale = scale.collect();
        let attached = objects
            .iter()
            .zip(&dimension)
            .map(|(object, own)| {
                let dimensions: &[usize] = if own.is_some() {
                    &[]
                } else {
                    &object.dimensions
                };
                let each = dimensions.iter();
                each.map(|d| (*d, heap.hold(vec![0; 8], 1))).collect()
            })
            .collect();
        Self {
            dimension,
            scale,
            attached,
        }
    }

    /// Puts the addresses of the scales into the heap.
    pub(super) fn refer(&self, objects_at: &[u64], heap: &mut Heap) {
        for (d, held) in self.attached.iter().flatten() {
            let address = objects_at[self.scale[*d].1];
            heap.replace(*held, address.to_le_bytes().to_vec());
        }
    }

    /// Attributes of object `k` as a dimension scale; `None` where the object is no scale.
    pub(super) fn scale(&self, k: usize, objects_at: &[u64]) -> Option<Scale> {
        let number = self.dimension[k]?;
        let mut attached = Vec::new();
        for (other, dimensions) in self.attached.iter().enumerate() {
            for (place, (d, _)) in dimensions.iter().enumerate() {
                if *d == number {
                    attached.push((objects_at[other], place));
                }
            }
        }
        Some(Scale {
            name: self.scale[number].0.clone(),
            number,
            attached,
        })
    }

    /// The scales of the dimensions of object `k`, where it has any and is no scale itself.
    pub(super) fn list(&self, k: usize, heap_at: &[u64]) -> Option<Vec<u8>> {
        let dimensions = &self.attached[k];
        let bytes = || {
            dimensions
                .iter()
                .flat_map(|(_, held)| held.pointer(heap_at))
        };
        (!dimensions.is_empty()).then(|| bytes().collect())
    }
}
