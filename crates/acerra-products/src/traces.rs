//! Radar traces for other programs: SEG-Y, and HDF5 with named arrays.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use acerra_cubes::{Dataset, Variable, write_hdf5};
use acerra_formats::segy::{SegyTraces, write_segy};
use acerra_formats::{Axis, Channel, Positions, Values};
use anyhow::Context as _;

use crate::staging::Staging;

/// Formats of traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceFormat {
    /// SEG-Y, revision 1 or 2.
    Segy,
    /// HDF5 (NetCDF-4) with the arrays of a neutral file.
    Hdf5,
}

impl TraceFormat {
    /// Extension of its files.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Segy => "sgy",
            Self::Hdf5 => "h5",
        }
    }
}

/// Reasons why traces cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceFileError {
    /// A file that would be replaced.
    #[error("{}: is there already; remove it or name another directory with -o", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Values that the format does not hold.
    #[error("SEG-Y holds real samples over fast time, found {found}; choose hdf5")]
    NotReal {
        /// Content found.
        found: &'static str,
    },
}

/// Writes traces into `folder` as `name` with the format's extension, and returns the file. `about` are lines on where
/// the traces come from.
///
/// # Errors
/// A file that is there already, values that the format does not hold, a folder that cannot be written.
pub fn write_traces(
    channel: &Channel,
    format: TraceFormat,
    (folder, name): (&Path, &str),
    about: &[String],
) -> anyhow::Result<PathBuf> {
    let name = format!("{name}.{}", format.extension());
    let path = folder.join(&name);
    if path.exists() {
        return Err(TraceFileError::Exists { path }.into());
    }
    let staging = Staging::new(folder)?;
    let failed = || format!("{}: cannot write", path.display());
    let file = File::create(staging.path(&name)).with_context(failed)?;
    let mut file = BufWriter::with_capacity(1 << 20, file);
    match format {
        TraceFormat::Segy => {
            write_segy(&mut file, &segy(channel, about)?).with_context(failed)?;
        }
        TraceFormat::Hdf5 => {
            write_hdf5(&mut file, &dataset(channel, about)).with_context(failed)?
        }
    }
    file.flush().with_context(failed)?;
    drop(file);
    staging.publish()?;
    Ok(path)
}

fn segy<'a>(channel: &'a Channel, about: &'a [String]) -> Result<SegyTraces<'a>, TraceFileError> {
    let not_real = |found| Err(TraceFileError::NotReal { found });
    let (step_s, start_s, samples) = match channel.axis {
        Axis::FastTime {
            start_s,
            step_s,
            samples,
        } => (step_s, start_s, samples),
        Axis::Frequency(_) => return not_real("spectra"),
    };
    let values = match &channel.values {
        Values::Real(values) => values,
        Values::Complex(_) => return not_real("complex samples"),
    };
    Ok(SegyTraces {
        values,
        samples,
        step_s,
        start_s,
        positions: channel.positions.as_ref(),
        antennas_m: channel.antennas_m.as_ref(),
        text: about,
    })
}

/// The arrays by which a neutral file is read.
fn dataset<'a>(channel: &'a Channel, about: &[String]) -> Dataset<'a> {
    let mut dataset = Dataset::default();
    dataset.attribute("source", about.join("\n"));
    dataset.dimension("trace", channel.traces);
    let (name, columns) = match &channel.axis {
        Axis::FastTime {
            start_s,
            step_s,
            samples,
        } => {
            dataset.dimension("sample", *samples);
            for (name, value) in [
                ("sample_interval_s", step_s),
                ("fast_time_start_s", start_s),
            ] {
                dataset.variable(Variable::new(name, &[], vec![*value].into()).with("units", "s"));
            }
            ("data", "sample")
        }
        Axis::Frequency(hz) => {
            dataset.dimension("frequency_hz", hz.len());
            let axis = Variable::new("frequency_hz", &["frequency_hz"], hz.clone().into());
            dataset.variable(axis.with("units", "Hz"));
            ("spectrum", "frequency_hz")
        }
    };
    let values = match &channel.values {
        Values::Real(values) => values.as_slice().into(),
        Values::Complex(values) => values.as_slice().into(),
    };
    dataset.variable(Variable::new(name, &["trace", columns], values));
    let mut by_trace = |name: &str, values: Vec<f64>, unit: &str| {
        let variable = Variable::new(name, &["trace"], values.into());
        dataset.variable(variable.with("units", unit));
    };
    if let Some(time_s) = &channel.time_s {
        by_trace("time_s", time_s.clone(), "s");
    }
    if let Some(along_m) = &channel.along_m {
        by_trace("along_m", along_m.clone(), "m");
    }
    if let Some(Positions::Geodetic(places)) = &channel.positions {
        for (k, (name, unit)) in [
            ("latitude_deg", "degrees_north"),
            ("longitude_deg", "degrees_east"),
            ("height_m", "m"),
        ]
        .into_iter()
        .enumerate()
        {
            by_trace(name, places.iter().map(|p| p[k]).collect(), unit);
        }
    }
    let local = match &channel.positions {
        Some(Positions::Local(places)) => Some(places),
        _ => None,
    };
    let antennas = channel.antennas_m.as_ref();
    let all = [
        ("position_m", local),
        ("transmitter_m", antennas.map(|a| &a[0])),
        ("receiver_m", antennas.map(|a| &a[1])),
    ];
    if all.iter().any(|(_, places)| places.is_some()) {
        dataset.dimension("axis", 3);
    }
    for (name, places) in all {
        if let Some(places) = places {
            let values: Vec<f64> = places.iter().flatten().copied().collect();
            let variable = Variable::new(name, &["trace", "axis"], values.into());
            dataset.variable(variable.with("units", "m"));
        }
    }
    if let Some(apart_m) = channel.antenna_separation_m {
        let variable = Variable::new("antenna_separation_m", &[], vec![apart_m].into());
        dataset.variable(variable.with("units", "m"));
    }
    dataset
}
