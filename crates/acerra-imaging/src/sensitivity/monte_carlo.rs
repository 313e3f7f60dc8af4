//! Monte Carlo simulation of positioning errors.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde::Serialize;

use super::criteria::{CUT_CELLS, CUT_POINTS, half_power_width};
use super::geometry::{View, dot};
use super::model::ErrorModel;
use super::normal::Normal;
use crate::error::ImagingError;
use crate::metrics::field::{Field, climb_to_peak};
use crate::psf::spread::PointSpread;
use acerra_control::Control;

/// A value with the bounds of its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl Estimate {
    /// Whether `expected` lies within the interval, stretched by `factor` about the estimate.
    #[must_use]
    pub fn covers(&self, expected: f64, factor: f64) -> bool {
        let below = self.value - factor * (self.value - self.low);
        let above = self.value + factor * (self.high - self.value);
        (below..=above).contains(&expected)
    }
}

/// Effects of drawn errors, with the fields of [`Blur`](super::Blur).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// Draws.
    pub trials: usize,
    /// Loss of mean power at the target's true place, dB.
    pub loss_at_target_db: Estimate,
    /// Loss of mean power at the peak, dB.
    pub peak_loss_db: Estimate,
    /// Standard deviation of the peak's shift along the track, m.
    pub shift_along_m: Estimate,
    /// Standard deviation of the peak's shift across the track, m.
    pub shift_across_m: Estimate,
    /// −3 dB width along the track of the mean power, over the width of the ideal image.
    pub widening_along: Option<Estimate>,
    /// The widening across the track.
    pub widening_across: Option<Estimate>,
}

/// Two-sided 95 % point of the normal distribution.
const NORMAL_95: f64 = 1.959_964;
/// Widths are estimated from this many batches of trials.
const BATCHES: usize = 20;
/// Two-sided 95 % point of Student's t with [`BATCHES`] − 1 degrees of freedom.
const STUDENT_95: f64 = 2.093_024;

/// Number of draws and their seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MonteCarlo {
    /// Draws, 20 to a million.
    pub trials: usize,
    /// Equal seeds give equal answers, whatever the number of threads.
    pub seed: u64,
}

/// Draws the errors `draws.trials` times, and measures the image of the point with each draw.
///
/// The peak is the maximum reached from the place to which the least-squares shift of that draw moves
/// it, and the cuts for the widths run through that place.
///
/// # Errors
/// As [`predict`](super::predict), fewer than 20 trials or more than a million, and cancellation.
pub fn simulate(
    spread: &PointSpread,
    target_m: [f64; 3],
    model: &ErrorModel,
    draws: MonteCarlo,
    control: Control,
) -> Result<Simulated, ImagingError> {
    let MonteCarlo { trials, seed } = draws;
    if !(BATCHES..=1_000_000).contains(&trials) {
        let (what, expected) = ("trials", "20 to 1 000 000");
        return Err(ImagingError::OutOfRange {
            what,
            expected,
            found: trials as f64,
        });
    }
    let view = View::of(spread, target_m, model)?;
    let experiment = Experiment {
        spread,
        target_m,
        map: view.shift_map(),
        own: spread.response(target_m, target_m).norm(),
        view,
    };
    let drawn: Vec<Trial> = (0..trials)
        .into_par_iter()
        .map(|trial| {
            control.check()?;
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(trial as u64);
            let mut normal = Normal::new(random);
            experiment.run(&model.draw(|| normal.draw()))
        })
        .collect::<Result<_, _>>()?;
    let ideal = experiment.run(&vec![[0.0; 3]; model.len()])?;
    let shift = |axis: usize| drawn.iter().map(move |t| t.shift_m[axis]);
    Ok(Simulated {
        trials,
        loss_at_target_db: mean_db(drawn.iter().map(|t| t.power_at_target)),
        peak_loss_db: mean_db(drawn.iter().map(|t| t.power_at_peak / ideal.power_at_peak)),
        shift_along_m: deviation(shift(0).map(|s| s - ideal.shift_m[0])),
        shift_across_m: deviation(shift(1).map(|s| s - ideal.shift_m[1])),
        widening_along: widening(&drawn, &ideal, 0),
        widening_across: widening(&drawn, &ideal, 1),
    })
}

struct Trial {
    power_at_target: f64,
    power_at_peak: f64,
    shift_m: [f64; 2],
    cut: Vec<f64>,
}

struct Experiment<'a> {
    spread: &'a PointSpread,
    target_m: [f64; 3],
    view: View,
    map: [Vec<f64>; 2],
    /// Amplitude of the ideal image at the target.
    own: f64,
}

impl Experiment<'_> {
    fn run(&self, error_m: &[[f64; 3]]) -> Result<Trial, ImagingError> {
        let (view, target_m) = (&self.view, self.target_m);
        let believed = self
            .spread
            .position_m()
            .iter()
            .zip(error_m)
            .map(|(p, e)| [p[0] + e[0], p[1] + e[1], p[2] + e[2]])
            .collect();
        let field = Displaced {
            believed: PointSpread::new(
                believed,
                Some(self.spread.weight().to_vec()),
                self.spread.frequency_hz().to_vec(),
                self.spread.light_speed_m_s(),
            )?,
            truth: self.spread,
            target_m,
        };
        let power = |at: [f64; 2]| {
            let amplitude = field.amplitude(at[0], at[1]).unwrap_or(0.0);
            (amplitude / self.own).powi(2)
        };
        let range_error: Vec<f64> = view
            .pulse
            .iter()
            .zip(&view.sight)
            .map(|(m, u)| dot(u, &error_m[*m]))
            .collect();
        let fitted = [
            dot(&self.map[0], &range_error),
            dot(&self.map[1], &range_error),
        ];
        let (ahead, left) = (view.track.tangent, view.track.left());
        let place = |along: f64, across: f64| {
            [0, 1].map(|i| target_m[i] + along * ahead[i] + across * left[i])
        };
        let (peak_m, peak) =
            climb_to_peak(&field, place(fitted[0], fitted[1]), 0.1 * view.cell.along_m).ok_or(
                ImagingError::Empty {
                    what: "the response to the target",
                },
            )?;
        let moved = [peak_m[0] - target_m[0], peak_m[1] - target_m[1]];
        let mut cut = Vec::with_capacity(2 * CUT_POINTS);
        for (axis, cell_m) in [view.cell.along_m, view.cell.across_m]
            .into_iter()
            .enumerate()
        {
            for k in 0..CUT_POINTS {
                let s = CUT_CELLS * cell_m * (2.0 * k as f64 / (CUT_POINTS - 1) as f64 - 1.0);
                let step = if axis == 0 { [s, 0.0] } else { [0.0, s] };
                cut.push(power(place(fitted[0] + step[0], fitted[1] + step[1])));
            }
        }
        Ok(Trial {
            power_at_target: power([target_m[0], target_m[1]]),
            power_at_peak: (peak / self.own).powi(2),
            shift_m: [dot(&moved, &ahead), dot(&moved, &left)],
            cut,
        })
    }
}

/// The image of the point focused with wrong places.
struct Displaced<'a> {
    believed: PointSpread,
    truth: &'a PointSpread,
    target_m: [f64; 3],
}

impl Field for Displaced<'_> {
    fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let at = [x_m, y_m, self.target_m[2]];
        let truth = self.truth.position_m();
        Some(
            self.believed
                .response_displaced(truth, self.target_m, at)
                .norm(),
        )
    }
}

/// Mean and its standard error.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Mean of powers, in dB.
fn mean_db(power: impl Iterator<Item = f64>) -> Estimate {
    let (mean, error) = mean_and_error(&power.collect::<Vec<_>>());
    let db = |p: f64| 10.0 * p.max(1e-30).log10();
    Estimate {
        value: db(mean),
        low: db(mean - NORMAL_95 * error),
        high: db(mean + NORMAL_95 * error),
    }
}

/// Root mean square, with an interval from the scatter of the squares, so that heavy tails count.
fn deviation(values: impl Iterator<Item = f64>) -> Estimate {
    let (mean, error) = mean_and_error(&values.map(|v| v * v).collect::<Vec<_>>());
    let root = |v: f64| v.max(0.0).sqrt();
    Estimate {
        value: root(mean),
        low: root(mean - NORMAL_95 * error),
        high: root(mean + NORMAL_95 * error),
    }
}

/// Width of the mean power of all trials over the width of the ideal image, with an interval from batches.
fn widening(drawn: &[Trial], ideal: &Trial, axis: usize) -> Option<Estimate> {
    let range = axis * CUT_POINTS..(axis + 1) * CUT_POINTS;
    let reference = half_power_width(&ideal.cut[range.clone()])?;
    let ratio = |trials: &mut dyn Iterator<Item = &Trial>| -> Option<f64> {
        let mut sum = vec![0.0; CUT_POINTS];
        for t in trials {
            for (total, p) in sum.iter_mut().zip(&t.cut[range.clone()]) {
                *total += p;
            }
        }
        Some(half_power_width(&sum)? / reference)
    };
    let value = ratio(&mut drawn.iter())?;
    let batches: Vec<f64> = (0..BATCHES)
        .map(|b| ratio(&mut drawn.iter().skip(b).step_by(BATCHES)))
        .collect::<Option<_>>()?;
    let (_, error) = mean_and_error(&batches);
    Some(Estimate {
        value,
        low: value - STUDENT_95 * error,
        high: value + STUDENT_95 * error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psf::{TrackShape, synthetic_track};

    /// Small known errors move the peak as the least-squares map predicts.
    #[test]
    fn the_shift_map_is_the_peaks_motion() {
        let track = synthetic_track(TrackShape::Straight, 3.0, 0.03, 5.0).unwrap();
        let s: Vec<f64> = track.iter().map(|p| p[0] / 3.0).collect();
        let frequency_hz = (0..171).map(|n| 3.1e9 + 1e7 * f64::from(n)).collect();
        let spread = PointSpread::new(track, None, frequency_hz, 3e8).unwrap();
        let target_m = [0.0, 2.0, 0.0];
        let model = ErrorModel::white(0.001, s.len()).unwrap();
        let view = View::of(&spread, target_m, &model).unwrap();
        let own = spread.response(target_m, target_m).norm();
        let map = view.shift_map();
        let experiment = Experiment {
            spread: &spread,
            target_m,
            map,
            own,
            view,
        };
        let still = experiment.run(&vec![[0.0; 3]; s.len()]).unwrap();
        let shapes: [fn(f64) -> [f64; 3]; 5] = [
            |_| [1.0, 0.0, 0.0],
            |_| [0.0, 1.0, 0.0],
            |_| [0.0, 0.0, 1.0],
            |s| [0.0, 0.0, s],
            |s| [0.0, s * s, 0.5 - s * s],
        ];
        for shape in shapes {
            let error_m: Vec<[f64; 3]> = s.iter().map(|s| shape(*s).map(|v| 5e-4 * v)).collect();
            let moved = experiment.run(&error_m).unwrap().shift_m;
            let range_error: Vec<f64> = experiment
                .view
                .pulse
                .iter()
                .zip(&experiment.view.sight)
                .map(|(m, u)| dot(u, &error_m[*m]))
                .collect();
            for (axis, (moved, still)) in moved.iter().zip(&still.shift_m).enumerate() {
                let expected = dot(&experiment.map[axis], &range_error);
                let found = moved - still;
                println!(
                    "axis {axis}: {:.2} um, expected {:.2} um",
                    1e6 * found,
                    1e6 * expected
                );
                assert!((found - expected).abs() < 0.03 * expected.abs() + 5e-6);
            }
        }
    }
}
