//! What the engine answers: an epoch-by-epoch solution and the story behind it.

mod epoch;
mod glonass;
mod not_fixed;
mod quality;
mod summary;
mod warning;

pub use epoch::{EventPosition, LostEpoch, SatelliteResidual, Solution};
pub use glonass::GlonassDecision;
pub use not_fixed::NotFixedReason;
pub use quality::Quality;
pub use summary::{PpkSolution, PpkSummary};
pub use warning::{BaseGap, MissingNavigation, PpkWarning};
