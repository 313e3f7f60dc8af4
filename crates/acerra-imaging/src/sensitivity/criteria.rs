//! Criteria of focus, and widths of lobes.

/// A peak is clear when its power is this multiple of the power of random phases.
pub(super) const FOCUSED_POWER: f64 = 10.0;
/// The least coherence (coherent power over the rest) at which a peak is one lobe.
pub(super) const FOCUSED_COHERENCE: f64 = 0.25;
/// The least coherence at which the first-order shift is valid.
pub(super) const SHIFT_COHERENCE: f64 = 2.0;
/// Widths are measured on cuts that reach this many expected resolutions to either side.
pub(super) const CUT_CELLS: f64 = 1.2;
/// Number of points of a cut.
pub(super) const CUT_POINTS: usize = 25;

/// Full −3 dB width, in steps, of the lobe at the middle of an odd number of powers, crossings interpolated
/// linearly; `None` where the lobe does not fall by 3 dB.
pub(super) fn half_power_width(power: &[f64]) -> Option<f64> {
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
