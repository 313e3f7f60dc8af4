//! A radar log as it was recorded, for other programs.

use std::io::BufReader;
use std::path::Path;

use acerra_formats::{Axis, Channel, Positions as Places, Values};
use acerra_geo::trajectory::Frame;
use acerra_radar::{RadarFile, Radargram, RadargramOptions, Samples};
use num_complex::Complex32;

use super::foreign::ForeignError;
use super::trace_positions::TracePositions;
use super::{Kind, RadarContent, RadarData, ReadError, kind_of, read_channel, warn_of_left_out};
use crate::journal::warnings::Warnings;

/// Reads the traces of a radar log, every one and unchanged: of the named channel, or of the first.
///
/// # Errors
/// As [`read_channel`].
pub fn read_raw(
    path: &Path,
    channel: Option<&str>,
    warnings: &mut Warnings,
) -> Result<Channel, ReadError> {
    let (kind, file) = kind_of(path)?;
    match kind {
        Kind::Foreign => {
            let failed = |cause| ReadError::Foreign {
                path: path.to_owned(),
                cause: Box::new(ForeignError::Format(cause)),
            };
            let limits = acerra_formats::Limits::default();
            let recording = acerra_formats::open(path, &limits).map_err(failed)?;
            let chosen = recording.channel(channel).map_err(failed)?;
            if channel.is_none() && recording.channels.len() > 1 {
                warnings.add(format!(
                    "channel {} of {}; --channel names another",
                    chosen.name,
                    recording.channels.len()
                ));
            }
            Ok(chosen.clone())
        }
        // Cleaning leaves out scans that a log of the file's own kind keeps.
        Kind::Own if channel.is_none() => {
            let limits = acerra_radar::Limits::default();
            let content = acerra_radar::read(BufReader::new(file), &limits).map_err(|cause| {
                ReadError::Content {
                    path: path.to_owned(),
                    cause,
                }
            })?;
            let RadarFile::Log(log) = content else {
                return read_channel(path, None, None, warnings).map(RadarData::into_channel);
            };
            let made = log
                .radargram(&RadargramOptions::default())
                .map_err(|cause| ReadError::Scans {
                    path: path.to_owned(),
                    cause,
                })?;
            warn_of_left_out(made.other_scans, warnings);
            Ok(channel_of(made.radargram))
        }
        _ => read_channel(path, channel, None, warnings).map(RadarData::into_channel),
    }
}

impl RadarData {
    /// The traces as a file of another kind holds them.
    fn into_channel(self) -> Channel {
        let mut channel = match self.content {
            RadarContent::Radargram(radargram) => channel_of(radargram),
            RadarContent::Spectrum(spectrum) => {
                let narrow = |z: &num_complex::Complex64| Complex32::new(z.re as f32, z.im as f32);
                let values = spectrum.values.iter().map(narrow).collect();
                Channel {
                    traces: spectrum.time_s.len(),
                    axis: Axis::Frequency(spectrum.frequency_hz),
                    values: Values::Complex(values),
                    time_s: Some(spectrum.time_s),
                    ..empty()
                }
            }
        };
        if self.is_untimed {
            channel.time_s = None;
        }
        if let Some(places) = self.positions {
            place(&mut channel, places);
        }
        channel
    }
}

/// A channel of a radargram's traces.
pub(crate) fn channel_of(radargram: Radargram) -> Channel {
    Channel {
        traces: radargram.traces,
        axis: Axis::FastTime {
            start_s: radargram.fast_time_start_s,
            step_s: radargram.fast_time_step_s,
            samples: radargram.samples_per_trace,
        },
        values: match radargram.samples {
            Samples::Real(values) => Values::Real(values),
            Samples::Complex(values) => Values::Complex(values),
        },
        time_s: Some(radargram.time_s),
        ..empty()
    }
}

/// Gives traces their places: on the Earth where their frame is.
pub(crate) fn place(channel: &mut Channel, places: TracePositions) {
    channel.positions = Some(match places.frame {
        Frame::Enu(frame) => {
            let on_earth = |p: &[f64; 3]| {
                let at = frame.geodetic_from_enu(*p);
                [at.latitude_deg(), at.longitude_deg(), at.height_m]
            };
            Places::Geodetic(places.position_m.iter().map(on_earth).collect())
        }
        _ => {
            channel.antennas_m = places.antennas_m;
            Places::Local(places.position_m)
        }
    });
}

fn empty() -> Channel {
    Channel {
        name: "1".to_owned(),
        traces: 0,
        axis: Axis::Frequency(Vec::new()),
        values: Values::Real(Vec::new()),
        time_s: None,
        along_m: None,
        positions: None,
        antenna_separation_m: None,
        antenna_frequency: None,
        antennas_m: None,
    }
}
