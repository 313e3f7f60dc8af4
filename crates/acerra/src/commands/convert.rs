//! `acerra convert`: a run's products, or the traces of a radar log, in other formats.

use std::io::Write;
use std::path::{Path, PathBuf};

use acerra_chain::campaign::{Campaign, ProductFormat};
use acerra_chain::read::read_raw;
use acerra_chain::{Control, Journal, Warnings};
use acerra_formats::Channel;
use acerra_products::data::convert;
use acerra_products::traces::{TraceFormat, write_traces};
use anyhow::{Context, bail, ensure};
use clap::ValueEnum;

use crate::interrupt::cancel_flag;
use crate::progress::Bar;
use crate::terminal::{Verbosity, verbosity};

/// Write the products of a run, or the traces of a radar log, in other formats.
///
/// From the directory that `acerra focus` wrote, the image, the trajectory, the targets and the volume are
/// converted. The directory lacks radargrams and spectra: for these, and for phase history data (CPHD), name
/// the formats in `[products] formats` of the campaign.
///
/// Of a radar log of any maker: its traces as recorded, every sample, with places and sample interval. Of a campaign:
/// the traces as they are cleaned for the image, at the places that they have there. An existing file is kept.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra convert flight-products --formats zarr
  acerra convert flight-products --formats hdf5,vtk -o for-matlab
  acerra convert line-01.rd3 --formats segy
  acerra convert flight.toml --formats segy,hdf5 -o cleaned")]
pub struct Args {
    /// The directory of a run, a radar log, or a campaign.
    #[arg(value_name = "DIRECTORY|FILE")]
    input: PathBuf,
    /// The formats, with commas between them.
    #[arg(short, long, value_enum, value_delimiter = ',', required = true)]
    formats: Vec<Format>,
    /// Write the files into this directory instead of the run's, or the log's.
    #[arg(short, long, value_name = "DIRECTORY")]
    output: Option<PathBuf>,
    /// The channel of a radar log that has several; by default the first.
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
}

/// Formats that products or traces can be converted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// data.zarr: a Zarr v3 group, for xarray; of a run.
    Zarr,
    /// data.h5: NetCDF-4 (HDF5), for MATLAB and xarray; of a run or a radar log.
    Hdf5,
    /// image.vti and volume.vti: for ParaView; of a run.
    Vtk,
    /// SEG-Y, for programs of ground-penetrating radar; of a radar log.
    Segy,
}

impl Format {
    fn of_products(self) -> anyhow::Result<ProductFormat> {
        Ok(match self {
            Self::Zarr => ProductFormat::Zarr,
            Self::Hdf5 => ProductFormat::Hdf5,
            Self::Vtk => ProductFormat::Vtk,
            Self::Segy => bail!(
                "segy: a run's directory does not hold traces; name the radar log, or the campaign for cleaned traces"
            ),
        })
    }

    fn of_traces(self) -> anyhow::Result<TraceFormat> {
        match self {
            Self::Segy => Ok(TraceFormat::Segy),
            Self::Hdf5 => Ok(TraceFormat::Hdf5),
            Self::Zarr | Self::Vtk => {
                bail!("zarr and vtk take the directory of a run; traces become segy or hdf5")
            }
        }
    }
}

/// Runs the command.
///
/// # Errors
/// A directory without a run, a log or a campaign that cannot be read, a product that is absent or broken, an output
/// that is there already or cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut formats = args.formats.clone();
    let mut seen = Vec::new();
    formats.retain(|format| {
        let is_new = !seen.contains(format);
        seen.push(*format);
        is_new
    });
    if args.input.is_file() {
        return of_traces(args, &formats, out);
    }
    ensure!(
        args.channel.is_none(),
        "--channel: expected a radar log, found {}",
        args.input.display()
    );
    let formats: Vec<ProductFormat> = formats
        .into_iter()
        .map(Format::of_products)
        .collect::<anyhow::Result<_>>()?;
    let output = args.output.as_ref().unwrap_or(&args.input);
    convert(&args.input, &formats, output)?;
    if verbosity() > Verbosity::Quiet {
        writeln!(out, "converted into {}", output.display())?;
    }
    Ok(())
}

/// Traces to write, with the end of their file's name.
type Named = (String, Channel);

fn of_traces(args: &Args, formats: &[Format], out: &mut dyn Write) -> anyhow::Result<()> {
    let formats: Vec<TraceFormat> = formats
        .iter()
        .map(|format| format.of_traces())
        .collect::<anyhow::Result<_>>()?;
    let path = &args.input;
    let mut warnings = Warnings::default();
    let is_campaign = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
        && acerra_formats::recognise(path)?.is_none();
    let all = if is_campaign {
        ensure!(
            args.channel.is_none(),
            "--channel: expected a radar log, found a campaign, which names its channel ([radar] channel)"
        );
        cleaned(path)?
    } else {
        let channel = read_raw(path, args.channel.as_deref(), &mut warnings)?;
        vec![(String::new(), channel)]
    };
    let folder = match (&args.output, path.parent()) {
        (Some(folder), _) => folder.as_path(),
        (None, Some(folder)) if !folder.as_os_str().is_empty() => folder,
        (None, _) => Path::new("."),
    };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let what = if is_campaign { "cleaned by" } else { "from" };
    let about = [
        format!("Written by Acerra {}", env!("CARGO_PKG_VERSION")),
        format!("Traces {what} {stem}"),
    ];
    for (end, channel) in &all {
        for format in &formats {
            let place = (folder, format!("{stem}{end}"));
            let file = write_traces(channel, *format, (place.0, &place.1), &about)?;
            if verbosity() > Verbosity::Quiet {
                writeln!(
                    out,
                    "{}: {} traces of {} {}",
                    file.display(),
                    channel.traces,
                    channel.axis.samples(),
                    match channel.axis {
                        acerra_formats::Axis::FastTime { .. } => "samples",
                        acerra_formats::Axis::Frequency(_) => "frequencies",
                    }
                )?;
            }
        }
    }
    if verbosity() > Verbosity::Quiet {
        for warning in warnings.said() {
            writeln!(out, "warning: {warning}")?;
        }
        for note in warnings.notes() {
            writeln!(out, "note: {note}")?;
        }
    }
    Ok(())
}

/// The traces of each track of a campaign as they enter the image.
fn cleaned(path: &Path) -> anyhow::Result<Vec<Named>> {
    let place = || path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(place)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let campaign = Campaign::parse(&text)
        .with_context(place)?
        .resolved_in(folder);
    let bar = Bar::default();
    let control = Control::default()
        .reporting_to(&bar)
        .cancelled_by(cancel_flag());
    let prepared = (campaign.survey()).prepare(&mut Journal::default(), &control);
    bar.clear();
    let prepared = prepared?;
    let is_one = prepared.tracks.len() == 1;
    let of_track = |track: &acerra_chain::Track| {
        let end = if is_one {
            "-cleaned".to_owned()
        } else {
            let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_');
            let name = track.name.chars();
            let plain: String = name.map(|c| if is_plain(c) { c } else { '_' }).collect();
            format!("-cleaned-{plain}")
        };
        let channel = prepared.cleaned_channel(track).with_context(|| {
            format!(
                "{}: expected traces over fast time, found spectra, which are not cleaned",
                track.name
            )
        })?;
        Ok((end, channel))
    };
    prepared.tracks.iter().map(of_track).collect()
}
