//! What an epoch's state says, as a result.

use super::residuals::Update;
use super::{EpochView, Filter};
use crate::engine::ambiguity::Attempt;
use crate::engine::epoch_input::{BaseView, RoverEpoch};
use crate::engine::epoch_result::EpochResult;
use crate::engine::single::SinglePoint;
use crate::satellite::System;
use crate::solution::{NotFixedReason, Quality, SatelliteResidual};

impl EpochResult {
    /// The result of an epoch that has nothing better than its single-point position.
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
            residuals: Vec::new(),
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
        result
            .residuals
            .reserve(self.options.frequencies * epoch.common.len());
        for slot in 0..self.options.frequencies {
            for (k, c) in epoch.common.iter().enumerate() {
                let of = |is_code: bool| {
                    let mut own = rows
                        .iter()
                        .filter(|r| r.slot == slot && r.is_code == is_code);
                    own.clone()
                        .find(|r| r.other == k)
                        .map(|r| r.residual_m)
                        .or_else(|| own.any(|r| r.reference == k).then_some(0.0))
                };
                let (phase_m, code_m) = (of(false), of(true));
                if phase_m.is_none() && code_m.is_none() {
                    continue;
                }
                let z = &update.zero[c.rover];
                result.residuals.push(SatelliteResidual {
                    satellite: self.constellation.id(c.satellite),
                    slot,
                    azimuth_rad: z.azimuth_rad,
                    elevation_rad: z.elevation_rad,
                    phase_m,
                    code_m,
                    slipped: self.state.track(c.satellite, slot).slipped(),
                    fixed: false,
                });
            }
        }
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
        for r in &mut result.residuals {
            r.fixed = self
                .constellation
                .index(r.satellite)
                .is_some_and(|s| self.state.track(s, r.slot).in_fix);
        }
    }
}
