//! Quantities common to the whole flight, or to a track of it, that change the ranges or the phases of
//! echoes.

use std::ops::Range;

use nalgebra::Vector3;

use crate::error::AutofocusError;

/// Effect of a unit of a global quantity on the ranges.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Effect {
    /// Offset added to the ranges of the given pulses, m: an error of the fast time of zero range.
    Delay(Range<usize>),
    /// Phase added to the echoes of the given pulses, rad, without effect on their ranges.
    Phase(Range<usize>),
    /// Displacement of the antenna, p(θ) = p + θ·first + ½θ²·second, for example by a clock offset, a lever
    /// arm or an error of the height above the scene.
    Position {
        /// First derivative at each pulse, `[M]`, m per unit.
        first: Vec<[f64; 3]>,
        /// Second derivative at each pulse, `[M]`, m per unit squared.
        second: Vec<[f64; 3]>,
    },
    /// Rise of the given pulses, m, with ranges shortened by the same amount: the fast time of zero range was
    /// calibrated on the surface below, from the stated height.
    RiseOverSurface(Range<usize>),
    /// Relative error of the propagation speed, true over stated less 1: ranges by the stated speed are
    /// R/(1 + θ).
    Speed,
}

/// A global quantity that is estimated: true less stated value, with zero prior mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Global {
    /// Name of the quantity.
    pub name: String,
    /// Prior standard deviation, in the unit of the effect; above 0.
    pub sigma: f64,
    /// Effect on ranges and phases.
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
        let (first, second) = match &self.effect {
            Effect::Position { first, second } => (first, second),
            Effect::Delay(own) | Effect::Phase(own) | Effect::RiseOverSurface(own) => {
                return check_pulses(own, pulses);
            }
            Effect::Speed => return Ok(()),
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

    /// Change of a pulse's position at the value `value`, m.
    pub(crate) fn moved_m(&self, pulse: usize, value: f64) -> Vector3<f64> {
        match &self.effect {
            Effect::Position { first, second } => {
                Vector3::from(first[pulse]) * value
                    + Vector3::from(second[pulse]) * (0.5 * value * value)
            }
            Effect::RiseOverSurface(own) if own.contains(&pulse) => Vector3::z() * value,
            _ => Vector3::zeros(),
        }
    }

    /// Derivative of a pulse's position at the value `value`, m per unit.
    pub(crate) fn velocity(&self, pulse: usize, value: f64) -> Vector3<f64> {
        match &self.effect {
            Effect::Position { first, second } => {
                Vector3::from(first[pulse]) + Vector3::from(second[pulse]) * value
            }
            Effect::RiseOverSurface(own) if own.contains(&pulse) => Vector3::z(),
            _ => Vector3::zeros(),
        }
    }

    /// Greatest change of a range up to `longest_m` at one prior deviation, m.
    pub(crate) fn reach_m(&self, longest_m: f64) -> f64 {
        match &self.effect {
            Effect::Delay(_) | Effect::RiseOverSurface(_) => self.sigma,
            Effect::Phase(_) => 0.0,
            Effect::Speed => self.sigma * longest_m,
            Effect::Position { first, .. } => (0..first.len())
                .map(|m| self.moved_m(m, self.sigma).norm())
                .fold(0.0, f64::max),
        }
    }
}

/// Refuses a range of pulses that is empty or beyond `pulses` pulses.
pub(crate) fn check_pulses(own: &Range<usize>, pulses: usize) -> Result<(), AutofocusError> {
    if own.start < own.end && own.end <= pulses {
        return Ok(());
    }
    Err(AutofocusError::Pulses {
        start: own.start,
        end: own.end,
        pulses,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// One quantity of each kind, for a flight of two pulses.
    pub(crate) fn each() -> Vec<Global> {
        let of = |name, sigma, effect| Global {
            name: String::from(name),
            sigma,
            effect,
        };
        vec![
            of("delay", 0.1, Effect::Delay(0..2)),
            of("delay of a track", 0.1, Effect::Delay(1..2)),
            of("phase of a track", 1.8, Effect::Phase(1..2)),
            of(
                "height",
                0.3,
                Effect::Position {
                    first: vec![[0.0, 0.0, 1.0]; 2],
                    second: vec![[0.0; 3]; 2],
                },
            ),
            of("rise", 0.3, Effect::RiseOverSurface(1..2)),
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
            let needs_each = matches!(global.effect, Effect::Position { .. });
            assert_eq!(global.check(3).is_err(), needs_each);
            let is_speed = matches!(global.effect, Effect::Speed);
            assert_eq!(global.check(1).is_ok(), is_speed);
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
        let of_none = Global {
            effect: Effect::Phase(1..1),
            ..hostile
        };
        assert!(of_none.check(2).is_err());
    }
}
