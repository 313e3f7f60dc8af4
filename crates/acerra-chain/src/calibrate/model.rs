//! The measurement model: the fast time of a reflector's echo in a trace.
//!
//! Apparent range ρ = (1 + s)·|p(t + Δt) + C·L − r| + c·δ/2, with the positioned point p, the body's
//! axes C, the lever arm L, the reflector r, the clock offset Δt, the range scale s and the delay δ.

use super::parameter::{Parameter, Values};
use super::path::Pose;

/// Prediction of the model for one reflector in one trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prediction {
    /// Apparent range (m).
    pub range_m: f64,
    /// Unit vector from the reflector to the phase centre.
    direction: [f64; 3],
    /// Change of true range per second of clock offset (m/s).
    range_rate_m_s: f64,
    /// Change of true range per metre of lever arm: forward, left, up.
    per_arm: [f64; 3],
    /// True range (m).
    true_range_m: f64,
}

/// The prediction for a reflector from a pose.
pub(super) fn predict(
    values: &Values,
    pose: &Pose,
    reflector_m: [f64; 3],
    light_speed_m_s: f64,
) -> Prediction {
    let centre = pose.phase_centre_m(values.lever_arm_m);
    let away = [0, 1, 2].map(|i| centre[i] - reflector_m[i]);
    let true_range_m = dot(away, away).sqrt();
    let direction = away.map(|v| v / true_range_m.max(1e-9));
    Prediction {
        range_m: (1.0 + values.range_scale) * true_range_m + 0.5 * light_speed_m_s * values.delay_s,
        direction,
        range_rate_m_s: dot(
            direction,
            pose.phase_centre_velocity_m_s(values.lever_arm_m),
        ),
        per_arm: pose.axis.map(|axis| dot(direction, axis)),
        true_range_m,
    }
}

impl Prediction {
    /// Derivative of the apparent range by an unknown (m per SI unit), in a trace of `track`.
    pub fn derivative(&self, by: Parameter, track: usize, light_speed_m_s: f64) -> f64 {
        match by {
            Parameter::Delay => 0.5 * light_speed_m_s,
            Parameter::RangeScale => self.true_range_m,
            Parameter::Forward => self.per_arm[0],
            Parameter::Left => self.per_arm[1],
            Parameter::Up => self.per_arm[2],
            Parameter::ClockOffset(of) if of == track => self.range_rate_m_s,
            Parameter::ClockOffset(_) => 0.0,
        }
    }

    /// Derivative of the apparent range by an error of the position: east, north, up.
    pub fn by_position(&self) -> [f64; 3] {
        self.direction
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
