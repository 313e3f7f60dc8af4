//! Estimation of the delay, the fast time at which range is zero, from the data.
//!
//! A wrong delay lengthens all ranges equally. The curvature of a point's echoes over the aperture belongs to
//! the true range, so that ranges ΔR too long leave a phase of 4πΔR(1 − cos θ)/λ at the angle θ from closest
//! approach: the point's coherent sum is largest at the true delay, if the aperture subtends an angle.
//! Surface echo and direct coupling give the interval that is searched.
//!
//! ```text
//! traces at their places ─► images at every delay ─► power of the strongest echo ─┐
//! echo that follows the height, 2h/c ─────────────► its delay ────────────────────┼─► log-likelihood ─► DelayFound
//! direct coupling, antennas side by side ─────────► its delay ────────────────────┘
//! ```

mod check;
mod cues;
mod curve;
mod echo_power;
mod error;
mod focus;
mod scan;
mod search;
mod sensitivity;
mod strongest;
mod targets;
mod view;

pub use check::{DelayCheck, check_delay};
pub use cues::{DelayCue, coupling_delay, surface_delay};
pub use curve::DelayCurve;
pub use error::DelayError;
pub(crate) use focus::Focus;
pub use scan::{DelayScan, ScanPoint, delayed};
pub use search::{DelayFound, DelayTrial, find_delay};
