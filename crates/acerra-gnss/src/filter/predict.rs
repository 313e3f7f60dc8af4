//! Prediction from one epoch to the next: position, motion, biases.

use super::{EpochView, Filter};
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::options::{AmbiguityMode, PositioningMode};
use crate::single::SinglePoint;
use acerra_geo::geodesy::EnuFrame;

/// Variance of a position taken from a single-point solution (m²).
pub(super) const POSITION_VARIANCE_M2: f64 = 900.0;
const VELOCITY_VARIANCE: f64 = 100.0;
const ACCELERATION_VARIANCE: f64 = 100.0;
/// Accelerations start at a small non-zero value, since a state of exactly zero counts as absent in RTKLIB.
const INITIAL_ACCELERATION: f64 = 1e-6;

impl Filter<'_> {
    pub(super) fn predict_position(&mut self, single: &SinglePoint, elapsed_s: f64) {
        let first = !self.state.exists[0];
        match (self.options.mode, self.options.dynamics) {
            (PositioningMode::Static, _) => {
                if first {
                    self.initialise_position(single);
                }
            }
            (_, None) => {
                let sigma_m = self.options.single_point_sigma_m;
                self.initialise_position_with(single, sigma_m * sigma_m);
            }
            (_, Some(dynamics)) => {
                let variance = (0..3).map(|k| self.state.covariance(k, k)).sum::<f64>() / 3.0;
                if first || variance > POSITION_VARIANCE_M2 {
                    self.initialise_position(single);
                    self.initialise_motion(single);
                } else {
                    self.propagate(elapsed_s, variance);
                    let frame = EnuFrame::from_ecef(self.state.position());
                    let (h, v) = (
                        dynamics.horizontal_noise.powi(2) * elapsed_s.abs(),
                        dynamics.vertical_noise.powi(2) * elapsed_s.abs(),
                    );
                    let noise = frame.ecef_covariance_from_enu(&[
                        [h, 0.0, 0.0],
                        [0.0, h, 0.0],
                        [0.0, 0.0, v],
                    ]);
                    for (i, row) in noise.iter().enumerate() {
                        for (j, value) in row.iter().enumerate() {
                            *self.state.covariance_mut(6 + i, 6 + j) += value;
                        }
                    }
                }
            }
        }
    }

    pub(super) fn initialise_position(&mut self, single: &SinglePoint) {
        self.initialise_position_with(single, POSITION_VARIANCE_M2);
    }

    fn initialise_position_with(&mut self, single: &SinglePoint, variance_m2: f64) {
        for k in 0..3 {
            self.state
                .initialise(k, single.position_ecef_m[k], variance_m2);
        }
        // In static mode a motion model has no effect.
        for k in 3..self.state.position_states {
            if !self.state.exists[k] {
                self.state.initialise(k, 0.0, 0.0);
                self.state.exists[k] = false;
            }
        }
    }

    pub(super) fn initialise_motion(&mut self, single: &SinglePoint) {
        let velocity = single.velocity.map_or([0.0; 3], |(v, _)| v);
        for (k, v) in velocity.into_iter().enumerate() {
            self.state.initialise(3 + k, v, VELOCITY_VARIANCE);
            self.state
                .initialise(6 + k, INITIAL_ACCELERATION, ACCELERATION_VARIANCE);
        }
    }

    /// p += v·t + a·t²/2, v += a·t, P ← FPFᵀ, for all states at once.
    pub(super) fn propagate(&mut self, t: f64, position_variance: f64) {
        let use_acceleration = self.options.policy().always_accelerates()
            || position_variance < self.options.position_variance_gate_m2;
        let half = if use_acceleration { t * t / 2.0 } else { 0.0 };
        let n = self.state.len();
        for k in 0..3 {
            let (v, a) = (self.state.x[3 + k], self.state.x[6 + k]);
            self.state.x[k] += v * t + a * half;
            self.state.x[3 + k] += a * t;
        }
        // F differs from the identity in the position and velocity rows only.
        for column in 0..n {
            for k in 0..3 {
                let (v, a) = (
                    self.state.covariance(3 + k, column),
                    self.state.covariance(6 + k, column),
                );
                *self.state.covariance_mut(k, column) += v * t + a * half;
                *self.state.covariance_mut(3 + k, column) += a * t;
            }
        }
        for row in 0..n {
            for k in 0..3 {
                let (v, a) = (
                    self.state.covariance(row, 3 + k),
                    self.state.covariance(row, 6 + k),
                );
                *self.state.covariance_mut(row, k) += v * t + a * half;
                *self.state.covariance_mut(row, 3 + k) += a * t;
            }
        }
    }

    pub(super) fn predict_biases(&mut self, epoch: &EpochView<'_>, elapsed_s: f64) {
        let options = self.options;
        let policy = options.policy();
        let common = &epoch.common[..];
        let instantaneous = options.ambiguity == AmbiguityMode::Instantaneous;
        for slot in 0..options.frequencies {
            self.age_tracks(slot, instantaneous);
            let walk = self.noise.phase_walk_cycles2_s.unwrap_or(0.0);
            let growth = walk.max(options.bias_noise_cycles.powi(2)) * elapsed_s.abs();
            for c in common {
                let index = self.state.bias_index(c.satellite, slot);
                *self.state.covariance_mut(index, index) += growth;
                let track = self.state.track_mut(c.satellite, slot);
                let slipped = track.slipped() || policy.is_slip(track.rejections);
                track.slips += u32::from(slipped);
                if !instantaneous && slipped {
                    track.lock = -options.min_lock_epochs;
                    track.rejections = 0;
                    self.state.remove(index);
                }
            }
            let code_phase: Vec<Option<f64>> = common
                .iter()
                .map(|c| {
                    let u = &epoch.rover.epoch.measurements[c.rover];
                    let b = &epoch.base.epoch.measurements[c.base];
                    let frequency = u.frequency_hz[slot];
                    let (lu, lb) = (u.phase_cycles[slot], b.phase_cycles[slot]);
                    let (pu, pb) = (u.code_m[slot], b.code_m[slot]);
                    let complete = lu != 0.0
                        && lb != 0.0
                        && pu != 0.0
                        && pb != 0.0
                        && frequency != 0.0
                        && b.frequency_hz[slot] == frequency;
                    complete.then(|| (lu - lb) - (pu - pb) * frequency / SPEED_OF_LIGHT_M_S)
                })
                .collect();
            // One common offset keeps biases near code minus phase, since receiver clocks drift.
            let offsets: Vec<f64> = common
                .iter()
                .zip(&code_phase)
                .filter_map(|(c, beta)| Some((*beta)? - self.state.bias(c.satellite, slot)?))
                .collect();
            if !offsets.is_empty() {
                let mean = offsets.iter().sum::<f64>() / offsets.len() as f64;
                for satellite in 0..self.constellation.len() {
                    let index = self.state.bias_index(satellite, slot);
                    if self.state.exists[index] {
                        self.state.x[index] += mean;
                    }
                }
            }
            for (c, beta) in common.iter().zip(&code_phase) {
                let index = self.state.bias_index(c.satellite, slot);
                if let (Some(beta), false) = (beta, self.state.exists[index]) {
                    self.state.initialise_bias(c.satellite, slot, *beta);
                    self.state.track_mut(c.satellite, slot).began = self.last_time;
                    if policy.new_ambiguities_wait() {
                        self.state.track_mut(c.satellite, slot).lock = -options.min_lock_epochs;
                    }
                }
            }
        }
    }

    /// Counts outages and forgets the biases of satellites gone for too long.
    pub(super) fn age_tracks(&mut self, slot: usize, instantaneous: bool) {
        for satellite in 0..self.constellation.len() {
            let index = self.state.bias_index(satellite, slot);
            let exists = self.state.exists[index];
            let track = self.state.track_mut(satellite, slot);
            track.outage = track.outage.saturating_add(1);
            let gone = track.outage > self.options.max_outage_epochs;
            track.slips += u32::from(gone);
            if gone && !instantaneous {
                track.lock = -self.options.min_lock_epochs;
            }
            if exists && (gone || instantaneous) {
                if !instantaneous {
                    track.outage = 0;
                }
                self.state.remove(index);
            }
        }
    }

    /// Forgets every phase bias.
    pub(super) fn forget_biases(&mut self) {
        for index in self.state.leading_states..self.state.len() {
            if self.state.exists[index] {
                self.state.remove(index);
            }
        }
        for track in &mut self.state.tracks {
            track.lock = -self.options.min_lock_epochs;
            track.valid = false;
        }
    }
}
