//! Power by frequency, and the band that matters at an accuracy.

use crate::engine::tables::spec::TableSpec;
use crate::pulses::Pulses;

/// Mean power at each frequency over the weighted pulses.
pub(super) fn mean_power(pulses: &Pulses) -> Vec<f64> {
    let mut power = vec![0.0; pulses.frequency_hz().len()];
    for (m, w) in pulses.weight().iter().enumerate() {
        for (p, e) in power.iter_mut().zip(pulses.spectrum_of(m)) {
            *p += e.norm_sqr() * w * w;
        }
    }
    let total: f64 = power.iter().sum();
    if total > 0.0 && total.is_finite() {
        power.iter_mut().for_each(|p| *p /= total);
    } else {
        power.fill(1.0);
    }
    power
}

/// Lowest, carrier and highest frequency that matter at `accuracy`, given the power at each.
pub(super) fn effective_band_hz(
    pulses: &Pulses,
    power: &[f64],
    accuracy: f64,
    table: &TableSpec,
) -> [f64; 3] {
    let f = pulses.frequency_hz();
    let carrier = f[table.carrier];
    let mut order: Vec<usize> = (0..f.len()).collect();
    order.sort_by(|a, b| (f[*b] - carrier).abs().total_cmp(&(f[*a] - carrier).abs()));
    // Frequencies at the edges may alias while their power is well below the allowed error.
    let allowed = (0.2 * accuracy).powi(2) * power.iter().sum::<f64>();
    let mut dropped = 0.0;
    let widest = order
        .into_iter()
        .find(|k| {
            dropped += power[*k];
            dropped > allowed
        })
        .map_or(0.0, |k| (f[k] - carrier).abs());
    [carrier - widest, carrier, carrier + widest]
}
