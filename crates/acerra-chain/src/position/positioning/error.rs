//! Reasons why positions cannot be computed from GNSS logs.

use std::io;
use std::path::PathBuf;

use acerra_gnss::PpkError;
use acerra_gnss::input::ReadError;

/// Reason for which positions cannot be computed from GNSS logs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PositioningError {
    /// The operating system does not open the file.
    #[error("{}: {cause}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// A file that is damaged or of no known format.
    #[error("{}: {cause}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: ReadError,
    },
    /// A file with another kind of content than required.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// Content required.
        expected: &'static str,
        /// Content found.
        found: String,
    },
    /// No base in a mode that needs one.
    #[error("a base's log is needed for anything but single-point positions (--mode single)")]
    NoBase,
    /// No orbits.
    #[error("no ephemeris in {files}: give a navigation file (RINEX, or a UBX log with RXM-SFRBX)")]
    NoEphemeris {
        /// The files read.
        files: String,
    },
    /// No precise orbits where the settings require them.
    #[error("pos1-sateph = precise needs precise orbits: give an SP3 file")]
    NoPreciseOrbits,
    /// A log without the week, where no other file gives the week.
    #[error("{} (--date): {cause}", path.display())]
    Date {
        /// The file.
        path: PathBuf,
        /// Missing part.
        cause: ReadError,
    },
    /// An antenna given by name that has no calibration.
    #[error("{}: the {receiver}'s antenna: expected one of the file's antennas, found {found:?}", path.display())]
    Antenna {
        /// The ANTEX file.
        path: PathBuf,
        /// Whose antenna: the rover's or the base's.
        receiver: &'static str,
        /// The name given.
        found: String,
    },
    /// No solution from the data of certain files.
    #[error("{files}: {cause}")]
    Solution {
        /// The files concerned.
        files: String,
        /// Cause.
        cause: PpkError,
    },
    /// No solution, for a reason that concerns no single file.
    #[error(transparent)]
    Process(PpkError),
}

impl PositioningError {
    /// Median of the base's single-point positions (ECEF, m), where the base's position is missing and the
    /// measurements determine single-point positions.
    #[must_use]
    pub fn suggested_base_ecef_m(&self) -> Option<[f64; 3]> {
        match self {
            Self::Solution {
                cause: PpkError::BasePositionMissing { own_single_ecef_m },
                ..
            } => *own_single_ecef_m,
            _ => None,
        }
    }

    /// Whether the base's position is missing.
    #[must_use]
    pub fn is_base_position_missing(&self) -> bool {
        matches!(
            self,
            Self::Solution {
                cause: PpkError::BasePositionMissing { .. },
                ..
            }
        )
    }
}
