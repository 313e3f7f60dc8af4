//! Orbits of GLONASS satellites, integrated from their broadcast position, velocity and
//! acceleration (GLONASS ICD, fourth-order Runge–Kutta in steps of a minute).

use super::navigation::GlonassEphemeris;
use super::state::{EARTH_ROTATION_CGCS_RAD_S, OrbitState};
use acerra_geo::time::GpsTime;
use std::sync::OnceLock;

const MU_GLONASS: f64 = 3.986_004_4e14;
const J2_GLONASS: f64 = 1.082_625_7e-3;
const EARTH_RADIUS_GLONASS_M: f64 = 6_378_136.0;
const STEP_S: f64 = 60.0;
/// Longest integration (s), which bounds the computing time: the selection of ephemerides limits integrations
/// to half an hour, and longer extrapolations are meaningless.
const LONGEST_S: f64 = 86_400.0;
/// Number of steps in either direction whose states are kept: half an hour.
const NODES: usize = 30;

/// Position (m) and velocity (m/s).
type StateVector = [f64; 6];

/// States of a satellite at whole minutes from its reference time, before and after, integrated at the first
/// call.
///
/// Every integration takes whole-minute steps first and one shorter step last: states are bitwise equal,
/// whether the whole minutes are kept or not.
#[derive(Default)]
pub(crate) struct GlonassNodes {
    after: OnceLock<Vec<StateVector>>,
    before: OnceLock<Vec<StateVector>>,
}

impl GlonassNodes {
    /// Position and clock at `t` by the ephemeris `e` of these nodes.
    pub(crate) fn orbit_at(&self, e: &GlonassEphemeris, t: GpsTime) -> OrbitState {
        let dt = t.seconds_since(e.toe);
        let mut state = initial(e);
        if dt.abs() <= LONGEST_S {
            let mut rest = dt;
            let steps = ((dt.abs() / STEP_S) as usize).min(NODES);
            if steps > 0 {
                let (nodes, step_s) = if dt > 0.0 {
                    (&self.after, STEP_S)
                } else {
                    (&self.before, -STEP_S)
                };
                state = nodes.get_or_init(|| integrated(e, step_s))[steps - 1];
                // Exact: both are multiples of the last place of `dt`.
                rest = dt - steps as f64 * step_s;
            }
            while rest.abs() > 1e-9 {
                let step_s = rest.clamp(-STEP_S, STEP_S);
                runge_kutta_step(&mut state, step_s, &e.acceleration_ecef_m_s2);
                rest -= step_s;
            }
        }
        OrbitState {
            position_ecef_m: [state[0], state[1], state[2]],
            clock_s: e.clock_offset_s + e.clock_rate * dt,
        }
    }
}

fn initial(e: &GlonassEphemeris) -> StateVector {
    let [p, v] = [e.position_ecef_m, e.velocity_ecef_m_s];
    [p[0], p[1], p[2], v[0], v[1], v[2]]
}

/// The states after one, two, … steps.
fn integrated(e: &GlonassEphemeris, step_s: f64) -> Vec<StateVector> {
    let mut state = initial(e);
    let mut one_more = || {
        runge_kutta_step(&mut state, step_s, &e.acceleration_ecef_m_s2);
        state
    };
    (0..NODES).map(|_| one_more()).collect()
}

fn glonass_derivative(s: &StateVector, acceleration: &[f64; 3]) -> StateVector {
    let [x, y, z, vx, vy, vz] = *s;
    let r2 = x * x + y * y + z * z;
    let r3 = r2 * r2.sqrt();
    let w = EARTH_ROTATION_CGCS_RAD_S;
    let a =
        1.5 * J2_GLONASS * MU_GLONASS * EARTH_RADIUS_GLONASS_M * EARTH_RADIUS_GLONASS_M / (r2 * r3);
    let b = 5.0 * z * z / r2;
    let q = -MU_GLONASS / r3 - a * (1.0 - b);
    [
        vx,
        vy,
        vz,
        (q + w * w) * x + 2.0 * w * vy + acceleration[0],
        (q + w * w) * y - 2.0 * w * vx + acceleration[1],
        (q - 2.0 * a) * z + acceleration[2],
    ]
}

fn runge_kutta_step(s: &mut StateVector, step_s: f64, acceleration: &[f64; 3]) {
    let advanced =
        |k: &StateVector, h: f64| -> StateVector { std::array::from_fn(|i| s[i] + k[i] * h) };
    let k1 = glonass_derivative(s, acceleration);
    let k2 = glonass_derivative(&advanced(&k1, step_s / 2.0), acceleration);
    let k3 = glonass_derivative(&advanced(&k2, step_s / 2.0), acceleration);
    let k4 = glonass_derivative(&advanced(&k3, step_s), acceleration);
    for i in 0..6 {
        s[i] += (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) * step_s / 6.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glonass_integration_returns_to_where_it_started() {
        let mut s = [
            7_164_901.8,
            9_075_965.3,
            22_776_057.1,
            -1_541.8,
            2_697.9,
            -595.6,
        ];
        let start = s;
        for step in [60.0; 15].into_iter().chain([-60.0; 15]) {
            runge_kutta_step(&mut s, step, &[0.0, 0.0, -2.8e-6]);
        }
        for k in 0..3 {
            assert!(
                (s[k] - start[k]).abs() < 1e-3,
                "axis {k}: {}",
                s[k] - start[k]
            );
        }
    }
}
