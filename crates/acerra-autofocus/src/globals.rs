//! Quantities that are the same for the whole flight and change the ranges of all echoes.

use nalgebra::Vector3;

use crate::error::AutofocusError;

/// What a unit of a global quantity does to the ranges.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Effect {
    /// It is added to every range, m: the fast time at which range is zero.
    Delay,
    /// It moves the antenna: p(θ) = p + θ·first + ½θ²·second, as an offset of the clock, a lever arm or an
    /// error of the height above the scene does.
    Position {
        /// First derivative at each pulse, `[M]`, m per unit.
        first: Vec<[f64; 3]>,
        /// Second derivative at each pulse, `[M]`, m per unit squared.
        second: Vec<[f64; 3]>,
    },
    /// Relative error of the propagation speed, true over stated less 1: ranges by the stated speed are
    /// R/(1 + θ).
    Speed,
}

/// A global quantity that the estimate leaves free: true less stated has zero mean beforehand.
#[derive(Debug, Clone, PartialEq)]
pub struct Global {
    /// What it is called.
    pub name: String,
    /// Prior standard deviation, in the unit of the effect; above 0.
    pub sigma: f64,
    /// What it does.
    pub effect: Effect,
}

impl Global {
    /// Refuses a quantity that does not fit `pulses` pulses.
    pub(crate) fn check(&self, pulses: usize) -> Result<(), AutofocusError> {
        if !(self.sigma.is_finite() && self.sigma > 0.0) {
            return Err(AutofocusError::OutOfRange {
                what: "globals",
                index: 0,
                expected: "a finite standard deviation above 0",
                found: self.sigma,
            });
        }
        let Effect::Position { first, second } = &self.effect else {
            return Ok(());
        };
        for derivative in [first, second] {
            if derivative.len() != pulses {
                return Err(AutofocusError::Length {
                    what: "globals",
                    expected: pulses,
                    found: derivative.len(),
                });
            }
            let is_broken = |d: &[f64; 3]| d.iter().any(|v| !v.is_finite());
            if let Some(index) = derivative.iter().position(is_broken) {
                return Err(AutofocusError::OutOfRange {
                    what: "globals",
                    index,
                    expected: "finite derivatives",
                    found: derivative[index].iter().sum(),
                });
            }
        }
        Ok(())
    }

    /// Change of a pulse's position by this value, m.
    pub(crate) fn moved_m(&self, pulse: usize, value: f64) -> Vector3<f64> {
        match &self.effect {
            Effect::Position { first, second } => {
                Vector3::from(first[pulse]) * value
                    + Vector3::from(second[pulse]) * (0.5 * value * value)
            }
            _ => Vector3::zeros(),
        }
    }

    /// Change of a pulse's position per unit at this value.
    pub(crate) fn velocity(&self, pulse: usize, value: f64) -> Vector3<f64> {
        match &self.effect {
            Effect::Position { first, second } => {
                Vector3::from(first[pulse]) + Vector3::from(second[pulse]) * value
            }
            _ => Vector3::zeros(),
        }
    }

    /// Greatest change of a range up to `longest_m` at one prior deviation, m.
    pub(crate) fn reach_m(&self, longest_m: f64) -> f64 {
        match &self.effect {
            Effect::Delay => self.sigma,
            Effect::Speed => self.sigma * longest_m,
            Effect::Position { first, .. } => (0..first.len())
                .map(|m| self.moved_m(m, self.sigma).norm())
                .fold(0.0, f64::max),
        }
    }
}

/// How places of antenna and point make a range, with the globals in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ranging {
    /// Stated over true propagation speed.
    pub slowness: f64,
    /// Added to all ranges, m.
    pub delay_m: f64,
}

impl Ranging {
    pub fn new(globals: &[Global], values: &[f64]) -> Self {
        let mut found = Self {
            slowness: 1.0,
            delay_m: 0.0,
        };
        for (global, value) in globals.iter().zip(values) {
            match global.effect {
                Effect::Delay => found.delay_m += value,
                Effect::Speed => found.slowness /= 1.0 + value,
                Effect::Position { .. } => {}
            }
        }
        found
    }

    /// Range by the stated speed between an antenna and a point of the scene, m.
    pub fn range_m(&self, antenna_m: &Vector3<f64>, point_m: &Vector3<f64>) -> f64 {
        (point_m - antenna_m).norm() * self.slowness + self.delay_m
    }

    /// Change of that range per unit of a global of this value; `sight` points from the antenna of the
    /// pulse to the point, `distance_m` away.
    pub fn derivative(
        &self,
        (global, value): (&Global, f64),
        pulse: usize,
        (sight, distance_m): (&Vector3<f64>, f64),
    ) -> f64 {
        match global.effect {
            Effect::Delay => 1.0,
            Effect::Speed => -distance_m * self.slowness / (1.0 + value),
            Effect::Position { .. } => -sight.dot(&global.velocity(pulse, value)) * self.slowness,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn each() -> Vec<Global> {
        let of = |name, sigma, effect| Global {
            name: String::from(name),
            sigma,
            effect,
        };
        vec![
            of("delay", 0.1, Effect::Delay),
            of(
                "height",
                0.3,
                Effect::Position {
                    first: vec![[0.0, 0.0, 1.0]; 2],
                    second: vec![[0.0; 3]; 2],
                },
            ),
            of("speed", 0.01, Effect::Speed),
            of(
                "clock",
                0.02,
                Effect::Position {
                    first: vec![[1.5, -0.4, 0.2], [1.4, 0.3, -0.1]],
                    second: vec![[0.3, 2.0, -0.5], [0.0, -1.0, 0.7]],
                },
            ),
        ]
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let globals = each();
        let values = [0.07, -0.2, 0.004, 0.015];
        let (antenna, pixel) = (Vector3::new(0.3, -2.0, 9.5), Vector3::new(4.0, 1.0, 0.0));
        let range_m = |values: &[f64], pulse| {
            let ranging = Ranging::new(&globals, values);
            let moved: Vector3<f64> = globals
                .iter()
                .zip(values)
                .map(|(g, v)| g.moved_m(pulse, *v))
                .sum();
            ranging.range_m(&(antenna + moved), &pixel)
        };
        for pulse in 0..2 {
            let ranging = Ranging::new(&globals, &values);
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
    fn quantities_that_do_not_fit_are_refused() {
        for global in each() {
            assert!(global.check(2).is_ok());
            for sigma in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let broken = Global {
                    sigma,
                    ..global.clone()
                };
                assert!(broken.check(2).is_err(), "{}: {sigma}", global.name);
            }
            let has_pulses = matches!(global.effect, Effect::Position { .. });
            assert_eq!(global.check(3).is_err(), has_pulses);
        }
        let hostile = Global {
            name: "clock".into(),
            sigma: 1.0,
            effect: Effect::Position {
                first: vec![[0.0, f64::NAN, 0.0]],
                second: vec![[0.0; 3]],
            },
        };
        assert!(hostile.check(1).is_err());
    }
}
