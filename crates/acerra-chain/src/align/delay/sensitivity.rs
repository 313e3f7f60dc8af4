//! Error of the delay at which an echo adds up best, caused by errors of positions.
//!
//! Errors n of the ranges and a delay off by 2r/c leave the residuals e = r − uₓ·Δx − u_y·Δy − n of an echo
//! that is imaged at (x + Δx, y + Δy), u being the horizontal directions to it. To second order its coherent
//! sum loses Q = (2k)²·Var(e) + (2κ)²·Mean(e²) from the logarithm of its power, k being the mean wavenumber
//! of the band and κ its standard deviation: the first term is by phases, the second by envelopes. The least
//! Q over r, Δx and Δy is at r = Σ aₘnₘ, so that errors of known covariance give its variance.

use acerra_autofocus::Correlation;
use nalgebra::{Matrix3, Vector3};

/// Largest number of nodes into which traces are grouped where their errors are correlated.
const MOST_NODES: usize = 256;
/// Ratio of one correlation time tried to the next.
const LONGER: f64 = 1.5;
/// The shortest correlation time tried (s): the interval of a receiver at 5 Hz.
const SHORTEST_S: f64 = 0.2;
/// Prior deviation of the echo's shift along each axis (m), effective where the data hardly bound the shift.
const SHIFT_SIGMA_M: f64 = 10.0;

/// Geometry and amplitude of an echo.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    /// Time (s) and place (m) of each trace.
    pub time_s: &'a [f64],
    pub position_m: &'a [[f64; 3]],
    /// Amplitude of the echo in each trace.
    pub amplitude: &'a [f64],
    /// Place of the echo (m).
    pub place_m: [f64; 3],
    /// Mean and standard deviation of the wavenumbers (rad/m).
    pub wavenumber_rad_m: [f64; 2],
}

/// Sensitivity of the delay by an echo to errors of its ranges, as ranges.
#[derive(Clone, Debug)]
pub(super) struct Sensitivity {
    /// Error of the range (m) by an error of 1 m of each trace's position along each axis.
    by_position: Vec<[f64; 3]>,
    time_s: Vec<f64>,
    weight: Vec<f64>,
}

impl Sensitivity {
    /// Sensitivity by an echo; `None` where the echo has no power or does not determine the delay.
    pub fn of(seen: Seen<'_>) -> Option<Self> {
        let total: f64 = seen.amplitude.iter().sum();
        if total <= 0.0 {
            return None;
        }
        let weight: Vec<f64> = seen.amplitude.iter().map(|a| a / total).collect();
        let direction: Vec<Vector3<f64>> = seen
            .position_m
            .iter()
            .map(|p| Vector3::from_fn(|i, _| seen.place_m[i] - p[i]))
            .map(|to| to.try_normalize(0.0).unwrap_or_default())
            .collect();
        // Rows of the residual in r, Δx and Δy; M·rows with M = (2k)²(W − wwᵀ) + (2κ)²W.
        let row = |u: &Vector3<f64>| Vector3::new(1.0, -u.x, -u.y);
        let mean: Vector3<f64> = weight
            .iter()
            .zip(&direction)
            .map(|(w, u)| *w * row(u))
            .sum();
        let [phase, envelope] = seen.wavenumber_rad_m.map(|k| (2.0 * k).powi(2));
        let weighed = |w: f64, u: &Vector3<f64>| w * (phase * (row(u) - mean) + envelope * row(u));
        let mut normal =
            Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) / SHIFT_SIGMA_M.powi(2);
        for (w, u) in weight.iter().zip(&direction) {
            normal += weighed(*w, u) * row(u).transpose();
        }
        let inverse = normal.try_inverse()?;
        // A trace displaced along the direction is nearer to the echo.
        let by_position = weight.iter().zip(&direction).map(|(w, u)| {
            let by_range = (inverse.row(0) * weighed(*w, u))[0];
            (u * -by_range).into()
        });
        Some(Self {
            by_position: by_position.collect(),
            time_s: seen.time_s.to_vec(),
            weight,
        })
    }

    /// Standard deviation of the range (m) by position errors with the deviations `sigma_m` along each axis
    /// (m): a common error of all traces, and varying errors.
    pub fn deviation_m(&self, sigma_m: &[[f64; 3]]) -> f64 {
        self.by_common_m(sigma_m).hypot(self.by_varying_m(sigma_m))
    }

    /// Standard deviation of the range (m) by a common error of all traces, with the deviations `sigma_m`
    /// along each axis (m).
    fn by_common_m(&self, sigma_m: &[[f64; 3]]) -> f64 {
        let mut sum = [0.0; 3];
        for (b, sigma_m) in self.by_position.iter().zip(sigma_m) {
            (0..3).for_each(|i| sum[i] += b[i] * sigma_m[i]);
        }
        sum.iter().map(|s| s * s).sum::<f64>().sqrt()
    }

    /// Standard deviation of the range (m) by varying errors with the deviations `sigma_m` (m). Since the
    /// correlation time of the errors is unknown, the largest deviation over all correlation times up to the
    /// duration is returned.
    fn by_varying_m(&self, sigma_m: &[[f64; 3]]) -> f64 {
        let nodes = self.nodes(sigma_m);
        let [Some(first), Some(last)] = [self.time_s.first(), self.time_s.last()] else {
            return 0.0;
        };
        let times = std::iter::successors(Some(SHORTEST_S), |t| Some(t * LONGER));
        times
            .take_while(|t| *t <= (last - first).abs().max(SHORTEST_S))
            .map(|length| correlated_m(&nodes, Correlation::Matern32 { length }))
            .fold(0.0, f64::max)
    }

    /// Responses of neighbouring traces to errors about the mean, summed: time (s) and response (m) along each axis.
    fn nodes(&self, sigma_m: &[[f64; 3]]) -> Vec<(f64, [f64; 3])> {
        let mut sum = [0.0; 3];
        for b in &self.by_position {
            (0..3).for_each(|i| sum[i] += b[i]);
        }
        let each = self.by_position.len().div_ceil(MOST_NODES).max(1);
        let traces: Vec<usize> = (0..self.by_position.len().min(sigma_m.len())).collect();
        traces
            .chunks(each)
            .map(|chunk| {
                let mut response = [0.0; 3];
                for m in chunk {
                    for i in 0..3 {
                        let about_mean = self.by_position[*m][i] - self.weight[*m] * sum[i];
                        response[i] += about_mean * sigma_m[*m][i];
                    }
                }
                let time_s = chunk.iter().map(|m| self.time_s[*m]).sum::<f64>();
                (time_s / chunk.len() as f64, response)
            })
            .collect()
    }
}

/// Deviation of a sum of correlated errors, √(Σᵢⱼ ρ(tᵢ − tⱼ)·bᵢ·bⱼ) (m).
fn correlated_m(nodes: &[(f64, [f64; 3])], correlation: Correlation) -> f64 {
    let mut variance_m2 = 0.0;
    for (time_s, response) in nodes {
        for (other_s, other) in nodes {
            let product: f64 = (0..3).map(|i| response[i] * other[i]).sum();
            variance_m2 += correlation.at(time_s - other_s) * product;
        }
    }
    variance_m2.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE_M: [f64; 3] = [3.0, 2.0, 0.0];
    const TRACES: usize = 151;

    fn track() -> (Vec<f64>, Vec<[f64; 3]>) {
        let time_s: Vec<f64> = (0..TRACES).map(|k| 0.05 * k as f64).collect();
        let position_m = time_s.iter().map(|t| [0.8 * t, 0.0, 4.0]).collect();
        (time_s, position_m)
    }

    fn sensitivity(time_s: &[f64], position_m: &[[f64; 3]]) -> Sensitivity {
        let seen = Seen {
            time_s,
            position_m,
            amplitude: &vec![2.0; position_m.len()],
            place_m: PLACE_M,
            wavenumber_rad_m: [82.8, 10.3],
        };
        Sensitivity::of(seen).unwrap()
    }

    fn range_m(position_m: &[f64; 3], place_m: [f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|i| (place_m[i] - position_m[i]).powi(2)).sum();
        square.sqrt()
    }

    #[test]
    fn errors_that_look_like_a_delay_and_a_shift_are_taken_for_them() {
        let (time_s, position_m) = track();
        let sensitivity = sensitivity(&time_s, &position_m);
        // Ranges 1 mm too long and an echo 2 mm further north, from errors along the lines of sight.
        let moved_m = [PLACE_M[0], PLACE_M[1] + 2e-3, 0.0];
        let mut found_m = 0.0;
        for (b, p) in sensitivity.by_position.iter().zip(&position_m) {
            let range_m_ = range_m(p, PLACE_M);
            let error_m = 1e-3 + range_m_ - range_m(p, moved_m);
            for i in 0..3 {
                found_m += b[i] * error_m * (p[i] - PLACE_M[i]) / range_m_;
            }
        }
        assert!((found_m - 1e-3).abs() < 2e-5, "{found_m}");
    }

    #[test]
    fn the_loss_of_the_coherent_sum_is_least_there() {
        // Heights bent by 4 mm: the loss over r, Δx and Δy is minimised by descent.
        let (time_s, position_m) = track();
        let sensitivity = sensitivity(&time_s, &position_m);
        let bend_m = |t: f64| 4e-3 * ((t - 3.75) / 3.75).powi(2);
        let linear_m: f64 = (0..TRACES)
            .map(|m| sensitivity.by_position[m][2] * bend_m(time_s[m]))
            .sum();
        let loss = |[r, x, y]: [f64; 3]| {
            let residual = |m: usize| {
                let place_m = [PLACE_M[0] + x, PLACE_M[1] + y, 0.0];
                let mut assumed_m = position_m[m];
                assumed_m[2] += bend_m(time_s[m]);
                range_m(&position_m[m], PLACE_M) + r - range_m(&assumed_m, place_m)
            };
            let all: Vec<f64> = (0..TRACES).map(residual).collect();
            let mean = all.iter().sum::<f64>() / TRACES as f64;
            let square = all.iter().map(|e| e * e).sum::<f64>() / TRACES as f64;
            165.6f64.powi(2) * (square - mean * mean) + 20.6f64.powi(2) * square
        };
        let mut at = [0.0; 3];
        let mut step = 0.02;
        while step > 1e-6 {
            let neighbours =
                (0..27).map(|n| [n % 3, n / 3 % 3, n / 9].map(|d| step * (f64::from(d) - 1.0)));
            let best = neighbours
                .map(|d| [at[0] + d[0], at[1] + d[1], at[2] + d[2]])
                .min_by(|a, b| loss(*a).total_cmp(&loss(*b)))
                .unwrap_or(at);
            if best == at {
                step *= 0.5;
            }
            at = best;
        }
        assert!(
            (at[0] - linear_m).abs() < 0.1 * at[0].abs(),
            "{at:?} {linear_m}"
        );
        assert!(at[0].abs() > 1e-3, "{at:?}");
    }

    #[test]
    fn heights_all_off_are_a_delay_below_the_track_and_a_shift_beside_it() {
        let (time_s, position_m) = track();
        let off_m = [[0.0, 0.0, 0.01]; TRACES];
        let beside_m = sensitivity(&time_s, &position_m).by_common_m(&off_m);
        assert!(beside_m < 1e-4, "{beside_m}");
        let below_m: Vec<[f64; 3]> = position_m
            .iter()
            .map(|p| [p[0], PLACE_M[1], p[2]])
            .collect();
        let below_m = sensitivity(&time_s, &below_m).by_common_m(&off_m);
        assert!((5e-3..0.02).contains(&below_m), "{below_m}");
        // Common horizontal errors only move the echo.
        let level_m = sensitivity(&time_s, &position_m).by_common_m(&[[0.01, 0.01, 0.0]; TRACES]);
        assert!(level_m < 1e-4, "{level_m}");
    }

    #[test]
    fn deviations_are_those_of_errors_drawn() {
        // White errors add up as a sum of squares.
        let nodes: Vec<(f64, [f64; 3])> = (0..9).map(|k| (f64::from(k), [0.0, 0.5, 0.1])).collect();
        let white_m = correlated_m(&nodes, Correlation::White);
        assert!((white_m - (9.0_f64 * 0.26).sqrt()).abs() < 1e-12);
        // Lasting errors add up linearly.
        let lasting_m = correlated_m(&nodes, Correlation::Matern32 { length: 1e6 });
        assert!((lasting_m - 9.0 * 0.26_f64.sqrt()).abs() < 1e-6);
        let (time_s, position_m) = track();
        let varying_m =
            sensitivity(&time_s, &position_m).by_varying_m(&[[0.003, 0.003, 0.006]; TRACES]);
        assert!(varying_m > 0.01 && varying_m < 0.06, "{varying_m}");
    }

    #[test]
    fn nothing_comes_of_an_echo_without_power() {
        let (time_s, position_m) = track();
        let seen = Seen {
            time_s: &time_s,
            position_m: &position_m,
            amplitude: &[0.0; TRACES],
            place_m: PLACE_M,
            wavenumber_rad_m: [82.8, 10.3],
        };
        assert!(Sensitivity::of(seen).is_none());
    }
}
