//! Rounds of a calibration: echoes are taken in narrowing windows and adjusted to, round after round.

use super::adjust::{Adjusted, Adjustment};
use super::error::CalibrateError;
use super::observe;
use super::parameter::{Parameter, Values};
use super::search;
use super::track::{Echo, Setting, TrackEchoes};
use crate::control::Control;

/// Half widths of the windows in which echoes are taken, round after round (s). The first holds
/// what a lever arm forgotten or of the wrong sign displaces.
pub(super) const WINDOWS_S: [f64; 4] = [1.5e-9, 1.0e-9, 0.7e-9, 0.7e-9];

/// The tracks, and what the campaign says of them.
pub(super) struct Survey<'a> {
    pub setting: Setting<'a>,
    pub tracks: &'a [TrackEchoes],
    pub campaign: &'a Values,
    pub correlation_s: f64,
}

/// Echoes and what was made of them.
pub(super) struct Round {
    pub echoes: Vec<Echo>,
    pub adjusted: Adjusted,
    pub knows_position_errors: bool,
}

impl Survey<'_> {
    /// A first adjustment of delay and offsets, from the highest stacks.
    pub fn start(&self, control: &Control<'_>) -> Result<Round, CalibrateError> {
        let mut values = self.campaign.clone();
        let mut best_contrast = 0.0;
        for (number, track) in self.tracks.iter().enumerate() {
            let found = search::search(&self.setting, track, number, self.campaign, control)?;
            values.time_offset_s[number] = found.offset_s;
            if found.contrast > best_contrast {
                best_contrast = found.contrast;
                values.delay_s = found.delay_s;
            }
        }
        self.round(&values, WINDOWS_S[0], true)
    }

    /// Takes the echoes near where `values` put them, and adjusts. At first only delay and offsets.
    pub fn round(
        &self,
        values: &Values,
        half_width_s: f64,
        first: bool,
    ) -> Result<Round, CalibrateError> {
        let echoes: Vec<Echo> = self
            .tracks
            .iter()
            .enumerate()
            .flat_map(|(number, track)| track.echoes(&self.setting, number, values, half_width_s))
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
        let held = observe::unobserved(&information, &values.parameters(), fixed);
        let mut start = values.clone();
        for parameter in &held {
            start.add(
                *parameter,
                self.campaign.get(*parameter) - start.get(*parameter),
            );
        }
        let adjusted = adjustment.solve(&start, &held)?;
        let knows_position_errors = adjustment.knows_position_errors();
        Ok(Round {
            echoes,
            adjusted,
            knows_position_errors,
        })
    }
}
