//! How positioning errors blur an image: loss of peak, shift and widening.
//!
//! [`predict`] says it by theory, [`simulate`] by Monte Carlo with confidence intervals, for errors
//! that are new at every pulse, drift slowly, or both ([`ErrorModel`]).
//!
//! | figure | by theory | given |
//! | --- | --- | --- |
//! | loss at the target's place | double sum of Gaussian coherences | always: it is exact |
//! | loss at the peak, widening | the same about the least-squares shift | while focused |
//! | shift | least squares, plus the peak's motion in its own speckle, to first order | while focused, coherence of 3 dB |
//!
//! Focused means that the power left about the shifted place is 10 dB above what random phases
//! would leave, and that its coherent part is no less than 6 dB below the rest.

mod geometry;
mod model;
mod monte_carlo;
mod nodes;
mod normal;
mod theory;

pub use model::ErrorModel;
pub use monte_carlo::{Estimate, Simulated, simulate};
pub use theory::{Blur, predict};

/// A peak stands out when its power is this multiple of what random phases would leave.
const FOCUSED_POWER: f64 = 10.0;
/// The least coherence (coherent power over the rest) at which a peak is one lobe.
const FOCUSED_COHERENCE: f64 = 0.25;
/// The least coherence at which the shift is first-order.
const SHIFT_COHERENCE: f64 = 2.0;
/// Widths are measured on cuts that reach this many expected resolutions to either side.
const CUT_CELLS: f64 = 1.2;
/// Points of such a cut.
const CUT_POINTS: usize = 25;

/// Full −3 dB width, in steps, of the lobe at the middle of an odd number of powers, crossings
/// interpolated linearly; `None` where the lobe does not fall so far.
fn half_power_width(power: &[f64]) -> Option<f64> {
    let middle = power.len() / 2;
    let level = power[middle] * 10f64.powf(-0.3);
    let side = |values: &mut dyn Iterator<Item = &f64>| -> Option<f64> {
        let mut before = power[middle];
        for (k, here) in values.enumerate() {
            if *here <= level && before > level {
                return Some(k as f64 + (before - level) / (before - here));
            }
            before = *here;
        }
        None
    };
    let right = side(&mut power[middle + 1..].iter())?;
    let left = side(&mut power[..middle].iter().rev())?;
    Some(left + right)
}
