//! Files for programs that read arrays: Zarr, NetCDF-4 (HDF5), VTK, phase history data.
//!
//! ```text
//! Outcome ──────────┐
//! run's directory ──┴─RunContents──Dataset──► data.zarr, data.h5
//!                        │    volume.npz, looks.npz ──slice by slice──► data.zarr, volume.vti
//!                        │                    └─VolumeFile─► a plane of it
//!                        └──► image.vti
//! Outcome ──PhaseHistory──► spectra.cphd
//! ```

mod contents;
mod convert;
mod cube;
mod directory;
mod memory;
mod phase_history;
mod stacks;
mod table;
mod volume;
mod vtk;

use std::fs::File;
use std::io::BufWriter;

use acerra_chain::campaign::ProductFormat;
use acerra_cubes::{Hdf5File, ZarrGroup};
use anyhow::Context;

use crate::outcome::Outcome;
use crate::staging::Staging;
pub use contents::ImageContents;
use contents::RunContents;
pub use convert::{ConvertError, convert};
pub use directory::read_image;
use stacks::Stacks;
pub use table::Table;
pub use volume::{Axis, VolumeFile};

/// Name of the Zarr group.
const ZARR: &str = "data.zarr";
/// Name of the HDF5 file.
const HDF5: &str = "data.h5";

/// Writes the formats that the campaign asks for.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    let wanted = |format| outcome.campaign.products.formats.contains(&format);
    let arrays = [ProductFormat::Zarr, ProductFormat::Hdf5, ProductFormat::Vtk];
    let formats: Vec<ProductFormat> = arrays.into_iter().filter(|f| wanted(*f)).collect();
    if !formats.is_empty() {
        let run = memory::contents(outcome, &staging.path("trajectory.csv"))?;
        write_arrays(&run, &formats, &Stacks::of(&staging.folder()), staging)?;
    }
    if wanted(ProductFormat::Cphd) {
        phase_history::write(outcome, staging)?;
    }
    Ok(())
}

/// A format that the campaign requests and the run cannot produce, in words.
pub(crate) fn left_out(outcome: &Outcome) -> Option<String> {
    let is_wanted = outcome
        .campaign
        .products
        .formats
        .contains(&ProductFormat::Cphd);
    let reason = phase_history::why_none(outcome).filter(|_| is_wanted)?;
    Some(format!(
        "[products] formats: no {} is written, as {reason}",
        phase_history::NAME
    ))
}

/// Writes arrays in each of `formats`.
fn write_arrays(
    run: &RunContents<'_>,
    formats: &[ProductFormat],
    stacks: &Stacks,
    staging: &Staging,
) -> anyhow::Result<()> {
    for format in formats {
        match format {
            ProductFormat::Zarr => write_zarr(run, stacks, staging).context(ZARR)?,
            ProductFormat::Hdf5 => {
                write_hdf5(run, stacks, staging).context(HDF5)?;
            }
            ProductFormat::Vtk => vtk::write(run, stacks, staging)?,
            _ => {}
        }
    }
    Ok(())
}

fn write_hdf5(run: &RunContents<'_>, stacks: &Stacks, staging: &Staging) -> anyhow::Result<()> {
    let mut dataset = cube::dataset(run)?;
    stacks.describe(&mut dataset)?;
    let file = File::create(staging.path(HDF5))?;
    let mut file = Hdf5File::create(BufWriter::with_capacity(1 << 20, file))?;
    file.dataset(&dataset)?;
    stacks.write_hdf5(&mut file)?;
    Ok(file.finish(&dataset.attributes)?)
}

fn write_zarr(run: &RunContents<'_>, stacks: &Stacks, staging: &Staging) -> anyhow::Result<()> {
    let mut dataset = cube::dataset(run)?;
    stacks.describe(&mut dataset)?;
    let mut group = ZarrGroup::create(&staging.path(ZARR))?;
    group.dataset(&dataset)?;
    stacks.write_zarr(&mut group)?;
    Ok(group.finish(&dataset.attributes)?)
}
