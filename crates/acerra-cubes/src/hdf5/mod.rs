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
mod file;
mod heap;
mod layout;
mod object;
mod out;
mod record;
mod scale;
mod scales;
mod stack;

pub use file::{Hdf5File, write_hdf5};
pub use stack::Hdf5Stack;
