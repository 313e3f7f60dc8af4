//! Arrays with names, coordinates and units, as programs for data cubes open them.
//!
//! ```text
//! Dataset (variables over named dimensions) ─┬─write_zarr──► Zarr v3 group: xarray, zarr
//!                                            └─write_hdf5──► NetCDF-4 (HDF5): MATLAB, xarray, h5py
//! slices of a volume ─┬─ZarrGroup::stack, Hdf5Stack──► an array of the group, slice by slice
//!                     └─VtiWriter──► VTK image data: ParaView, PyVista
//! ```
//!
//! Attributes follow the Climate and Forecast conventions (CF 1.11): `units`, `long_name`, `standard_name`; a
//! variable named like its only dimension holds the coordinates of that dimension.
//!
//! ```
//! use acerra_cubes::{Attribute, Dataset, Values, Variable, write_zarr};
//!
//! let folder = std::env::temp_dir().join(format!("acerra-cubes-{}", std::process::id()));
//! let mut data = Dataset::default();
//! data.dimension("x", 3);
//! data.attribute("title", Attribute::text("three powers"));
//! let x = Variable::new("x", &["x"], Values::from(vec![0.0, 0.5, 1.0]));
//! data.variable(x.with("units", "m").with("long_name", "east"));
//! data.variable(Variable::new("power", &["x"], Values::from(vec![1.0_f32, 4.0, 2.0])));
//! write_zarr(&folder, &data)?;
//! assert!(folder.join("power/c/0").is_file());
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cut;
mod dataset;
mod error;
mod hdf5;
mod vti;
mod zarr;

pub use dataset::{Attribute, Dataset, StackShape, Values, Variable};
pub use error::CubeError;
pub use hdf5::{Hdf5File, Hdf5Stack, write_hdf5};
pub use vti::{VtiGrid, VtiWriter};
pub use zarr::{StackWriter, TiledArray, ZarrGroup, write_zarr};
