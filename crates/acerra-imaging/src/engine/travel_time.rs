//! Travel time of an echo as a function of range: the law by which range tables turn distance into
//! phase.

use crate::pulses::Pulses;
use std::f64::consts::PI;

/// Two-way travel time τ(R) of an echo from the geometric range R.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub(crate) enum TravelTime {
    /// A homogeneous medium: τ = 2R/c.
    Vacuum {
        /// c, m/s.
        light_speed_m_s: f64,
    },
}

impl TravelTime {
    /// The travel-time law of measured data.
    pub fn of(pulses: &Pulses) -> Self {
        Self::Vacuum {
            light_speed_m_s: pulses.light_speed_m_s(),
        }
    }

    /// Phase 2πf·τ(R) of frequency `frequency_hz` at `range_m`, rad.
    pub fn phase_rad(self, frequency_hz: f64, range_m: f64) -> f64 {
        self.wavenumber_rad_m(frequency_hz) * range_m
    }

    /// Two-way wavenumber 2πf·dτ/dR, rad/m: 4πf/c in a homogeneous medium.
    pub fn wavenumber_rad_m(self, frequency_hz: f64) -> f64 {
        match self {
            Self::Vacuum { light_speed_m_s } => 4.0 * PI * frequency_hz / light_speed_m_s,
        }
    }

    /// Range after which frequencies `step_hz` apart repeat, m: c/(2Δf) in a homogeneous medium.
    pub fn period_m(self, step_hz: f64) -> f64 {
        match self {
            Self::Vacuum { light_speed_m_s } => light_speed_m_s / (2.0 * step_hz),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_repeat_after_a_period() {
        let law = TravelTime::Vacuum {
            light_speed_m_s: 3e8,
        };
        let period_m = law.period_m(5e6);
        assert_eq!(period_m, 30.0);
        assert!((law.phase_rad(5e6, period_m) - 2.0 * PI).abs() < 1e-12);
        assert_eq!(law.phase_rad(4e9, 2.0), 2.0 * law.wavenumber_rad_m(4e9));
    }
}
