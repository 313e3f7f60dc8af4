//! How positioning errors blur an image: loss of peak, shift and widening.
//!
//! [`predict`] says it by theory, [`simulate`] by Monte Carlo with confidence intervals, for errors
//! that are new at every pulse, drift slowly, or both ([`ErrorModel`]).
//!
//! | figure | by theory | holds |
//! | --- | --- | --- |
//! | loss at the target's place | double sum of Gaussian coherences | for any error |
//! | loss at the peak | the same, after the least-squares shift | while a peak stands out by 10 dB |
//! | shift | least squares, plus the peak's motion in its own speckle | likewise |
//! | widening | −3 dB width of the expected power about the shifted place | likewise |

mod geometry;
mod model;
mod monte_carlo;
mod nodes;
mod normal;
mod theory;

pub use model::ErrorModel;
pub use monte_carlo::{Estimate, Simulated, simulate};
pub use theory::{Blur, predict};

/// A peak counts as focused when its coherent power is this multiple of its speckle.
const FOCUSED_RATIO: f64 = 10.0;
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
