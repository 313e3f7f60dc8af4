//! Pixels: a plane, a tilted plane, a surface, a volume.

mod any;
mod axes;
mod part;
mod plane;
mod surface;
mod tilted;
mod volume;

use pyo3::prelude::*;

pub use any::{Grid, grid_of};
pub use plane::Plane;
pub use surface::Surface;
pub use tilted::Tilted;
pub use volume::Volume;

/// Adds the grids to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Plane>()?;
    module.add_class::<Tilted>()?;
    module.add_class::<Surface>()?;
    module.add_class::<Volume>()?;
    module.add_function(wrap_pyfunction!(part::part_of, module)?)
}
