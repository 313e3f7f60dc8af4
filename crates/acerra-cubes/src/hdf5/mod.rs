//! NetCDF-4 in HDF5, as MATLAB, h5py, xarray and the NetCDF library read it.
//!
//! ```text
//! superblock │ values of every variable │ object headers │ root group │ texts and references
//! ```
//!
//! The subset of HDF5 that NetCDF-4 needs, after the *HDF5 File Format Specification Version 3.0*: object
//! headers of version 2, chunks listed by B-trees, shuffled and deflated. Dimensions are dimension scales
//! (*HDF5 Dimension Scale Specification*): a variable that bears the name of its only dimension is the
//! dimension's scale. The superblock comes last, so that a file cut off is none.

mod array;
mod checksum;
mod datatype;
mod heap;
mod object;
mod out;
mod scales;
mod stack;

use std::io::{Seek, SeekFrom, Write};

use num_complex::Complex32;

use crate::dataset::{Attribute, Dataset, StackShape, Values, Variable, check_name};
use crate::error::CubeError;
use array::{Place, write_values};
use checksum::lookup3;
use datatype::{real32, real64, whole32};
use heap::{Heap, Held};
use object::{Messages, NOWHERE, length32};
use out::Out;
use scales::{Scale, Scales};
pub use stack::Hdf5Stack;

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
    out: Out<W>,
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

    /// Begins two arrays of the real and imaginary parts of images, which are written one by one. Dimensions
    /// that were not declared get the stack's lengths.
    ///
    /// # Errors
    /// A name or a length that does not fit.
    pub fn stack<'a>(
        &'a mut self,
        variable: &Variable<'_>,
        shape: StackShape,
    ) -> Result<Hdf5Stack<'a, W>, CubeError> {
        check_name(&variable.name)?;
        for (name, length) in variable.dimensions.iter().zip(shape.lengths()) {
            self.dimension(name, length)?;
        }
        Ok(Hdf5Stack::new(self, variable, shape))
    }

    /// Declares a dimension, or compares it with the one declared before.
    fn dimension(&mut self, name: &str, length: usize) -> Result<(), CubeError> {
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
    fn object(
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
        self.objects.push(Object {
            link,
            shape,
            datatype,
            place,
            attributes: held_texts(&variable.attributes, &mut self.heap),
            dimensions,
            scale_of: same.filter(|_| is_scale),
            is_bare: false,
        });
        Ok(())
    }

    /// Writes what the arrays and the file are: it is complete.
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
        let root = held_texts(attributes, &mut self.heap);
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

/// An array of the file, written but for its header.
#[derive(Debug)]
struct Object {
    link: String,
    shape: Vec<usize>,
    datatype: Vec<u8>,
    place: Place,
    attributes: Vec<(String, Property)>,
    /// Its dimensions, as numbers in the order of the dataset.
    dimensions: Vec<usize>,
    /// The number of the dimension whose scale it is.
    scale_of: Option<usize>,
    /// Whether it stands for a dimension alone, without values.
    is_bare: bool,
}

/// The value of an attribute.
#[derive(Debug)]
enum Property {
    Text(Held),
    Number(f64),
    Numbers(Vec<f64>),
    WholeNumbers(Vec<i32>),
}

impl Object {
    /// What stands for a dimension without coordinates.
    fn bare_dimension(name: &str, number: usize, length: usize) -> Self {
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

    fn header(&self, scale: Option<&Scale>, list: Option<Vec<u8>>, heap_at: &[u64]) -> Vec<u8> {
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

/// Attributes with their texts put into the heap.
fn held_texts(attributes: &[(String, Attribute)], heap: &mut Heap) -> Vec<(String, Property)> {
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
    attributes
        .iter()
        .map(|(name, value)| (name.clone(), property(value)))
        .collect()
}

fn describe(messages: &mut Messages, attributes: &[(String, Property)], heap_at: &[u64]) {
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

/// Addresses of headers, root group and heap.
#[derive(Debug)]
struct Layout {
    objects: Vec<u64>,
    root: u64,
    heap: Vec<u64>,
}

impl Layout {
    /// Lengths do not depend on addresses: with none known, headers are as long as they will be.
    fn of(
        objects: &[Object],
        scales: &Scales,
        root: &[(String, Property)],
        heap: &Heap,
        start: u64,
    ) -> Self {
        let mut unknown = Self {
            objects: vec![0; objects.len()],
            root: 0,
            heap: vec![0; heap.sizes().len()],
        };
        let mut at = start;
        let mut place = |bytes: usize| {
            let here = at;
            at = (at + bytes as u64).next_multiple_of(8);
            here
        };
        let headers = unknown.headers(objects, scales);
        let group = unknown.group(objects, root);
        let placed: Vec<u64> = headers.iter().map(|h| place(h.len())).collect();
        unknown.root = place(group.len());
        unknown.heap = heap.sizes().into_iter().map(place).collect();
        unknown.objects = placed;
        unknown
    }

    /// The parts of the file from the first header on.
    fn encoded(
        &self,
        objects: &[Object],
        scales: &Scales,
        root: &[(String, Property)],
        heap: &mut Heap,
    ) -> Vec<Vec<u8>> {
        scales.refer(&self.objects, heap);
        let mut parts = self.headers(objects, scales);
        parts.push(self.group(objects, root));
        parts.extend(heap.encoded());
        parts
    }

    fn headers(&self, objects: &[Object], scales: &Scales) -> Vec<Vec<u8>> {
        let each = objects.iter().enumerate();
        each.map(|(k, object)| {
            let scale = scales.scale(k, &self.objects);
            let list = scales.list(k, &self.heap);
            object.header(scale.as_ref(), list, &self.heap)
        })
        .collect()
    }

    fn group(&self, objects: &[Object], root: &[(String, Property)]) -> Vec<u8> {
        let mut messages = Messages::default();
        messages.group(objects.len());
        for (order, object) in objects.iter().enumerate() {
            messages.link(order, &object.link, self.objects[order]);
        }
        describe(&mut messages, root, &self.heap);
        messages.header()
    }
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
