//! Offset between the clocks of two records of one flight, from the positions in both.

use acerra_geo::interpolate::{InterpolationOptions, Interpolator, Method};
use acerra_geo::trajectory::{Fix, Trajectory};

/// Shifts tried to each side (s): more than the 18 leap seconds between UTC and GPS time.
const WIDEST_S: f64 = 30.0;
/// Steps of the shifts tried (s).
const STEP_S: f64 = 0.1;
/// Largest shift (s) that is accepted without a comparison, unless another shift is much more likely.
const NEAR_S: f64 = 1.0;
/// Log-likelihood by which a larger shift must exceed these (odds of 400 to 1).
const MARGIN: f64 = 6.0;
/// Largest number of positions of the record that are compared, evenly spread.
const MOST_COMPARED: usize = 1000;
/// Least number of positions compared.
const FEWEST_COMPARED: usize = 20;

/// Comparison of one record of a flight with another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockShift {
    /// The record's stamp of an event minus the reference's stamp (s), from the positions.
    pub shift_s: f64,
    /// Standard deviation of the shift (s), from the residuals between the positions and their correlation
    /// time.
    pub sigma_s: f64,
    /// Mean horizontal distance of the record's positions from the reference's positions (m), at this shift.
    pub distance_m: f64,
}

/// Compares the horizontal positions of `record` with those of `reference`, in one frame and on one scale of
/// time; a constant offset between the positions is removed. `None` where the reference hardly moves, or both
/// have few times in common.
#[must_use]
pub fn clock_shift(record: &Trajectory, reference: &Trajectory) -> Option<ClockShift> {
    let origin = reference.time_origin().gps_time()?;
    let own = record.time_origin().gps_time()?;
    let every = record.fixes().len().div_ceil(MOST_COMPARED);
    let compared: Vec<Fix> = record
        .fixes()
        .iter()
        .step_by(every)
        .map(|fix| Fix {
            time_s: (own + fix.time_s) - origin,
            ..*fix
        })
        .collect();
    let options = InterpolationOptions::default().with_method(Method::Linear);
    let path = Interpolator::new(reference, &options);
    let steps = (WIDEST_S / STEP_S).round() as i32;
    let tried: Vec<(f64, Option<Comparison>)> = (-steps..=steps)
        .map(|k| STEP_S * f64::from(k))
        .map(|shift_s| (shift_s, Comparison::at(&path, &compared, shift_s)))
        .collect();
    let most = tried
        .iter()
        .flat_map(|(_, c)| c)
        .map(|c| c.residual_m.len())
        .max()?;
    // A short overlap at a wide shift fits by chance.
    let enough = FEWEST_COMPARED.max(most / 2);
    let square = |k: usize| {
        let comparison = tried.get(k)?.1.as_ref()?;
        (comparison.residual_m.len() >= enough).then(|| comparison.mean_square_m2())
    };
    let least_of = |is_tried: &dyn Fn(f64) -> bool| {
        (0..tried.len())
            .filter(|k| is_tried(tried[*k].0))
            .filter_map(|k| Some((k, square(k)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (anywhere, anywhere_m2) = least_of(&|_| true)?;
    let independent = tried[anywhere].1.as_ref()?.independent();
    // Laps that repeat fit at the next lap as well: another shift counts where it fits much better.
    let is_much_better = |near_m2: f64| 0.5 * independent * (near_m2 / anywhere_m2).ln() > MARGIN;
    let best = least_of(&|shift_s| shift_s.abs() <= NEAR_S)
        .filter(|(_, near_m2)| !is_much_better(*near_m2))
        .map_or(anywhere, |(near, _)| near);
    let (shift_s, comparison) = &tried[best];
    let comparison = comparison.as_ref()?;
    let least_m2 = square(best)?;
    let [before_m2, after_m2] = [best.checked_sub(1).and_then(square)?, square(best + 1)?];
    let curvature_m2 = 0.5 * (before_m2 + after_m2) - least_m2;
    if curvature_m2 <= 0.0 {
        return None;
    }
    // The parabola through three means of squares; the likelihood of n normal residuals is their mean square to the power −n/2.
    let vertex = 0.25 * (before_m2 - after_m2) / curvature_m2;
    let variance = least_m2 / (comparison.independent() * curvature_m2);
    Some(ClockShift {
        shift_s: shift_s + STEP_S * vertex,
        sigma_s: STEP_S * variance.sqrt(),
        distance_m: comparison.mean_m[0].hypot(comparison.mean_m[1]),
    })
}

/// Two records at one shift.
struct Comparison {
    /// Mean difference east and north (m).
    mean_m: [f64; 2],
    /// Residual of each difference (m), in order of time.
    residual_m: Vec<[f64; 2]>,
}

impl Comparison {
    fn at(path: &Interpolator<'_>, compared: &[Fix], shift_s: f64) -> Option<Self> {
        let mut residual_m: Vec<[f64; 2]> = compared
            .iter()
            .filter_map(|fix| {
                let there = path.at(fix.time_s - shift_s);
                let difference = |axis: usize| fix.position_m[axis] - there.position_m[axis];
                there
                    .flag
                    .is_covered()
                    .then(|| [difference(0), difference(1)])
            })
            .collect();
        if residual_m.is_empty() {
            return None;
        }
        let count = residual_m.len() as f64;
        let mean_m = [0, 1].map(|axis| residual_m.iter().map(|r| r[axis]).sum::<f64>() / count);
        for residual in &mut residual_m {
            *residual = [residual[0] - mean_m[0], residual[1] - mean_m[1]];
        }
        Some(Self { mean_m, residual_m })
    }

    /// Mean square of one axis (m²).
    fn mean_square_m2(&self) -> f64 {
        let sum: f64 = self.residual_m.iter().flatten().map(|r| r * r).sum();
        // Records that agree to the last digit have the rounding of their files.
        (sum / (2 * self.residual_m.len()) as f64).max(1e-8)
    }

    /// Number of independent residuals: the number of residuals over the sum of their autocorrelation up to
    /// its first zero, counted for two axes.
    fn independent(&self) -> f64 {
        let count = self.residual_m.len();
        let product = |lag: usize| -> f64 {
            let pairs = self.residual_m.iter().zip(&self.residual_m[lag..]);
            pairs.map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
        };
        let power = product(0);
        let correlations = (1..count).map(|lag| product(lag) / power);
        let sum: f64 = correlations.take_while(|c| *c > 0.0).sum();
        (2 * count) as f64 / (1.0 + 2.0 * sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::{EnuFrame, Geodetic};
    use acerra_geo::time::GpsTime;
    use acerra_geo::trajectory::{Frame, TimeOrigin};

    fn flight(rate_hz: f64, place_m: impl Fn(f64) -> [f64; 3]) -> Trajectory {
        let frame = EnuFrame::new(Geodetic::from_degrees(41.0, 14.0, 80.0));
        let origin = TimeOrigin::Gps(GpsTime::from_week_tow(2390, 0.0));
        let count = (60.0 * rate_hz) as usize;
        let fix = |k: usize| {
            let time_s = k as f64 / rate_hz;
            Fix::new(1000.0 + time_s, place_m(time_s))
        };
        Trajectory::new(Frame::Enu(frame), origin, (0..count).map(fix).collect()).unwrap()
    }

    /// Passes of 20 m there and back.
    fn there_and_back(time_s: f64) -> [f64; 3] {
        [
            0.3 * (0.7 * time_s).sin(),
            10.0 * (0.35 * time_s).sin(),
            8.0,
        ]
    }

    /// Passes that get shorter.
    fn ever_faster(time_s: f64) -> [f64; 3] {
        let [x, ..] = there_and_back(time_s);
        [
            x,
            10.0 * (0.25 * time_s + 0.004 * time_s * time_s).sin(),
            8.0,
        ]
    }

    #[test]
    fn the_shift_is_found_within_its_deviation_on_positions_that_wander_by_a_metre() {
        let reference = flight(5.0, ever_faster);
        for (late_s, phase) in [(0.0, 0.0), (0.22, 1.0), (-1.3, 2.0), (18.0, 3.0)] {
            let record = flight(10.0, |time_s| {
                let [x, y, z] = ever_faster(time_s - late_s);
                let wander = (0.11 * time_s + phase).sin() + 0.1 * (9.0 * time_s).sin();
                [x + 3.0 + wander, y - 4.0 + 0.7 * wander, z]
            });
            let found = clock_shift(&record, &reference).unwrap();
            let off_s = (found.shift_s - late_s).abs();
            assert!(off_s < 3.0 * found.sigma_s, "{late_s}: {found:?}");
            assert!(found.sigma_s < 0.3, "{late_s}: {found:?}");
            assert!((found.distance_m - 5.0).abs() < 1.0, "{late_s}: {found:?}");
        }
    }

    #[test]
    fn laps_that_repeat_are_not_taken_for_one_another() {
        let reference = flight(5.0, there_and_back);
        for phase in 0..20 {
            let record = flight(10.0, |time_s| {
                let [x, y, z] = there_and_back(time_s);
                let wander = (0.11 * time_s + 0.3 * f64::from(phase)).sin();
                [x + wander, y + 0.7 * wander, z]
            });
            let found = clock_shift(&record, &reference).unwrap();
            assert!(found.shift_s.abs() < 0.5, "{phase}: {found:?}");
        }
    }

    #[test]
    fn a_platform_that_stands_tells_nothing_for_certain() {
        let reference = flight(5.0, |_| [0.0, 0.0, 8.0]);
        let record = flight(10.0, |t| {
            [0.5 * (0.11 * t).sin(), 0.4 * (0.17 * t).cos(), 8.0]
        });
        let found = clock_shift(&record, &reference);
        assert!(found.is_none_or(|f| f.sigma_s > 1.0), "{found:?}");
    }
}
