//! Change of the radargram about each trace.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::clean::mean_trace;
use crate::radargram::Radargram;

/// Change of the radargram about each trace, `[traces]`: ‖x(m+1) − x(m−1)‖ relative to the root
/// mean square of ‖x‖ over all traces.
///
/// Constant coupling cancels in the difference; the coupling's residue by jitter of timing and gain, along
/// the mean trace and the slope of the mean trace, is projected out. With the platform at rest the difference
/// is noise; when the platform moves a quarter of a wavelength within two intervals the echoes decorrelate
/// and the curve levels out near √2 times their share of the record, so that the curve shows onset and end of
/// motion sharply and speed only roughly. The first and last value repeat their neighbours.
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
    let jitter = jitter_shapes(radargram);
    let mut change: Vec<f64> = (0..traces)
        .into_par_iter()
        .map(|m| {
            let m = m.clamp(1, traces - 2);
            let (a, b) = ((m - 1) * n, (m + 1) * n);
            let difference: Vec<Complex64> = (0..n)
                .map(|j| radargram.samples.at(b + j) - radargram.samples.at(a + j))
                .collect();
            let of_jitter = jitter
                .iter()
                .map(|shape| along(shape, &difference).norm_sqr());
            let whole: f64 = difference.iter().map(Complex64::norm_sqr).sum();
            (whole - of_jitter.sum::<f64>()).max(0.0).sqrt()
        })
        .collect();
    change.iter_mut().for_each(|c| *c /= scale);
    change
}

/// Shapes of a trace's residue by jitter of gain and timing, orthonormal: the mean trace, and its differences
/// over two, four and six samples, whose sums are its slope throughout a wide band.
fn jitter_shapes(radargram: &Radargram) -> Vec<Vec<Complex64>> {
    let n = radargram.samples_per_trace;
    let mean = mean_trace(radargram);
    let difference = |lag: usize| -> Vec<Complex64> {
        let at = |j: Option<usize>| j.and_then(|j| mean.get(j)).copied().unwrap_or_default();
        (0..n)
            .map(|j| at(j.checked_add(lag)) - at(j.checked_sub(lag)))
            .collect()
    };
    let mut shapes: Vec<Vec<Complex64>> = Vec::new();
    for mut shape in [mean.clone(), difference(1), difference(2), difference(3)] {
        let whole = norm(&shape);
        for known in &shapes {
            let share = along(known, &shape);
            shape
                .iter_mut()
                .zip(known)
                .for_each(|(s, k)| *s -= share * k);
        }
        let own = norm(&shape);
        // A shape that consists of rounding errors is omitted.
        if own > 1e-6 * whole {
            shape.iter_mut().for_each(|s| *s /= own);
            shapes.push(shape);
        }
    }
    shapes
}

fn along(shape: &[Complex64], values: &[Complex64]) -> Complex64 {
    shape.iter().zip(values).map(|(s, v)| s.conj() * v).sum()
}

fn norm(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::*;
    use crate::radargram::Samples;

    #[test]
    fn jitter_of_strong_coupling_is_no_change() {
        // Coupling a thousand times as strong as the echo; jitter of 0.5 ps and of a part in ten thousand. The echo
        // moves from trace 60 on.
        let (traces, n, step_s) = (120, 500, 61e-12);
        let pulse = |t_s: f64| {
            let u = t_s / 0.4e-9;
            (-u * u).exp() * (std::f64::consts::TAU * 3.95e9 * t_s).cos()
        };
        let samples = (0..traces).flat_map(|m| {
            let jitter = (1.7 * f64::from(m) * f64::from(m)).sin();
            let moved_s = 0.05e-9 * f64::from((m - 60).max(0));
            (0..n).map(move |k| {
                let t_s = step_s * f64::from(k) - 0.5e-12 * jitter;
                let coupling = 1e4 * (1.0 + 1e-4 * jitter) * pulse(t_s - 5e-9);
                (coupling + 10.0 * pulse(t_s - 20e-9 - moved_s)) as f32
            })
        });
        let time_s = (0..traces).map(|m| 0.05 * f64::from(m)).collect();
        let samples = Samples::Real(samples.collect());
        let radargram = Radargram::new(time_s, 0.0, step_s, samples).unwrap();
        let change = activity(&radargram);
        let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        let least = change[62..118]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        assert!(
            largest(&change[1..58]) < 0.1 * least,
            "{least:e} {:?}",
            &change[1..58]
        );
        // The plain difference at rest is larger than that of the echo in motion.
        let difference = |m: usize| {
            let value = |k: usize| radargram.samples.at(k).re;
            let (before, after) = ((m - 1) * n as usize, (m + 1) * n as usize);
            (0..n as usize)
                .map(|k| (value(after + k) - value(before + k)).powi(2))
                .sum::<f64>()
        };
        let power: f64 = (0..(traces * n) as usize)
            .map(|k| radargram.samples.at(k).re.powi(2))
            .sum();
        let scale = (power / f64::from(traces)).sqrt();
        let plain: Vec<f64> = (1..58).map(|m| difference(m).sqrt() / scale).collect();
        assert!(
            largest(&plain) > 2.0 * least,
            "{least:e} {}",
            largest(&plain)
        );
    }
}
