//! The state of an epoch as a result.

use super::epoch_result::EpochResult;
use super::residuals::Update;
use super::{EpochView, Filter};
use crate::ambiguity::attempt::Attempt;
use crate::observations::satellite::System;
use crate::single::SinglePoint;
use crate::solution::{NotFixedReason, Quality, SatelliteResidual};
use crate::stations::epoch_input::{BaseView, RoverEpoch};
use std::sync::Arc;

impl EpochResult {
    /// The result of an epoch whose only position is the single-point position.
    pub(super) fn from_single(
        rover: &RoverEpoch,
        single: &SinglePoint,
        base: Option<&BaseView<'_>>,
    ) -> Self {
        Self {
            tag: rover.epoch.tag,
            time: single.time,
            position_ecef_m: single.position_ecef_m,
            covariance_ecef_m2: single.covariance_ecef_m2,
            velocity: single.velocity,
            quality: None,
            satellites: single.satellites,
            age_s: base.map_or(0.0, |b| b.age_s),
            ratio: 0.0,
            reason: None,
            residuals: Arc::default(),
            phase_misfit: [0.0; 2],
            phase_residuals: Vec::new(),
            code_residuals: Vec::new(),
            float_misfit: None,
            anchored: false,
            channel_slope_m: None,
            integers: None,
            base: base.and_then(|b| b.moved),
        }
    }

    pub(super) fn not_fixed(self, reason: NotFixedReason) -> Self {
        Self {
            reason: Some(reason),
            ..self
        }
    }
}

impl Filter<'_> {
    /// Position, velocity and residuals of the float state.
    pub(super) fn report_float(
        &self,
        result: &mut EpochResult,
        epoch: &EpochView<'_>,
        update: &Update,
    ) {
        let rows = &update.differences.rows;
        result.satellites = self.count_valid(rows, &epoch.common);
        result.position_ecef_m = self.state.position();
        result.covariance_ecef_m2 =
            std::array::from_fn(|i| std::array::from_fn(|j| self.state.covariance(i, j)));
        if self.state.position_states == 9 && self.state.exists[3] {
            result.velocity = Some((
                [self.state.x[3], self.state.x[4], self.state.x[5]],
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| self.state.covariance(3 + i, 3 + j))
                }),
            ));
        }
        let satellites = epoch.common.len();
        // Residuals of phase and code by slot and common satellite; the reference's are zero.
        let mut found = vec![[None; 2]; self.options.frequencies * satellites];
        for r in rows {
            let own = &mut found[r.slot * satellites + r.other][usize::from(r.is_code)];
            own.get_or_insert(r.residual_m);
        }
        for r in rows {
            let own = &mut found[r.slot * satellites + r.reference][usize::from(r.is_code)];
            own.get_or_insert(0.0);
        }
        let mut residuals = std::mem::take(Arc::make_mut(&mut result.residuals));
        residuals.reserve(found.len());
        for slot in 0..self.options.frequencies {
            for (k, c) in epoch.common.iter().enumerate() {
                let [phase_m, code_m] = found[slot * satellites + k];
                if phase_m.is_none() && code_m.is_none() {
                    continue;
                }
                let z = &update.zero[c.rover];
                residuals.push(SatelliteResidual {
                    satellite: self.constellation.id(c.satellite),
                    slot,
                    azimuth_rad: z.azimuth_rad(),
                    elevation_rad: z.elevation_rad,
                    phase_m,
                    code_m,
                    slipped: self.state.track(c.satellite, slot).slipped(),
                    fixed: false,
                });
            }
        }
        result.residuals = Arc::new(residuals);
    }

    /// Position and velocity with the integers of `attempt` imposed.
    pub(super) fn report_fix(&self, result: &mut EpochResult, attempt: &Attempt) {
        let np = self.state.leading_states;
        let block = |first: usize| {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| attempt.p[(first + i) * np + first + j])
            })
        };
        let vector = |first: usize| std::array::from_fn(|i| attempt.x[first + i]);
        result.quality = Some(Quality::Fixed);
        result.position_ecef_m = vector(0);
        result.covariance_ecef_m2 = block(0);
        if self.state.position_states == 9 {
            result.velocity = Some((vector(3), block(3)));
        }
        let glonass = |satellite| self.constellation.id(satellite).system() == System::Glonass;
        if let Some(k) = self.state.channel_slope_index()
            && attempt.pairs.iter().filter(|p| glonass(p.other)).count() >= 2
        {
            result.channel_slope_m = Some([attempt.x[k], attempt.p[k * np + k].max(0.0).sqrt()]);
        }
        for r in Arc::make_mut(&mut result.residuals) {
            r.fixed = self
                .constellation
                .index(r.satellite)
                .is_some_and(|s| self.state.track(s, r.slot).in_fix);
        }
    }
}
