//! Cubic spline through unevenly spaced positions, with not-a-knot ends.
//!
//! de Boor, *A Practical Guide to Splines*, chapter IV; second derivatives as unknowns, one
//! tridiagonal, diagonally dominant system for all three axes.

use crate::matrix::Vector3;
use crate::trajectory::Fix;

/// Second derivatives of the spline at the fixes of one stretch (m/s²).
#[derive(Debug)]
pub(super) struct Spline {
    acceleration_m_s2: Vec<Vector3>,
}

impl Spline {
    /// The spline through three fixes or more.
    pub fn through(fixes: &[Fix]) -> Self {
        let n = fixes.len();
        let step = |i: usize| fixes[i + 1].time_s - fixes[i].time_s;
        let slope = |i: usize| {
            [0, 1, 2].map(|k| (fixes[i + 1].position_m[k] - fixes[i].position_m[k]) / step(i))
        };
        // Six times the change of slope at fix i: the right-hand side.
        let bend = |i: usize| {
            let (before, after) = (slope(i - 1), slope(i));
            [0, 1, 2].map(|k| 6.0 * (after[k] - before[k]))
        };
        if n == 3 {
            // One parabola.
            let a = bend(1).map(|b| b / (3.0 * (step(0) + step(1))));
            return Self {
                acceleration_m_s2: vec![a; 3],
            };
        }

        // Unknowns at fixes 1 to n − 2; the ends follow from the third derivative being the same
        // on both sides of fix 1 and of fix n − 2.
        let m = n - 2;
        let (first, second) = (step(0), step(1));
        let (last, before_last) = (step(n - 2), step(n - 3));
        let mut diagonal: Vec<f64> = (1..=m).map(|i| 2.0 * (step(i - 1) + step(i))).collect();
        let mut above: Vec<f64> = (1..=m).map(step).collect();
        let mut below: Vec<f64> = (1..=m).map(|i| step(i - 1)).collect();
        diagonal[0] = (first + second) * (first + 2.0 * second) / second;
        above[0] = (second * second - first * first) / second;
        diagonal[m - 1] = (last + before_last) * (last + 2.0 * before_last) / before_last;
        below[m - 1] = (before_last * before_last - last * last) / before_last;

        let mut solution: Vec<Vector3> = (1..=m).map(bend).collect();
        for i in 1..m {
            let factor = below[i] / diagonal[i - 1];
            diagonal[i] -= factor * above[i - 1];
            solution[i] = [0, 1, 2].map(|k| solution[i][k] - factor * solution[i - 1][k]);
        }
        solution[m - 1] = solution[m - 1].map(|v| v / diagonal[m - 1]);
        for i in (0..m - 1).rev() {
            solution[i] =
                [0, 1, 2].map(|k| (solution[i][k] - above[i] * solution[i + 1][k]) / diagonal[i]);
        }

        let beyond = |near: Vector3, far: Vector3, ratio: f64| {
            [0, 1, 2].map(|k| near[k] + ratio * (near[k] - far[k]))
        };
        let mut acceleration = Vec::with_capacity(n);
        acceleration.push(beyond(solution[0], solution[1], first / second));
        let end = beyond(solution[m - 1], solution[m - 2], last / before_last);
        acceleration.extend(solution);
        acceleration.push(end);
        Self {
            acceleration_m_s2: acceleration,
        }
    }

    /// Number of fixes on it.
    pub fn len(&self) -> usize {
        self.acceleration_m_s2.len()
    }

    /// Position and velocity in its interval `i`, which lies between fixes `a` and `b`.
    pub fn at(&self, i: usize, a: &Fix, b: &Fix, time_s: f64) -> (Vector3, Vector3) {
        let step = b.time_s - a.time_s;
        let (p, q) = ((b.time_s - time_s) / step, (time_s - a.time_s) / step);
        let (ma, mb) = (self.acceleration_m_s2[i], self.acceleration_m_s2[i + 1]);
        let sixth = step * step / 6.0;
        let position = [0, 1, 2].map(|k| {
            p * a.position_m[k]
                + q * b.position_m[k]
                + sixth * ((p * p * p - p) * ma[k] + (q * q * q - q) * mb[k])
        });
        let velocity = [0, 1, 2].map(|k| {
            (b.position_m[k] - a.position_m[k]) / step
                + step / 6.0 * ((1.0 - 3.0 * p * p) * ma[k] + (3.0 * q * q - 1.0) * mb[k])
        });
        (position, velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic is reproduced by a not-a-knot spline, on any spacing.
    #[test]
    fn cubics_are_reproduced_on_uneven_times() {
        let cubic = |t: f64| [t * t * t - 2.0 * t, 0.5 * t * t, -t * t * t + 7.0];
        let slope = |t: f64| [3.0 * t * t - 2.0, t, -3.0 * t * t];
        for times in [
            vec![0.0, 0.1, 0.5, 0.7],
            vec![-1.0, 0.0, 0.3, 1.7, 1.8, 2.5, 4.0],
            (0..40)
                .map(|i| 0.1 * f64::from(i) + 0.03 * f64::from(i % 3))
                .collect(),
        ] {
            let fixes: Vec<Fix> = times.iter().map(|&t| Fix::new(t, cubic(t))).collect();
            let spline = Spline::through(&fixes);
            for (i, pair) in fixes.windows(2).enumerate() {
                for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
                    let t = pair[0].time_s + share * (pair[1].time_s - pair[0].time_s);
                    let (position, velocity) = spline.at(i, &pair[0], &pair[1], t);
                    for k in 0..3 {
                        assert!((position[k] - cubic(t)[k]).abs() < 1e-11);
                        assert!((velocity[k] - slope(t)[k]).abs() < 1e-10);
                    }
                }
            }
        }
    }

    #[test]
    fn three_fixes_make_a_parabola() {
        let parabola = |t: f64| [t * t, 3.0 * t, 1.0];
        let fixes = [0.0, 0.4, 1.0].map(|t| Fix::new(t, parabola(t)));
        let spline = Spline::through(&fixes);
        let (position, velocity) = spline.at(1, &fixes[1], &fixes[2], 0.7);
        assert!((position[0] - 0.49).abs() < 1e-14 && (velocity[0] - 1.4).abs() < 1e-14);
    }
}
