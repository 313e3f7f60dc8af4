//! How much the radargram changes about each trace.

use rayon::prelude::*;

use crate::radargram::Radargram;

/// Change of the radargram about each trace, `[traces]`: ‖x(m+1) − x(m−1)‖ relative to the root
/// mean square of ‖x‖ over all traces.
///
/// Constant coupling cancels in the difference. While the platform stands what remains is noise;
/// when it moves a quarter of a wavelength within two intervals the echoes decorrelate and the
/// curve levels out near √2 times their share of the record, so it marks onset and end of motion
/// sharply and speed only roughly. The ends repeat their neighbours.
#[must_use]
pub fn activity(radargram: &Radargram) -> Vec<f64> {
    let (traces, n) = (radargram.traces, radargram.samples_per_trace);
    let energy: f64 = (0..radargram.samples.len())
        .into_par_iter()
        .map(|i| radargram.samples.at(i).norm_sqr())
        .sum();
    let scale = (energy / traces as f64).sqrt();
    if traces < 3 || scale == 0.0 {
        return vec![0.0; traces];
    }
    let mut change: Vec<f64> = (0..traces)
        .into_par_iter()
        .map(|m| {
            let m = m.clamp(1, traces - 2);
            let (a, b) = ((m - 1) * n, (m + 1) * n);
            let sum: f64 = (0..n)
                .map(|j| (radargram.samples.at(b + j) - radargram.samples.at(a + j)).norm_sqr())
                .sum();
            sum.sqrt()
        })
        .collect();
    change.iter_mut().for_each(|c| *c /= scale);
    change
}
