//! Range model between antenna and point, and phase of an echo beyond the phase of its range.

use std::ops::Range;

use nalgebra::Vector3;
use num_complex::Complex64;

use crate::globals::{Effect, Global};

/// Model of ranges and phases from positions, for given values of the globals.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ranging {
    /// Stated over true propagation speed.
    pub slowness: f64,
    /// Offset added to all ranges of each pulse, m.
    pub delay_m: Vec<f64>,
    /// Unit phasor applied to the echoes of each pulse.
    pub turn: Vec<Complex64>,
}

impl Ranging {
    pub fn new(globals: &[Global], values: &[f64], pulses: usize) -> Self {
        let mut slowness = 1.0;
        let (mut delay_m, mut phase_rad) = (vec![0.0; pulses], vec![0.0; pulses]);
        let add = |to: &mut [f64], own: &Range<usize>, value: f64| {
            to[own.clone()].iter_mut().for_each(|v| *v += value);
        };
        for (global, value) in globals.iter().zip(values) {
            match &global.effect {
                Effect::Delay(own) => add(&mut delay_m, own, *value),
                Effect::RiseOverSurface(own) => add(&mut delay_m, own, -value),
                Effect::Phase(own) => add(&mut phase_rad, own, *value),
                Effect::Speed => slowness /= 1.0 + value,
                Effect::Position { .. } => {}
            }
        }
        Self {
            slowness,
            delay_m,
            turn: phase_rad.into_iter().map(Complex64::cis).collect(),
        }
    }

    /// Range by the stated speed between the antenna of a pulse and a point of the scene, m.
    pub fn range_m(&self, pulse: usize, antenna_m: &Vector3<f64>, point_m: &Vector3<f64>) -> f64 {
        (point_m - antenna_m).norm() * self.slowness + self.delay_m[pulse]
    }

    fn by_velocity(&self, global: &Global, value: f64, pulse: usize, sight: &Vector3<f64>) -> f64 {
        -sight.dot(&global.velocity(pulse, value)) * self.slowness
    }

    /// Derivative of [`Self::range_m`] with respect to a global at `value`; `sight` is the unit vector from
    /// the antenna of the pulse to the point, `distance_m` away.
    pub fn derivative(
        &self,
        (global, value): (&Global, f64),
        pulse: usize,
        (sight, distance_m): (&Vector3<f64>, f64),
    ) -> f64 {
        match &global.effect {
            Effect::Delay(own) => f64::from(u8::from(own.contains(&pulse))),
            Effect::Phase(_) => 0.0,
            Effect::Speed => -distance_m * self.slowness / (1.0 + value),
            Effect::Position { .. } => self.by_velocity(global, value, pulse, sight),
            Effect::RiseOverSurface(own) => {
                let shorter = f64::from(u8::from(own.contains(&pulse)));
                self.by_velocity(global, value, pulse, sight) - shorter
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globals::tests::each;

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let globals = each();
        let values = [0.07, -0.02, 0.9, -0.2, 0.25, 0.004, 0.015];
        let (antenna, pixel) = (Vector3::new(0.3, -2.0, 9.5), Vector3::new(4.0, 1.0, 0.0));
        let range_m = |values: &[f64], pulse| {
            let ranging = Ranging::new(&globals, values, 2);
            let moved: Vector3<f64> = globals
                .iter()
                .zip(values)
                .map(|(g, v)| g.moved_m(pulse, *v))
                .sum();
            ranging.range_m(pulse, &(antenna + moved), &pixel)
        };
        for pulse in 0..2 {
            let ranging = Ranging::new(&globals, &values, 2);
            let moved: Vector3<f64> = globals
                .iter()
                .zip(&values)
                .map(|(g, v)| g.moved_m(pulse, *v))
                .sum();
            let apart = pixel - antenna - moved;
            for (j, global) in globals.iter().enumerate() {
                let sight = (&apart.normalize(), apart.norm());
                let found = ranging.derivative((global, values[j]), pulse, sight);
                let step = 1e-5 * global.sigma;
                let [mut low, mut high] = [values; 2];
                low[j] -= step;
                high[j] += step;
                let expected = (range_m(&high, pulse) - range_m(&low, pulse)) / (2.0 * step);
                let scale = expected.abs().max(1.0);
                assert!(
                    (found - expected).abs() < 1e-6 * scale,
                    "{}: {found} and {expected}",
                    global.name
                );
            }
        }
    }

    #[test]
    fn delays_and_phases_are_those_of_their_own_pulses() {
        let values = [0.07, -0.02, 0.9, -0.2, 0.25, 0.004, 0.015];
        let ranging = Ranging::new(&each(), &values, 2);
        assert!((ranging.delay_m[0] - 0.07).abs() < 1e-15);
        assert!((ranging.delay_m[1] + 0.20).abs() < 1e-15);
        assert_eq!(ranging.turn, [Complex64::ONE, Complex64::cis(0.9)]);
    }
}
