//! Results of the engine: an epoch-by-epoch solution with its diagnosis.

mod baseline;
mod epoch;
mod error;
mod error_correlation;
mod error_covariance;
mod events;
mod glonass;
mod not_fixed;
mod quality;
mod summary;
mod trajectory;
mod warning;

pub use baseline::{Baseline, BaselineAttitude};
pub use epoch::{EventPosition, LostEpoch, SatelliteResidual, Solution};
pub use error::{PpkError, TimeSpan};
pub use error_correlation::{ErrorCorrelation, Lasting};
pub(crate) use events::interpolate_events;
pub use glonass::GlonassDecision;
pub use not_fixed::NotFixedReason;
pub use quality::Quality;
pub use summary::{PpkSolution, PpkSummary};
pub use warning::{BaseGap, MissingNavigation, PpkWarning};
