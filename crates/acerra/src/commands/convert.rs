//! `acerra convert`: a run's products in other formats.

use std::io::Write;
use std::path::PathBuf;

use acerra_chain::campaign::ProductFormat;
use acerra_products::data::convert;
use clap::ValueEnum;

use crate::terminal::{Verbosity, verbosity};

/// Write the image, trajectory, targets and volume of a run in other formats.
///
/// Reads the directory that `acerra focus` wrote, and computes nothing new. Radargrams and spectra are
/// not in it: name the formats in `[products] formats` of the campaign to have them too, and for phase
/// history data (CPHD).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra convert flight-products --formats zarr
  acerra convert flight-products --formats hdf5,vtk -o for-matlab")]
pub struct Args {
    /// The directory of a run.
    #[arg(value_name = "DIRECTORY")]
    run: PathBuf,
    /// The formats, with commas between them.
    #[arg(short, long, value_enum, value_delimiter = ',', required = true)]
    formats: Vec<Format>,
    /// Write the files into this directory instead of the run's.
    #[arg(short, long, value_name = "DIRECTORY")]
    output: Option<PathBuf>,
}

/// Formats that a run's products can be converted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// data.zarr: a Zarr v3 group, for xarray.
    Zarr,
    /// data.h5: NetCDF-4 (HDF5), for MATLAB and xarray.
    Hdf5,
    /// image.vti and volume.vti: for ParaView.
    Vtk,
}

impl From<Format> for ProductFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Zarr => Self::Zarr,
            Format::Hdf5 => Self::Hdf5,
            Format::Vtk => Self::Vtk,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// A directory without a run, a product that is absent or broken, an output that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut formats: Vec<ProductFormat> = Vec::new();
    for format in args
        .formats
        .iter()
        .map(|format| ProductFormat::from(*format))
    {
        if !formats.contains(&format) {
            formats.push(format);
        }
    }
    let output = args.output.as_ref().unwrap_or(&args.run);
    convert(&args.run, &formats, output)?;
    if verbosity() > Verbosity::Quiet {
        writeln!(out, "converted into {}", output.display())?;
    }
    Ok(())
}
