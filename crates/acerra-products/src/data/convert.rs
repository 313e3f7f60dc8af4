//! A run that is there already, in other formats.

use std::path::{Path, PathBuf};

use acerra_chain::campaign::ProductFormat;
use anyhow::ensure;

use super::{directory, stacks::Stacks, write_arrays};
use crate::names::of_older_run;
use crate::staging::Staging;

/// Reason why a run cannot be converted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// A directory in which no run left its products.
    #[error("{}: expected the directory of a run, found no run.json that Acerra wrote", folder.display())]
    NoRun {
        /// The directory.
        folder: PathBuf,
    },
    /// A format that needs more than a run leaves behind.
    #[error(
        "{format}: a run's directory lacks data of this format; add the format to [products] formats and \
         run the campaign again"
    )]
    NotFromProducts {
        /// The format.
        format: &'static str,
    },
}

/// Writes image, trajectory, targets and volumes of the run in `folder` into `output` in each of
/// `formats`: those that take arrays.
///
/// # Errors
/// A directory without a run, a product that is absent or broken, a format that needs more than a run
/// leaves behind, an output that cannot be written.
pub fn convert(folder: &Path, formats: &[ProductFormat], output: &Path) -> anyhow::Result<()> {
    for format in formats {
        if let Some(format) = needs_more(*format) {
            return Err(ConvertError::NotFromProducts { format }.into());
        }
    }
    if of_older_run(folder).is_empty() {
        let folder = folder.to_owned();
        return Err(ConvertError::NoRun { folder }.into());
    }
    ensure!(
        !formats.is_empty(),
        "expected one format or more, found none"
    );
    let run = directory::contents(folder)?;
    let staging = Staging::new(output)?;
    write_arrays(&run, formats, &Stacks::of(folder), &staging)?;
    staging.publish()
}

/// The name of a format that cannot be made from a run's products.
fn needs_more(format: ProductFormat) -> Option<&'static str> {
    match format {
        ProductFormat::Zarr | ProductFormat::Hdf5 | ProductFormat::Vtk => None,
        ProductFormat::Cphd => Some("cphd"),
        ProductFormat::Geotiff => Some("geotiff"),
        ProductFormat::GeotiffAbsolute => Some("geotiff-absolute"),
        ProductFormat::GeotiffPower => Some("geotiff-power"),
        ProductFormat::GeotiffComplex => Some("geotiff-complex"),
        ProductFormat::Kmz => Some("kmz"),
        ProductFormat::Geojson => Some("geojson"),
    }
}
