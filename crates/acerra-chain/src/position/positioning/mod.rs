//! Positions of a rover from GNSS files: reading, positioning, and remarks.
//!
//! [`run`] serves `acerra ppk` and a campaign's `[gnss]` section.

mod antennas;
mod configuration;
mod error;
mod input;
mod reader;
mod sky;
mod summary;

use std::path::PathBuf;

use acerra_gnss::input::ReadReport;
use acerra_gnss::{ObservationData, PositioningMode, PpkError, PpkOptions, PpkSolution, process};

use reader::Reader;

pub use antennas::{AntennaInput, AntennaName};
pub use configuration::{GnssConfiguration, GnssConfigurationError};
pub use error::PositioningError;
pub use input::PositioningInput;
pub use reader::written;
pub use sky::sky;
pub use summary::{
    BaseAnswer, BaselineAnswer, DropAnswer, EventAnswer, FileAnswer, PpkAnswer, ReasonAnswer,
    answer,
};

/// A finished positioning run.
#[derive(Clone, Debug)]
pub struct Positioning {
    /// The positions and the record of their computation.
    pub solution: PpkSolution,
    /// Kind of each file and its dropped records, in the order read.
    pub files: Vec<(PathBuf, ReadReport)>,
    /// Remarks of the readers and of the run, as sentences.
    pub warnings: Vec<String>,
}

/// Reads the files and computes the positions.
///
/// # Errors
/// A file that cannot be read or has another kind of content, with its name; any cause of a missing solution
/// ([`PpkError`]), with the files concerned.
pub fn run(
    input: &PositioningInput,
    options: &PpkOptions,
) -> Result<Positioning, PositioningError> {
    let mut reader = Reader::new(input);
    let single = options.mode == PositioningMode::Single;
    let mut rover = reader.receiver(&input.rover_files(), "observations")?;
    let mut base = ObservationData::default();
    let base_files = input.base_files();
    if single && reader.holds_no_observations(input.base.as_deref())? {
        // A single-point position needs no base; a navigation file may be given in place of the base.
    } else if input.base.is_some() {
        base = reader.receiver(&base_files, "the base's observations")?;
    } else if !single {
        return Err(PositioningError::NoBase);
    }
    for path in &input.navigation {
        let file = reader.read(path)?;
        if file.navigation.is_none() {
            return Err(PositioningError::Kind {
                path: path.clone(),
                expected: "navigation data",
                found: file.kind.to_string(),
            });
        }
    }
    reader.complete(&input.rover_files(), &mut rover)?;
    reader.complete(&base_files, &mut base)?;
    if reader.navigation.is_empty() {
        return Err(PositioningError::NoEphemeris {
            files: reader.names(),
        });
    }
    if input.needs_precise_orbits && reader.navigation.precise.is_empty() {
        return Err(PositioningError::NoPreciseOrbits);
    }
    let mut warnings = reader.warnings();
    let options = &input
        .antennas
        .apply(options, [&rover, &base], &mut warnings)?;
    let solution = process(&rover, &base, &reader.navigation, options)
        .map_err(|error| blame(error, input, &reader))?;
    warnings.extend(solution.summary.warnings.iter().map(ToString::to_string));
    Ok(Positioning {
        solution,
        files: reader.files,
        warnings,
    })
}

/// Adds the name of the file concerned to an error.
fn blame(error: PpkError, input: &PositioningInput, reader: &Reader) -> PositioningError {
    let rover = || input.rover.display().to_string();
    let base = || {
        input
            .base
            .as_deref()
            .map_or_else(rover, |p| p.display().to_string())
    };
    let files = match error {
        PpkError::NoRoverEpochs | PpkError::NoSatellites | PpkError::NothingInWindow { .. } => {
            rover()
        }
        PpkError::NoBaseEpochs
        | PpkError::BasePositionMissing { .. }
        | PpkError::BasePositionImplausible { .. } => base(),
        PpkError::NoNavigation { .. } => reader.names(),
        PpkError::NoOverlap { .. } => format!("{}, {}", rover(), base()),
        _ => return PositioningError::Process(error),
    };
    PositioningError::Solution {
        files,
        cause: error,
    }
}
