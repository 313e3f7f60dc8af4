//! Estimates of a setting that moves the traces, from the phases of strong targets.
//!
//! A wrong clock offset or lever arm moves every trace in proportion to the platform's velocity or rotation.
//! A common shift moves the image and is not observable; shifts that differ from trace to trace bend the
//! phase of each target's echo. The setting's value and deviation follow by least squares: each target has a
//! separate phase and place, and all targets share the setting. Neighbouring residuals are correlated (errors
//! of positions last), which the deviation takes into account.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::align::offset::lasting_motion_m;
use crate::echoes::history::{Measured, distance_m};

/// Time over which residuals count as correlated (s).
const CORRELATED_S: f64 = 3.0;

/// Least coherence of a target's echo at the best value: |Σ echo| over Σ |echo|.
const LEAST_COHERENCE: f64 = 0.5;

/// Residual phases beyond this are another target's (rad).
const STRAY_RAD: f64 = 1.5;

/// Least number of traces.
const LEAST_TRACES: usize = 60;

/// Half width and steps of the search for a target about the place expected (m).
const NEARBY_M: f64 = 0.25;
const PLACE_STEP_M: f64 = 0.01;

/// Change of its mean range that a relocation may bring (m): the envelope's peak is accurate to a third of
/// the range resolution of ultra-wideband pulses.
const RANGE_KNOWN_M: f64 = 0.03;

/// Rounds of least squares: all but the first without strays.
const ROUNDS: usize = 4;

/// Steps about the most coherent value that are tried again from there.
const NEAR_STEPS: f64 = 10.0;

/// The value of a setting that the echoes prefer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Preferred {
    /// The value, less the one in force.
    pub change: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Targets that take part.
    pub targets: usize,
}

/// A setting, by where it puts the traces.
pub(super) struct Trial<'a> {
    /// The echoes at the places in force.
    pub measured: Measured<'a>,
    /// Radar time of each trace (s).
    pub time_s: &'a [f64],
    /// Changes of the setting to try.
    pub changes: Vec<f64>,
    /// Places of the traces after a change of the setting; none where one trace has no place.
    pub places: &'a dyn Fn(f64) -> Option<Vec<[f64; 3]>>,
}

/// A target's echoes.
struct Target {
    point_m: [f64; 3],
    /// Echo of each trace, as long as its weight.
    echo: Vec<Complex64>,
    /// Weight of each trace: the echo's power, but for the strongest tenth.
    weight: Vec<f64>,
    /// Orthonormal basis, by weight, of the range changes by phase and place of the target.
    own: Vec<Vec<f64>>,
}

impl Trial<'_> {
    /// The change of the setting at which the echoes of the targets are most coherent; none where no
    /// target is coherent anywhere.
    ///
    /// Targets move with the mean of the traces, and the equations are linearised again at the new places.
    pub fn preferred(&self, point_m: &[[f64; 3]]) -> Option<Preferred> {
        if self.time_s.len() < LEAST_TRACES {
            return None;
        }
        let mut found = self.at_change(0.0, |measured| {
            point_m.iter().map(|p| Target::new(measured, *p)).collect()
        })?;
        for reach in [f64::INFINITY, NEAR_STEPS * self.step()] {
            let change = found.most_coherent(reach)?;
            found = self.from(&found, change)?;
        }
        found.targets.retain(Target::is_coherent);
        let mut sigma = f64::INFINITY;
        for round in 0..ROUNDS {
            let (more, deviation) = found.fit(round > 0)?;
            // A step beyond the neighbourhood that was searched is no refinement any more.
            let more = more.clamp(-2.0 * self.step(), 2.0 * self.step());
            found = self.from(&found, found.change + more)?;
            sigma = deviation;
        }
        Some(Preferred {
            change: found.change,
            sigma,
            targets: found.targets.len(),
        })
    }

    /// The targets as the traces see them after another change of the setting: each has moved with
    /// the traces that see it.
    fn from(&self, before: &AtChange<'_>, change: f64) -> Option<AtChange<'_>> {
        let places = (self.places)(change)?;
        let points: Vec<[f64; 3]> = before
            .targets
            .iter()
            .map(|target| target.moved_with(&before.places, &places))
            .collect();
        self.at_change(change, |measured| {
            let found = points.par_iter().map(|p| Target::new(measured, *p));
            found.map(|target| target.relocated(measured)).collect()
        })
    }

    fn at_change(
        &self,
        change: f64,
        targets: impl Fn(&Measured<'_>) -> Vec<Target>,
    ) -> Option<AtChange<'_>> {
        let places = (self.places)(change)?;
        let measured = Measured {
            position_m: &places,
            ..self.measured
        };
        Some(AtChange {
            trial: self,
            wavenumber: 2.0 * TAU * measured.mean_frequency_hz() / measured.light_speed_m_s,
            change,
            targets: targets(&measured),
            places,
        })
    }

    /// Spacing of the changes.
    fn step(&self) -> f64 {
        match self.changes.as_slice() {
            [first, second, ..] => (second - first).abs(),
            _ => 1.0,
        }
    }
}

/// Targets seen from where a value of the setting puts the traces.
struct AtChange<'a> {
    trial: &'a Trial<'a>,
    wavenumber: f64,
    places: Vec<[f64; 3]>,
    change: f64,
    targets: Vec<Target>,
}

impl AtChange<'_> {
    /// The change within reach at which the targets' echoes add up best.
    fn most_coherent(&self, reach: f64) -> Option<f64> {
        let near = self
            .trial
            .changes
            .iter()
            .filter(|c| (*c - self.change).abs() <= reach);
        let scored = near.filter_map(|change| {
            let bends = self.bends(*change)?;
            let each = self.targets.iter().zip(&bends);
            let sum: f64 = each
                .map(|(target, bend)| target.coherence(bend, self.wavenumber).powi(2))
                .sum();
            Some((*change, sum))
        });
        scored.max_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0)
    }

    /// Change of every target's ranges by `change` of the setting, without the part that phase and place of
    /// the target explain (m).
    fn bends(&self, change: f64) -> Option<Vec<Vec<f64>>> {
        let places = (self.trial.places)(change)?;
        let bend = |target: &Target| {
            let moved = target.moved_with(&self.places, &places);
            let pairs = self.places.iter().zip(&places);
            let change = pairs.map(|(before, after)| {
                distance_m(*after, moved) - distance_m(*before, target.point_m)
            });
            without(change.collect(), &target.own, &target.weight)
        };
        Some(self.targets.iter().map(bend).collect())
    }

    /// The further change that the residual phases ask for, and its deviation.
    fn fit(&self, drops_strays: bool) -> Option<(f64, f64)> {
        let step = self.trial.step();
        let [before, after] = [-step, step].map(|s| self.bends(self.change + s));
        let mut fit = Fit::new(self.trial.time_s);
        for ((target, before), after) in self.targets.iter().zip(&before?).zip(&after?) {
            let slopes = before.iter().zip(after);
            let per_unit: Vec<f64> = slopes.map(|(b, a)| (a - b) / (2.0 * step)).collect();
            target.enter(&mut fit, &per_unit, (self.wavenumber, drops_strays));
        }
        fit.solved()
    }
}

impl Target {
    fn new(measured: &Measured<'_>, point_m: [f64; 3]) -> Self {
        let echo = measured.history(point_m);
        let power: Vec<f64> = echo.iter().map(Complex64::norm_sqr).collect();
        // One bright flash must not outweigh the rest.
        let mut sorted = power.clone();
        sorted.sort_by(f64::total_cmp);
        let most = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(0.0);
        let weight: Vec<f64> = power.iter().map(|w| w.min(most)).collect();
        let echo: Vec<Complex64> = echo
            .iter()
            .zip(&weight)
            .map(|(echo, weight)| echo * (weight / echo.norm().max(f64::MIN_POSITIVE)))
            .collect();
        let slope = |axis| slopes(measured, point_m, axis);
        let mut own: Vec<Vec<f64>> = Vec::new();
        for column in [vec![1.0; echo.len()], slope(0), slope(1)] {
            let before = dot(&column, &column, &weight);
            let rest = without(column, &own, &weight);
            let norm2 = dot(&rest, &rest, &weight);
            if norm2 > 1e-8 * before {
                own.push(rest.iter().map(|v| v / norm2.sqrt()).collect());
            }
        }
        Self {
            point_m,
            echo,
            weight,
            own,
        }
    }

    /// The target at the place nearby where its echoes add up best.
    fn relocated(self, measured: &Measured<'_>) -> Self {
        let wavenumber = 2.0 * TAU * measured.mean_frequency_hz() / measured.light_speed_m_s;
        let steps = (NEARBY_M / PLACE_STEP_M).round() as i32;
        let turned = |echo: &[Complex64], axis: usize, by_m: f64| -> Vec<Complex64> {
            let slopes = self.slope(measured, axis);
            let turn =
                |(e, s): (&Complex64, f64)| e * Complex64::from_polar(1.0, wavenumber * s * by_m);
            echo.iter().zip(slopes).map(turn).collect()
        };
        let step: Vec<Complex64> = {
            let ones = vec![Complex64::new(1.0, 0.0); self.echo.len()];
            turned(&ones, 1, PLACE_STEP_M)
        };
        let mean_slope = [0, 1].map(|axis| self.mean(&self.slope(measured, axis)));
        let mut best = (f64::NEG_INFINITY, [0, 0]);
        for east in -steps..=steps {
            let is_near = |north: &i32| {
                let range_m = f64::from(east) * mean_slope[0] + f64::from(*north) * mean_slope[1];
                (range_m * PLACE_STEP_M).abs() <= RANGE_KNOWN_M
            };
            let mut near = (-steps..=steps).filter(is_near);
            let Some(first) = near.next() else {
                continue;
            };
            let last = near.next_back().unwrap_or(first);
            let row = turned(&self.echo, 0, f64::from(east) * PLACE_STEP_M);
            let mut row = turned(&row, 1, f64::from(first) * PLACE_STEP_M);
            for north in first..=last {
                let power = row.iter().sum::<Complex64>().norm_sqr();
                if power > best.0 {
                    best = (power, [east, north]);
                }
                row.iter_mut().zip(&step).for_each(|(e, s)| *e *= s);
            }
        }
        let [east_m, north_m] = best.1.map(|k| f64::from(k) * PLACE_STEP_M);
        let [x, y, z] = self.point_m;
        Self::new(measured, [x + east_m, y + north_m, z])
    }

    /// Change of its range per metre along an axis, trace by trace.
    fn slope(&self, measured: &Measured<'_>, axis: usize) -> Vec<f64> {
        slopes(measured, self.point_m, axis)
    }

    /// Place of the point, moved by the mean over the traces that see it.
    fn moved_with(&self, from: &[[f64; 3]], to: &[[f64; 3]]) -> [f64; 3] {
        let shift_m = |axis: usize| {
            let ways = from.iter().zip(to).map(|(a, b)| b[axis] - a[axis]);
            self.mean(&ways.collect::<Vec<_>>())
        };
        let [x, y, z] = self.point_m;
        [x + shift_m(0), y + shift_m(1), z]
    }

    /// Mean over the traces by weight.
    fn mean(&self, values: &[f64]) -> f64 {
        let total: f64 = self.weight.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let products = values.iter().zip(&self.weight).map(|(v, w)| v * w);
        products.sum::<f64>() / total
    }

    /// Whether the target's echoes add up at its place.
    fn is_coherent(&self) -> bool {
        self.coherence(&vec![0.0; self.echo.len()], 0.0) >= LEAST_COHERENCE
    }

    /// The echoes once the ranges are longer by `bend`.
    fn moved(&self, bend: &[f64], wavenumber: f64) -> Vec<Complex64> {
        self.echo
            .iter()
            .zip(bend)
            .map(|(echo, m)| echo * Complex64::from_polar(1.0, wavenumber * m))
            .collect()
    }

    fn coherence(&self, bend: &[f64], wavenumber: f64) -> f64 {
        let moved = self.moved(bend, wavenumber);
        let sum: Complex64 = moved.iter().sum();
        let all: f64 = self.weight.iter().sum();
        if all > 0.0 { sum.norm() / all } else { 0.0 }
    }

    /// Enters its residual ranges, and their change per unit of the setting.
    fn enter(&self, fit: &mut Fit<'_>, per_unit: &[f64], (wavenumber, drops_strays): (f64, bool)) {
        let mean: Complex64 = self.echo.iter().sum();
        let residual_m: Vec<f64> = self
            .echo
            .iter()
            .map(|echo| -(echo * mean.conj()).arg() / wavenumber)
            .collect();
        // The part that phase and place explain is removed first, so that strays are clear.
        let rest = without(residual_m, &self.own, &self.weight);
        let weight: Vec<f64> = rest
            .iter()
            .zip(&self.weight)
            .map(|(r, w)| {
                let is_stray = drops_strays && (r * wavenumber).abs() > STRAY_RAD;
                if is_stray { 0.0 } else { *w }
            })
            .collect();
        let total: f64 = weight.iter().sum();
        if total <= 0.0 {
            return;
        }
        for k in 0..rest.len() {
            fit.add(k, weight[k] / total, [per_unit[k], rest[k]]);
        }
    }
}

/// Least squares for one unknown, with residuals that are correlated in time and common to all
/// targets of a trace.
struct Fit<'a> {
    time_s: &'a [f64],
    /// Entries: trace, weight, change of range per unit and residual range.
    entries: Vec<(usize, f64, [f64; 2])>,
}

impl<'a> Fit<'a> {
    fn new(time_s: &'a [f64]) -> Self {
        Self {
            time_s,
            entries: Vec::new(),
        }
    }

    fn add(&mut self, trace: usize, weight: f64, values: [f64; 2]) {
        self.entries.push((trace, weight, values));
    }

    /// The unknown and its deviation, after Newey and West (1987).
    fn solved(&self) -> Option<(f64, f64)> {
        let information: f64 = self.entries.iter().map(|(_, w, [q, _])| w * q * q).sum();
        let product: f64 = self.entries.iter().map(|(_, w, [q, r])| w * q * r).sum();
        if information <= 0.0 {
            return None;
        }
        let value = product / information;
        let mut score = vec![0.0; self.time_s.len()];
        for (k, w, [q, r]) in &self.entries {
            score[*k] += w * q * (r - q * value);
        }
        let mut variance = 0.0;
        for (j, a) in score.iter().enumerate() {
            for (b, t) in score.iter().zip(self.time_s).skip(j) {
                let apart = (t - self.time_s[j]) / CORRELATED_S;
                if apart >= 1.0 {
                    break;
                }
                let twice = if apart > 0.0 { 2.0 } else { 1.0 };
                variance += twice * (1.0 - apart) * a * b;
            }
        }
        // Student's t for this number of stretches over the normal distribution, at three deviations.
        let length_s = self.time_s.last()? - self.time_s.first()?;
        let stretches = (length_s / CORRELATED_S).max(1.0);
        let own = variance.max(0.0).sqrt() / information * (1.0 + 4.0 / stretches);
        let weight: f64 = self.entries.iter().map(|(_, w, _)| w).sum();
        let lasting = lasting_motion_m(length_s) / (information / weight).sqrt();
        Some((value, own.hypot(lasting)))
    }
}

/// Change of a point's range per metre along an axis, trace by trace.
fn slopes(measured: &Measured<'_>, point_m: [f64; 3], axis: usize) -> Vec<f64> {
    let places = measured.position_m.iter();
    places
        .map(|p| (point_m[axis] - p[axis]) / distance_m(*p, point_m).max(1e-9))
        .collect()
}

fn dot(a: &[f64], b: &[f64], weight: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .zip(weight)
        .map(|((a, b), w)| w * a * b)
        .sum()
}

/// A vector without its part in the span of an orthonormal basis.
fn without(mut vector: Vec<f64>, basis: &[Vec<f64>], weight: &[f64]) -> Vec<f64> {
    for own in basis {
        let part = dot(&vector, own, weight);
        vector.iter_mut().zip(own).for_each(|(v, o)| *v -= part * o);
    }
    vector
}
