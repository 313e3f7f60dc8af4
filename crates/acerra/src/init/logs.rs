//! The files given, each read and sorted by what it is.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use acerra_chain::position::trajectory_file::{
    TrajectoryFile, TrajectoryFileOptions, read_trajectory_file,
};
use acerra_cphd::read_cphd;
use acerra_gnss::input::{FileKind, Limits, sniff};
use acerra_gnss::{Navigation, ObservationData, read_gnss};
use acerra_radar::{
    Limits as RadarLimits, NeutralContent, OpenError, RadarFile, RadargramOptions, ReadError,
};
use anyhow::{Context, bail, ensure};

/// What was given.
#[derive(Debug, Default)]
pub struct Logs {
    /// Radar logs.
    pub(super) radar: Vec<RadarInput>,
    /// Trajectories.
    pub(super) trajectory: Vec<(PathBuf, TrajectoryFile)>,
    /// Logs of GNSS receivers.
    pub(super) receiver: Vec<Receiver>,
    /// Navigation files.
    pub(super) navigation_files: Vec<PathBuf>,
    /// The navigation data of all files.
    pub(super) navigation: Navigation,
}

/// A radar log.
#[derive(Debug)]
pub(super) struct RadarInput {
    pub path: PathBuf,
    /// Format, traces, interval.
    pub summary: String,
    /// Times of the first and last trace (s), where the file may have those of the trajectory.
    pub time_s: Option<[f64; 2]>,
    /// Whether the file brings the positions of its traces.
    pub has_positions: bool,
    /// Way along the line (m), where the file counts it.
    pub way_m: Option<f64>,
}

/// The log of a GNSS receiver.
#[derive(Debug)]
pub(super) struct Receiver {
    pub path: PathBuf,
    pub observations: ObservationData,
}

impl Logs {
    /// Reads the files.
    ///
    /// # Errors
    /// A file that cannot be read, is of no known kind, or is of no use for a campaign.
    pub fn look(files: &[PathBuf]) -> anyhow::Result<Self> {
        let mut logs = Self::default();
        for path in files {
            logs.take(path)
                .with_context(|| path.display().to_string())?;
        }
        Ok(logs)
    }

    fn take(&mut self, path: &Path) -> anyhow::Result<()> {
        ensure!(!path.is_dir(), "expected a file, found a directory");
        let mut file = File::open(path)?;
        let mut head = Vec::new();
        file.by_ref().take(1 << 16).read_to_end(&mut head)?;
        file.rewind()?;
        ensure!(!head.is_empty(), "the file is empty");
        let reader = BufReader::new(file);
        if acerra_autopilot::sniff(&head).is_some() {
            self.take_trajectory(path, reader)?;
        } else if acerra_cphd::is_cphd(&head) {
            self.radar.push(phase_history(path, reader)?);
        } else if acerra_formats::recognise(path)?.is_some() && !is_log(&head) {
            self.radar.push(foreign(path)?);
        } else if is_radar(&head) {
            let found = radar(path, reader)?;
            self.radar.push(found);
        } else if is_gnss(&head) {
            self.take_gnss(path, reader)?;
        } else if acerra_geo::read::sniff(&head).is_some() {
            self.take_trajectory(path, reader)?;
        } else {
            bail!(
                "not a log that is known; expected a radar log (MRM capture, MRM-RET text, NPZ, CPHD), a \
                 trajectory (.pos, CSV, NMEA, Motive export), a flight log (.bin, .ulg, .tlog, MCAP), \
                 RINEX or UBX"
            );
        }
        Ok(())
    }

    fn take_trajectory(&mut self, path: &Path, reader: impl BufRead) -> anyhow::Result<()> {
        let file = read_trajectory_file(
            reader,
            &TrajectoryFileOptions {
                takes_first_source: true,
                ..TrajectoryFileOptions::default()
            },
        )?;
        self.trajectory.push((path.to_owned(), file));
        Ok(())
    }

    fn take_gnss(&mut self, path: &Path, reader: impl Read) -> anyhow::Result<()> {
        let content = read_gnss(reader, Limits::default())?;
        let has_navigation = content.navigation.is_some();
        if let Some(navigation) = content.navigation {
            self.navigation.merge(navigation);
        }
        match content.observations {
            Some(observations) if !observations.epochs.is_empty() => {
                self.receiver.push(Receiver {
                    path: path.to_owned(),
                    observations,
                });
            }
            _ if has_navigation => self.navigation_files.push(path.to_owned()),
            _ => bail!("neither observations nor navigation data in it"),
        }
        Ok(())
    }
}

fn is_log(head: &[u8]) -> bool {
    let read = acerra_radar::read(Cursor::new(head), &RadarLimits::default());
    matches!(read, Ok(RadarFile::Log(_)))
}

fn foreign(path: &Path) -> anyhow::Result<RadarInput> {
    let recording = acerra_formats::open(path, &acerra_formats::Limits::default())?;
    let channel = recording.channel(None)?;
    let mut summary = format!(
        "{}, {} traces of {} samples",
        recording.format.name(),
        channel.traces,
        channel.axis.samples()
    );
    if recording.channels.len() > 1 {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        summary.push_str(&format!(", channels {}", names.join(", ")));
    }
    Ok(RadarInput {
        path: path.to_owned(),
        summary,
        time_s: None,
        has_positions: channel.positions.is_some(),
        way_m: channel
            .along_m
            .as_ref()
            .and_then(|along| Some(along.last()? - along.first()?)),
    })
}

fn is_radar(head: &[u8]) -> bool {
    let read = acerra_radar::read(Cursor::new(head), &RadarLimits::default());
    !matches!(read, Err(OpenError::Read(ReadError::Unrecognised { .. })))
}

fn is_gnss(head: &[u8]) -> bool {
    matches!(
        sniff(head),
        FileKind::RinexObservation
            | FileKind::RinexNavigation
            | FileKind::RinexOther
            | FileKind::Crinex
            | FileKind::Ubx
            | FileKind::Gzip
    )
}

fn phase_history(path: &Path, reader: impl Read + Seek) -> anyhow::Result<RadarInput> {
    let file = read_cphd(reader, &acerra_cphd::ReadOptions::default())?;
    let channel = file.history.channels.first().context("no channel in it")?;
    let ends = match channel.time_s.as_slice() {
        [first, .., last] => Some([*first, *last]),
        _ => None,
    };
    Ok(RadarInput {
        path: path.to_owned(),
        summary: format!(
            "CPHD phase history, {} pulses of {} frequencies",
            channel.time_s.len(),
            channel.frequency.count
        ),
        time_s: ends,
        has_positions: true,
        way_m: None,
    })
}

fn radar(path: &Path, reader: impl Read + Seek) -> anyhow::Result<RadarInput> {
    let path = path.to_owned();
    match acerra_radar::read(reader, &RadarLimits::default())? {
        RadarFile::Log(log) => {
            let made = log.radargram(&RadargramOptions::default())?;
            let duration_s = made.radargram.time_s.last().copied().unwrap_or(0.0);
            Ok(RadarInput {
                path,
                summary: format!(
                    "{}, {} scans {:.1} ms apart over {duration_s:.1} s, fast time {:.1} to {:.1} ns",
                    log.format,
                    made.radargram.traces,
                    1e3 * made.clock.interval_s,
                    f64::from(made.run.window.start_ps) * 1e-3,
                    f64::from(made.run.window.stop_ps) * 1e-3,
                ),
                time_s: None,
                has_positions: false,
                way_m: None,
            })
        }
        RadarFile::Neutral(neutral) => {
            let time_s = neutral.content.time_s();
            let ends = match (time_s.first(), time_s.last()) {
                (Some(first), Some(last)) if !neutral.time_missing => Some([*first, *last]),
                _ => None,
            };
            let kind = match &neutral.content {
                NeutralContent::Radargram(_) => "NPZ radargram",
                NeutralContent::Spectrum(_) => "NPZ spectra",
            };
            Ok(RadarInput {
                path,
                summary: match ends {
                    Some([first, last]) => {
                        format!("{kind}, {} traces over {:.1} s", time_s.len(), last - first)
                    }
                    None => format!("{kind}, {} traces without times", time_s.len()),
                },
                time_s: ends,
                has_positions: neutral.position_m.is_some(),
                way_m: None,
            })
        }
    }
}
