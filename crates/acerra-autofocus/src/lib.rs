//! Autofocus: corrections of the antenna's path from the echoes of prominent points, with the navigation's
//! covariance as prior.
//!
//! ```text
//! Pulses, ImageGrid, PositionPrior ──► search ──► fit ──► significance ──► Autofocused
//!                                     (points)  (MAP)    (points left out)
//! ```
//!
//! The estimate is the maximum of the posterior of the positions' errors, with a Gaussian prior that is
//! correlated along the flight ([`PositionPrior`]), and of the points' places. Amplitudes and phases of the
//! points are nuisances. Quantities of the whole flight ([`Global`]: delay, clock, lever arm, height above
//! the scene, propagation speed; for each track, delay, phase and place) enter the same objective with
//! separate priors. The estimation starts from delays, which have no ambiguity of half a wavelength, and
//! continues with phases. A correction is applied only if points that were not used for it become sharper;
//! otherwise the positions are returned unchanged.

mod decide;
mod echoes;
pub mod error;
mod estimate;
mod fit;
mod gain;
mod globals;
mod ground;
mod held;
mod histories;
mod information;
mod model;
mod observe;
pub mod outcome;
mod parts;
mod passes;
mod places;
pub mod prior;
mod process;
mod profiles;
mod ranging;
mod reach;
mod search;
mod significance;
mod smoother;
mod surroundings;
mod template;
mod track_phase;
mod weighing;

pub use error::AutofocusError;
pub use estimate::{AutofocusOptions, autofocus};
pub use globals::{Effect, Global};
pub use outcome::{Autofocused, Decision, GlobalFound, PointFound};
pub use prior::{Correlation, PositionPrior};
