//! Autofocus: where the antenna was, from the echoes of prominent points and from what the navigation
//! knows of its own errors.
//!
//! ```text
//! Pulses, ImageGrid, PositionPrior ──► search ──► fit ──► significance ──► Autofocused
//!                                     (points)  (MAP)    (points left out)
//! ```
//!
//! The estimate is the maximum of the posterior of the positions' errors, with a Gaussian prior that is
//! correlated along the flight ([`PositionPrior`]), and of the points' places. Amplitudes and phases
//! of the points are nuisances. It starts from delays, which have no ambiguity of half a wavelength,
//! and goes on to phases. A correction is applied only if points that took no part in it become
//! sharper; otherwise the positions are returned as they were.

mod decide;
mod echoes;
pub mod error;
mod estimate;
mod fit;
mod gain;
mod ground;
mod held;
mod histories;
mod information;
mod model;
mod observe;
pub mod outcome;
mod passes;
pub mod prior;
mod process;
mod profiles;
mod reach;
mod search;
mod significance;
mod smoother;
mod template;
mod weighing;

pub use error::AutofocusError;
pub use estimate::{AutofocusOptions, autofocus};
pub use outcome::{Autofocused, Decision, PointFound};
pub use prior::{Correlation, PositionPrior};
