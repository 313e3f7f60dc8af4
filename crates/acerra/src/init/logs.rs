//! The given files, read and sorted by kind.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use acerra_chain::Warnings;
use acerra_chain::look::match_motion;
use acerra_chain::position::trajectory_file::{
    TrajectoryFile, TrajectoryFileError, TrajectoryFileOptions, TrajectoryReport,
    read_trajectory_file,
};
use acerra_chain::read::{RadarContent, read_radar};
use acerra_cphd::read_cphd;
use acerra_geo::read::{ReadError as TextError, TrajectoryFormat};
use acerra_geo::trajectory::TimeOrigin;
use acerra_gnss::input::{FileKind, Limits, sniff};
use acerra_gnss::{Navigation, ObservationData, read_gnss};
use acerra_radar::clean::{Background, remove_background};
use acerra_radar::quality::spectrum_occupancy;
use acerra_radar::{
    Limits as RadarLimits, NeutralContent, OpenError, RadarFile, Radargram, RadargramOptions,
    ReadError,
};
use anyhow::{Context, bail, ensure};

use super::sounding::Sounding;

/// What was given.
#[derive(Debug, Default)]
pub struct Logs {
    /// Radar logs.
    pub(super) radar: Vec<RadarInput>,
    /// Trajectories.
    pub(super) trajectory: Vec<(PathBuf, TrajectoryFile)>,
    /// The rigid body taken of a motion capture that holds several, and why.
    pub(super) body: Option<Body>,
    /// Motion captures with several rigid bodies, until one is chosen.
    captures: Vec<Capture>,
    /// Logs of GNSS receivers.
    pub(super) receiver: Vec<Receiver>,
    /// Navigation files.
    pub(super) navigation_files: Vec<PathBuf>,
    /// The navigation data of all files.
    pub(super) navigation: Navigation,
}

/// A rigid body that was chosen.
#[derive(Debug)]
pub(super) struct Body {
    pub name: String,
    pub reason: String,
}

/// A motion capture with several rigid bodies, each read by itself.
#[derive(Debug)]
struct Capture {
    path: PathBuf,
    bodies: Vec<(String, TrajectoryFile)>,
}

/// Least correlation of the radar's own motion with the change of the echoes, and least margin over every
/// other body's.
const LEAST_CORRELATION: f64 = 0.4;
const LEAST_LEAD: f64 = 0.1;

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
    /// Distance along the line (m), where the file gives it.
    pub way_m: Option<f64>,
    /// Whether another maker's radar wrote it.
    pub is_foreign: bool,
    /// Distance between transmitter and receiver (m), where the file states it.
    pub antenna_separation_m: Option<f64>,
    /// Band that its echoes occupy (GHz), where that is not the default radar's.
    pub band_ghz: Option<[f64; 2]>,
    /// Content for an image below the surface, of a radargram of another maker's.
    pub sounding: Option<Sounding>,
    /// Its traces over fast time, where it holds some without positions.
    pub radargram: Option<Radargram>,
}

/// The log of a GNSS receiver.
#[derive(Debug)]
pub(super) struct Receiver {
    pub path: PathBuf,
    pub observations: ObservationData,
}

impl Logs {
    /// Whether no positions were given but a table of places by trace number.
    pub(super) fn has_no_clock(&self) -> bool {
        let by_number = match self.trajectory.as_slice() {
            [] => true,
            [(_, table)] => table.trajectory.time_origin() == TimeOrigin::TraceNumbers,
            _ => false,
        };
        by_number && self.receiver.is_empty()
    }

    /// Reads the files; of a motion capture with several rigid bodies the one of that name, or the one whose
    /// motion agrees with the echoes.
    ///
    /// # Errors
    /// A file that cannot be read, is of no known kind, or is of no use for a campaign; several rigid bodies of which
    /// none alone moves with the echoes.
    pub fn look(files: &[PathBuf], rigid_body: Option<&str>) -> anyhow::Result<Self> {
        let mut logs = Self::default();
        for path in files {
            logs.take(path, rigid_body)
                .with_context(|| path.display().to_string())?;
        }
        for capture in std::mem::take(&mut logs.captures) {
            let path = capture.path.clone();
            logs.choose_body(capture)
                .with_context(|| path.display().to_string())?;
        }
        Ok(logs)
    }

    /// Takes the rigid body whose speed goes with the change of the echoes.
    fn choose_body(&mut self, capture: Capture) -> anyhow::Result<()> {
        let radargram = self.radar.iter().find_map(|r| r.radargram.as_ref());
        let correlation = |file: &TrajectoryFile| {
            let matched = match_motion(radargram?, &file.trajectory);
            Some(matched.map_or(0.0, |m| m.correlation))
        };
        let mut ranked: Vec<(f64, String, TrajectoryFile)> = capture
            .bodies
            .into_iter()
            .map(|(name, file)| (correlation(&file).unwrap_or(0.0), name, file))
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let listed: Vec<String> = ranked
            .iter()
            .map(|(r, name, _)| format!("{name} ({r:.2})"))
            .collect();
        let listed = listed.join(", ");
        let lead = match ranked.as_slice() {
            [first, second, ..] => first.0 - second.0,
            _ => 1.0,
        };
        let is_clear =
            lead >= LEAST_LEAD && ranked.first().is_some_and(|b| b.0 >= LEAST_CORRELATION);
        ensure!(
            is_clear,
            "several rigid bodies, none of which alone moves with the echoes (correlation of speed and change): \
             {listed}; choose with --rigid-body NAME"
        );
        let (_, name, file) = ranked.swap_remove(0);
        self.body = Some(Body {
            name,
            reason: format!(
                "the rigid body whose speed goes with the change of the echoes (correlation): {listed}"
            ),
        });
        self.trajectory.push((capture.path, file));
        Ok(())
    }

    fn take(&mut self, path: &Path, rigid_body: Option<&str>) -> anyhow::Result<()> {
        ensure!(!path.is_dir(), "expected a file, found a directory");
        let mut file = File::open(path)?;
        let mut head = Vec::new();
        file.by_ref().take(1 << 16).read_to_end(&mut head)?;
        file.rewind()?;
        ensure!(!head.is_empty(), "the file is empty");
        let reader = BufReader::new(file);
        if acerra_autopilot::sniff(&head).is_some() {
            self.take_trajectory(path, reader, rigid_body)?;
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
            self.take_trajectory(path, reader, rigid_body)?;
        } else {
            bail!(
                "not a log that is known; expected a radar log (MRM capture, MRM-RET text, NPZ, CPHD), a \
                 trajectory (.pos, CSV, NMEA, Motive export), a flight log (.bin, .ulg, .tlog, MCAP), \
                 RINEX or UBX"
            );
        }
        Ok(())
    }

    fn take_trajectory(
        &mut self,
        path: &Path,
        reader: impl BufRead,
        rigid_body: Option<&str>,
    ) -> anyhow::Result<()> {
        let options = |rigid_body: Option<&str>| TrajectoryFileOptions {
            rigid_body: rigid_body.map(str::to_owned),
            takes_first_source: true,
            trace_numbers: true,
            ..TrajectoryFileOptions::default()
        };
        match read_trajectory_file(reader, &options(rigid_body)) {
            Ok(file) => {
                if let (TrajectoryReport::Text(report), Some(name)) = (&file.report, rigid_body)
                    && report.format == TrajectoryFormat::Motive
                {
                    self.body = Some(Body {
                        name: name.to_owned(),
                        reason: "as --rigid-body says".to_owned(),
                    });
                }
                self.trajectory.push((path.to_owned(), file));
            }
            Err(TrajectoryFileError::Text(TextError::SeveralBodies { names })) => {
                let read = |name: String| {
                    let reader = BufReader::new(File::open(path)?);
                    let file = read_trajectory_file(reader, &options(Some(&name)))?;
                    Ok((name, file))
                };
                let bodies = names.into_iter().map(read).collect::<anyhow::Result<_>>()?;
                self.captures.push(Capture {
                    path: path.to_owned(),
                    bodies,
                });
            }
            Err(error) => return Err(error.into()),
        }
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
        is_foreign: true,
        antenna_separation_m: channel.antenna_separation_m,
        band_ghz: occupied_ghz(path),
        sounding: Sounding::of(&recording, channel),
        radargram: None,
    })
}

/// Band that the echoes of a radargram occupy once the mean of its traces is removed (GHz, the upper end to three
/// digits and the lower end to as many decimals). Frequencies of which the record holds no whole period are left out.
fn occupied_ghz(path: &Path) -> Option<[f64; 2]> {
    let data = read_radar(path, &mut Warnings::default()).ok()?;
    let RadarContent::Radargram(radargram) = data.content else {
        return None;
    };
    let window_s = radargram.samples_per_trace as f64 * radargram.fast_time_step_s;
    let echoes = remove_background(radargram, Background::Mean).ok()?;
    let [low_hz, high_hz] = spectrum_occupancy(&echoes)?.band_hz;
    let decimals = (2 - (1e-9 * high_hz).log10().floor() as i32).clamp(0, 9);
    let unit = 10f64.powi(decimals);
    let band_ghz =
        [low_hz.max(window_s.recip()), high_hz].map(|hz| (1e-9 * hz * unit).round() / unit);
    (band_ghz[0] > 0.0 && band_ghz[0] < band_ghz[1]).then_some(band_ghz)
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
        is_foreign: false,
        antenna_separation_m: None,
        band_ghz: None,
        sounding: None,
        radargram: None,
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
                is_foreign: false,
                antenna_separation_m: None,
                band_ghz: None,
                sounding: None,
                radargram: Some(made.radargram),
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
                is_foreign: false,
                antenna_separation_m: None,
                band_ghz: None,
                sounding: None,
                radargram: match neutral.content {
                    NeutralContent::Radargram(radargram) if neutral.position_m.is_none() => {
                        Some(radargram)
                    }
                    _ => None,
                },
            })
        }
    }
}
