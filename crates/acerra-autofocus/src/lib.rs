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
//! of the points are nuisances. Quantities of the whole flight ([`Global`]: delay, clock, lever arm, height
//! above the scene, propagation speed; of each track, delay, phase and place) enter the same objective with
//! priors of their own. It starts from delays, which have no ambiguity of half a wavelength, and goes on to
//! phases. A correction is applied only if points that took no part in it become sharper; otherwise the
//! positions are returned as they were.

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
