//! Rounds of a calibration: echoes are taken in narrowing windows and adjusted to, round after round.

use super::adjust::{Adjusted, Adjustment};
use super::error::CalibrateError;
use super::model::predict;
use super::observe;
use super::parameter::{Parameter, Values};
use super::search;
use super::stretch_echoes::stretch_echoes;
use super::track::{Echo, Setting, TrackEchoes};
use crate::control::Control;

/// Half widths of the windows in which echoes are picked, round after round (s). The first includes
/// displacements by a lever arm that is missing or of the wrong sign.
pub(super) const WINDOWS_S: [f64; 4] = [1.5e-9, 1.0e-9, 0.7e-9, 0.7e-9];

/// The tracks, and the campaign's values for them.
pub(super) struct Survey<'a> {
    pub setting: Setting<'a>,
    pub tracks: &'a [TrackEchoes],
    pub campaign: &'a Values,
    pub correlation_s: f64,
    /// Echoes of each track by coherent sums, where its single traces do not show them.
    pub summed: Vec<Option<Vec<Echo>>>,
}

/// Echoes and the estimate from them.
pub(super) struct Round {
    pub echoes: Vec<Echo>,
    pub adjusted: Adjusted,
    pub knows_position_errors: bool,
}

impl Survey<'_> {
    /// A first adjustment of delay and offsets, from where each track's reflectors are in focus.
    pub fn start(&mut self, control: &Control<'_>) -> Result<Round, CalibrateError> {
        let mut values = self.campaign.clone();
        let mut best_db = 0.0;
        self.summed.clear();
        for (number, track) in self.tracks.iter().enumerate() {
            let found = search::search(&self.setting, track, self.campaign, control)?;
            values.time_offset_s[number] = found.offset_s;
            if found.contrast_db > best_db {
                best_db = found.contrast_db;
                values.delay_s = found.delay_s;
            }
            let summed = stretch_echoes(&self.setting, track, number, self.campaign, &found);
            self.summed.push(summed);
        }
        self.round(&values, WINDOWS_S[0], true)
    }

    /// The echoes of a track within `half_width_s` of where the model puts them.
    fn echoes(&self, number: usize, values: &Values, half_width_s: f64) -> Vec<Echo> {
        let track = &self.tracks[number];
        let Some(Some(summed)) = self.summed.get(number) else {
            return track.echoes(&self.setting, number, values, half_width_s);
        };
        let sampler = track.path.sampler();
        let c = self.setting.light_speed_m_s;
        let is_near = |echo: &&Echo| {
            let pose = sampler.at(echo.time_s, values.time_offset_s[number]);
            let place_m = self.setting.reflector_m[echo.reflector];
            pose.is_some_and(|pose| {
                let expected_m = predict(values, &pose, place_m, c).range_m;
                (echo.range_m - expected_m).abs() < 0.5 * c * half_width_s
            })
        };
        summed.iter().filter(is_near).copied().collect()
    }

    /// Takes the echoes near where `values` put them, and adjusts. At first only delay and offsets.
    pub fn round(
        &self,
        values: &Values,
        half_width_s: f64,
        first: bool,
    ) -> Result<Round, CalibrateError> {
        let echoes: Vec<Echo> = (0..self.tracks.len())
            .flat_map(|number| self.echoes(number, values, half_width_s))
            .collect();
        let samplers: Vec<_> = self.tracks.iter().map(|t| t.path.sampler()).collect();
        let adjustment =
            Adjustment::new(self.setting, &samplers, &echoes, values, self.correlation_s);
        let fixed = if first {
            vec![
                Parameter::RangeScale,
                Parameter::Forward,
                Parameter::Left,
                Parameter::Up,
            ]
        } else {
            Vec::new()
        };
        let information = adjustment.information(values);
        let parameters = values.parameters();
        let held = observe::unobserved(&information, &parameters, fixed.clone());
        let mut start = values.clone();
        // A delay that the echoes' ranges leave open takes the value at which the reflectors are in focus,
        // with the offsets found there.
        let is_found = |p: &Parameter| matches!(p, Parameter::Delay | Parameter::ClockOffset(_));
        let keeps_found = held.contains(&Parameter::Delay);
        for parameter in held.iter().filter(|p| !(keeps_found && is_found(p))) {
            start.add(
                *parameter,
                self.campaign.get(*parameter) - start.get(*parameter),
            );
        }
        let mut adjusted = adjustment.solve(&start, &held)?;
        // Misfits of wrong values count as noise: unknowns that the residuals of the solution determine are
        // free.
        let still_held = observe::unobserved(&adjusted.normal.information, &parameters, fixed);
        if still_held.iter().all(|p| held.contains(p)) && still_held.len() < held.len() {
            adjusted = adjustment.solve(&adjusted.values, &still_held)?;
        }
        let knows_position_errors = adjustment.knows_position_errors();
        Ok(Round {
            echoes,
            adjusted,
            knows_position_errors,
        })
    }
}
