//! Reading the files of a run: several files a receiver, and dates and channels that one file gives for
//! another.

use std::fs::File;
use std::path::{Path, PathBuf};

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, Limits, ReadError, ReadReport};
use acerra_gnss::rtcm::RtcmHints;
use acerra_gnss::{
    Ephemeris, GnssFile, LogPart, Navigation, ObservationData, join_logs, read_gnss_near,
};

use super::error::PositioningError;
use super::input::PositioningInput;

/// Time at which a file was last written, an upper bound of the content's time. `None` where the system does
/// not state the time.
///
/// ```
/// use acerra_chain::position::positioning::written;
/// let time = written(&std::fs::File::open("Cargo.toml")?).unwrap();
/// assert!(time.week() > 2200);
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn written(file: &File) -> Option<GpsTime> {
    let modified = file.metadata().ok()?.modified().ok()?;
    let since_1970 = modified.duration_since(std::time::UNIX_EPOCH).ok()?;
    Some(GpsTime::from_unix(
        i64::try_from(since_1970.as_secs()).ok()?,
        0.0,
    ))
}

/// Reader of files that gathers their navigation data.
#[derive(Default)]
pub(super) struct Reader {
    pub(super) navigation: Navigation,
    pub(super) files: Vec<(PathBuf, ReadReport)>,
    hints: RtcmHints,
    /// Every file of the run, among which dates are searched.
    all: Vec<PathBuf>,
    remarks: Vec<String>,
}

impl Reader {
    /// A reader of these files with the stated date.
    pub(super) fn new(input: &PositioningInput) -> Self {
        let mut reader = Self {
            all: input.rover_files(),
            ..Self::default()
        };
        reader.all.extend(input.base_files());
        reader.all.extend_from_slice(&input.navigation);
        reader.hints.near = input.date;
        reader
    }

    /// Opens a file; a file without a week takes the week of the first other file that has one.
    fn open_dated(&mut self, path: &Path) -> Result<GnssFile, PositioningError> {
        match self.open(path) {
            Err(PositioningError::Date { .. }) if self.hints.near.is_none() => {}
            other => return other,
        }
        let near = {
            let others = self.all.iter().filter(|other| *other != path);
            let mut opened = others.filter_map(|other| self.open(other).ok());
            opened.find_map(|file| time_of(&file))
        };
        self.hints.near = near;
        self.open(path)
    }

    fn open(&self, path: &Path) -> Result<GnssFile, PositioningError> {
        let path = || path.to_owned();
        let file = File::open(path()).map_err(|cause| PositioningError::Open {
            path: path(),
            cause,
        })?;
        let mut hints = self.hints.clone();
        hints.not_after = written(&file);
        read_gnss_near(file, Limits::default(), &hints).map_err(|cause| match cause {
            ReadError::NoDate => PositioningError::Date {
                path: path(),
                cause,
            },
            cause => PositioningError::Content {
                path: path(),
                cause,
            },
        })
    }

    /// Whether a file, if there is one, holds navigation data only.
    pub(super) fn holds_no_observations(
        &mut self,
        path: Option<&Path>,
    ) -> Result<bool, PositioningError> {
        let Some(path) = path else { return Ok(false) };
        let file = self.open_dated(path)?;
        let only_navigation = file.observations.is_none();
        if only_navigation {
            self.take(path, file);
        }
        Ok(only_navigation)
    }

    /// Reads a file and gathers its navigation data.
    pub(super) fn read(&mut self, path: &Path) -> Result<GnssFile, PositioningError> {
        let file = self.open_dated(path)?;
        Ok(self.take(path, file))
    }

    fn take(&mut self, path: &Path, mut file: GnssFile) -> GnssFile {
        self.hints.near = self.hints.near.or_else(|| time_of(&file));
        if let Some(navigation) = file.navigation.clone() {
            for e in &navigation.ephemerides {
                if let Ephemeris::Glonass(e) = e {
                    let number = e.satellite.number();
                    self.hints.glonass_channels.insert(number, e.channel);
                }
            }
            self.navigation.merge(navigation);
        }
        if let Some(observations) = &file.observations {
            let channels = observations.glonass_channels.iter();
            self.hints
                .glonass_channels
                .extend(channels.map(|(k, v)| (*k, *v)));
        }
        self.files
            .push((path.to_owned(), std::mem::take(&mut file.report)));
        file
    }

    /// The log of one receiver, joined from its files.
    pub(super) fn receiver(
        &mut self,
        paths: &[PathBuf],
        expected: &'static str,
    ) -> Result<ObservationData, PositioningError> {
        let mut parts = Vec::with_capacity(paths.len());
        for path in paths {
            let file = self.read(path)?;
            let data = file.observations.ok_or_else(|| PositioningError::Kind {
                path: path.clone(),
                expected,
                found: file.kind.to_string(),
            })?;
            parts.push(LogPart {
                name: path.display().to_string(),
                data,
            });
        }
        let (joined, remarks) = join_logs(parts);
        self.remarks.extend(remarks.iter().map(ToString::to_string));
        Ok(joined)
    }

    /// Reads a receiver's files again where GLONASS phases lacked a frequency channel that was given by a
    /// file read later.
    pub(super) fn complete(
        &mut self,
        paths: &[PathBuf],
        data: &mut ObservationData,
    ) -> Result<(), PositioningError> {
        let lacking = self.files.iter().any(|(path, report)| {
            paths.contains(path) && report.count(&DropReason::UnknownChannel) > 0
        });
        let known = &data.glonass_channels;
        let hinted = self.hints.glonass_channels.keys();
        if !lacking || hinted.clone().all(|number| known.contains_key(number)) {
            return Ok(());
        }
        let mut parts = Vec::new();
        for path in paths {
            let file = self.open(path)?;
            for (of, report) in &mut self.files {
                if of == path {
                    report.clone_from(&file.report);
                }
            }
            parts.push(LogPart {
                name: path.display().to_string(),
                data: file.observations.unwrap_or_default(),
            });
        }
        *data = join_logs(parts).0;
        Ok(())
    }

    /// The files read so far, for a message.
    pub(super) fn names(&self) -> String {
        let names: Vec<String> = self
            .files
            .iter()
            .map(|(p, _)| p.display().to_string())
            .collect();
        names.join(", ")
    }

    /// Remarks of the readers, one sentence for each file and reason.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut out = self.remarks.clone();
        for (path, report) in &self.files {
            let name = path.display();
            out.extend(
                report
                    .remarks
                    .iter()
                    .map(|remark| format!("{name}: {remark}")),
            );
            out.extend(
                report
                    .dropped
                    .iter()
                    .filter(|d| is_worth_a_warning(&d.reason))
                    .map(|d| {
                        format!(
                            "{name}: dropped for {}: {}, first at {}",
                            d.reason, d.count, d.first
                        )
                    }),
            );
        }
        out
    }
}

/// Whether a reason means damage, and not only unused content.
fn is_worth_a_warning(reason: &DropReason) -> bool {
    use DropReason::{
        CycleSlipRecord, DuplicateNavigationRecord, OutsideFrames, OutsideMessages, PhaseNotUsable,
        PseudoObservation, UnknownSignal, UnusedMessage, UnusedNavigationMessage,
        UnusedRtcmMessage,
    };
    !matches!(
        reason,
        CycleSlipRecord
            | DuplicateNavigationRecord
            | OutsideFrames
            | OutsideMessages
            | PhaseNotUsable
            | PseudoObservation(_)
            | UnknownSignal
            | UnusedMessage { .. }
            | UnusedNavigationMessage(_)
            | UnusedRtcmMessage { .. }
    )
}

/// Any time in a file.
fn time_of(file: &GnssFile) -> Option<GpsTime> {
    let observed = file.observations.as_ref().and_then(|o| o.epochs.first());
    let broadcast = file.navigation.as_ref().and_then(|n| n.ephemerides.first());
    observed
        .map(|epoch| epoch.time)
        .or_else(|| broadcast.map(Ephemeris::toe))
}
