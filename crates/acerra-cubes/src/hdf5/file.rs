//! The file from its beginning to its end.

use std::io::{Seek, SeekFrom, Write};

use num_complex::Complex32;

use super::array::{Place, write_values};
use super::checksum::lookup3;
use super::datatype::{real32, real64, whole32};
use super::heap::Heap;
use super::layout::Layout;
use super::object::NOWHERE;
use super::out::Out;
use super::record::{Object, held_texts};
use super::scales::Scales;
use crate::dataset::{Attribute, Dataset, Values, Variable, check_name};
use crate::error::CubeError;

/// Bytes of the superblock.
const SUPERBLOCK: u64 = 48;

/// Writes a dataset as NetCDF-4. Complex variables become two, `NAME_real` and `NAME_imag`: neither NetCDF
/// nor MATLAB has complex numbers in files. Values are written as they come; the rest is held in memory.
///
/// # Errors
/// Names or lengths that do not fit, a file that cannot be written.
pub fn write_hdf5(out: impl Write + Seek, dataset: &Dataset<'_>) -> Result<(), CubeError> {
    let mut file = Hdf5File::create(out)?;
    file.dataset(dataset)?;
    file.finish(&dataset.attributes)
}

/// A NetCDF-4 file being written.
#[derive(Debug)]
pub struct Hdf5File<W> {
    pub(super) out: Out<W>,
    heap: Heap,
    dimensions: Vec<(String, usize)>,
    objects: Vec<Object>,
}

impl<W: Write + Seek> Hdf5File<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(mut out: W) -> Result<Self, CubeError> {
        out.write_all(&[0; SUPERBLOCK as usize])?;
        Ok(Self {
            out: Out::at(out, SUPERBLOCK),
            heap: Heap::default(),
            dimensions: Vec::new(),
            objects: Vec::new(),
        })
    }

    /// Writes every variable of a dataset.
    ///
    /// # Errors
    /// Names or lengths that do not fit, a file that cannot be written.
    pub fn dataset(&mut self, dataset: &Dataset<'_>) -> Result<(), CubeError> {
        dataset.check()?;
        for (name, length) in &dataset.dimensions {
            self.dimension(name, *length)?;
        }
        for variable in split(dataset) {
            let shape = dataset.shape(&variable)?;
            let (datatype, place) = match &variable.values {
                Values::Real32(v) => (real32(), write_values(&mut self.out, v, &shape)?),
                Values::Real64(v) => (real64(), write_values(&mut self.out, v, &shape)?),
                Values::Whole(v) => (whole32(), write_values(&mut self.out, v, &shape)?),
                // Split before.
                Values::Complex32(_) => (real32(), Place::nowhere(0)),
            };
            self.object(&variable, shape, datatype, place)?;
        }
        Ok(())
    }

    /// Declares a dimension, or compares it with the one declared before.
    pub(super) fn dimension(&mut self, name: &str, length: usize) -> Result<(), CubeError> {
        check_name(name)?;
        match self.dimensions.iter().find(|(other, _)| other == name) {
            Some((_, declared)) if *declared != length => Err(CubeError::Length {
                variable: name.to_owned(),
                expected: *declared,
                found: length,
            }),
            Some(_) => Ok(()),
            None => {
                self.dimensions.push((name.to_owned(), length));
                Ok(())
            }
        }
    }

    /// Notes an array whose values are written.
    pub(super) fn object(
        &mut self,
        variable: &Variable<'_>,
        shape: Vec<usize>,
        datatype: Vec<u8>,
        place: Place,
    ) -> Result<(), CubeError> {
        let number = |name: &String| self.dimensions.iter().position(|(n, _)| n == name);
        let dimensions = variable.dimensions.iter().filter_map(number).collect();
        let same = number(&variable.name);
        let is_scale = variable.dimensions == [variable.name.clone()];
        let link = match same {
            // NetCDF's name for a variable that is called as a dimension but holds no coordinates.
            Some(_) if !is_scale => format!("_nc4_non_coord_{}", variable.name),
            _ => variable.name.clone(),
        };
        if self.objects.iter().any(|object| object.link == link) {
            return Err(CubeError::SameName { name: link });
        }
        let attributes = held_texts(&variable.attributes, &mut self.heap)?;
        self.objects.push(Object {
            link,
            shape,
            datatype,
            place,
            attributes,
            dimensions,
            scale_of: same.filter(|_| is_scale),
            is_bare: false,
        });
        Ok(())
    }

    /// Writes the descriptions of the arrays and the file, which completes it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self, attributes: &[(String, Attribute)]) -> Result<(), CubeError> {
        for (number, (name, length)) in self.dimensions.iter().enumerate() {
            if !self.objects.iter().any(|o| o.scale_of == Some(number)) {
                let bare = Object::bare_dimension(name, number, *length);
                self.objects.push(bare);
            }
        }
        let scales = Scales::of(&self.dimensions, &self.objects, &mut self.heap);
        let root = held_texts(attributes, &mut self.heap)?;
        self.out.align()?;
        let start = self.out.position();
        let layout = Layout::of(&self.objects, &scales, &root, &self.heap, start);
        for part in layout.encoded(&self.objects, &scales, &root, &mut self.heap) {
            self.out.put(&part)?;
        }
        let end = self.out.position();
        let mut out = self.out.into_inner();
        out.seek(SeekFrom::Start(0))?;
        out.write_all(&superblock(layout.root, end))?;
        Ok(out.flush()?)
    }
}

/// The variables, complex ones as two.
fn split<'a>(dataset: &'a Dataset<'_>) -> impl Iterator<Item = Variable<'a>> {
    dataset.variables.iter().flat_map(|variable| {
        let of = |name: String, values: Values<'a>| Variable {
            name,
            dimensions: variable.dimensions.clone(),
            values,
            attributes: variable.attributes.clone(),
        };
        match &variable.values {
            Values::Complex32(z) => {
                let part = |f: fn(&Complex32) -> f32| z.iter().map(f).collect::<Vec<f32>>().into();
                vec![
                    of(format!("{}_real", variable.name), part(|z| z.re)),
                    of(format!("{}_imag", variable.name), part(|z| z.im)),
                ]
            }
            Values::Real32(v) => vec![of(variable.name.clone(), Values::Real32((&**v).into()))],
            Values::Real64(v) => vec![of(variable.name.clone(), Values::Real64((&**v).into()))],
            Values::Whole(v) => vec![of(variable.name.clone(), Values::Whole((&**v).into()))],
        }
    })
}

/// The beginning of the file (version 2): where the root group and the end are.
fn superblock(root: u64, end: u64) -> Vec<u8> {
    let mut out = b"\x89HDF\r\n\x1a\n".to_vec();
    // Version 2; offsets and lengths of eight bytes; closed.
    out.extend([2, 8, 8, 0]);
    for address in [0, NOWHERE, end, root] {
        out.extend(address.to_le_bytes());
    }
    out.extend(lookup3(&out).to_le_bytes());
    out
}
