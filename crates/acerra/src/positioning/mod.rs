//! From GNSS files to a rover's positions: reading, positioning, and what there is to say about it.
//!
//! [`run`] is what `acerra ppk` does, and what a campaign's `[gnss]` section asks for.

mod summary;

use std::fs::File;
use std::path::{Path, PathBuf};

use acerra_gnss::input::{Limits, ReadReport};
use acerra_gnss::{
    GnssFile, Navigation, ObservationData, PositioningMode, PpkError, PpkOptions, PpkSolution,
    process, read_gnss,
};
use anyhow::Context;

pub use summary::{
    BaseAnswer, DropAnswer, EventAnswer, FileAnswer, PpkAnswer, ReasonAnswer, answer,
};

/// The files of a positioning run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PositioningInput {
    /// The rover's log.
    pub rover: PathBuf,
    /// The base's log; not needed in single-point mode.
    pub base: Option<PathBuf>,
    /// Navigation files. Raw logs among rover and base bring their own.
    pub navigation: Vec<PathBuf>,
}

/// A finished positioning run.
#[derive(Clone, Debug)]
pub struct Positioning {
    /// The positions and their story.
    pub solution: PpkSolution,
    /// What each file was and what was dropped from it, in the order read.
    pub files: Vec<(PathBuf, ReadReport)>,
    /// Remarks of the readers and of the run, as sentences.
    pub warnings: Vec<String>,
}

/// Reads the files and computes the positions.
///
/// # Errors
/// A file that cannot be read or holds something else than it should, named; and whatever makes a
/// solution impossible ([`PpkError`]), with the file it is about.
pub fn run(input: &PositioningInput, options: &PpkOptions) -> anyhow::Result<Positioning> {
    let mut reader = Reader::default();
    let single = options.mode == PositioningMode::Single;
    let rover = reader.observations(&input.rover)?;
    let mut base = ObservationData::default();
    if let Some(path) = &input.base {
        let file = reader.read(path)?;
        match file.observations {
            Some(observations) => base = observations,
            // A single-point position needs no base: what stands in its place is navigation.
            None if single => {}
            None => anyhow::bail!(
                "{}: expected the base's observations, found {}",
                path.display(),
                file.kind
            ),
        }
    } else if !single {
        anyhow::bail!(
            "a base's log is needed for anything but single-point positions (--mode single)"
        );
    }
    for path in &input.navigation {
        let file = reader.read(path)?;
        anyhow::ensure!(
            file.navigation.is_some(),
            "{}: expected navigation data, found {}",
            path.display(),
            file.kind
        );
    }
    anyhow::ensure!(
        !reader.navigation.ephemerides.is_empty(),
        "no ephemeris in {}: give a navigation file (RINEX, or a UBX log with RXM-SFRBX)",
        reader.names()
    );
    let mut warnings = reader.warnings();
    let solution = process(&rover, &base, &reader.navigation, options)
        .map_err(|error| blame(error, input, &reader))?;
    warnings.extend(solution.summary.warnings.iter().map(ToString::to_string));
    Ok(Positioning {
        solution,
        files: reader.files,
        warnings,
    })
}

/// Puts the file that an error is about before it.
fn blame(error: PpkError, input: &PositioningInput, reader: &Reader) -> anyhow::Error {
    let rover = || input.rover.display().to_string();
    let base = || {
        input
            .base
            .as_deref()
            .map_or_else(rover, |p| p.display().to_string())
    };
    let place = match error {
        PpkError::NoRoverEpochs | PpkError::NoSatellites | PpkError::NothingInWindow { .. } => {
            rover()
        }
        PpkError::NoBaseEpochs
        | PpkError::BasePositionMissing { .. }
        | PpkError::BasePositionImplausible { .. } => base(),
        PpkError::NoNavigation { .. } => reader.names(),
        PpkError::NoOverlap { .. } => format!("{}, {}", rover(), base()),
        _ => return error.into(),
    };
    anyhow::Error::new(error).context(place)
}

/// Takes files and gathers the navigation data in them.
#[derive(Default)]
struct Reader {
    navigation: Navigation,
    files: Vec<(PathBuf, ReadReport)>,
}

impl Reader {
    fn read(&mut self, path: &Path) -> anyhow::Result<GnssFile> {
        let place = || path.display().to_string();
        let file = File::open(path).with_context(place)?;
        let mut content = read_gnss(file, Limits::default()).with_context(place)?;
        if let Some(navigation) = content.navigation.clone() {
            self.navigation.merge(navigation);
        }
        self.files
            .push((path.to_owned(), std::mem::take(&mut content.report)));
        Ok(content)
    }

    fn observations(&mut self, path: &Path) -> anyhow::Result<ObservationData> {
        let file = self.read(path)?;
        file.observations.with_context(|| {
            format!(
                "{}: expected observations, found {}",
                path.display(),
                file.kind
            )
        })
    }

    /// The files read so far, for a message.
    fn names(&self) -> String {
        let names: Vec<String> = self
            .files
            .iter()
            .map(|(p, _)| p.display().to_string())
            .collect();
        names.join(", ")
    }

    /// What the readers noticed, one sentence for each file and reason.
    fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
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

/// Whether a reason speaks of damage, and not only of content that has no use here.
fn is_worth_a_warning(reason: &acerra_gnss::input::DropReason) -> bool {
    use acerra_gnss::input::DropReason::{
        CycleSlipRecord, DuplicateNavigationRecord, OutsideFrames, PhaseNotUsable,
        PseudoObservation, UnknownSignal, UnusedMessage, UnusedNavigationMessage,
    };
    !matches!(
        reason,
        CycleSlipRecord
            | DuplicateNavigationRecord
            | OutsideFrames
            | PhaseNotUsable
            | PseudoObservation(_)
            | UnknownSignal
            | UnusedMessage { .. }
            | UnusedNavigationMessage(_)
    )
}
