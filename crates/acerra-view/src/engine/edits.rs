//! Changes to a campaign that are tried in the viewer.

use acerra_chain::Track;
use acerra_chain::campaign::{
    Background, Campaign, Delay, Gate, Heights, PreprocessSection, TimeOffset,
};
use serde::{Deserialize, Serialize};

use crate::error::RequestError;

/// Changes to the settings of a run; absent fields keep the run's values.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Edits {
    /// The part of each trace that is kept (ns about 2h/c).
    pub gate_ns: Option<Gate>,
    /// Background subtracted from every trace.
    pub background: Option<Background>,
    /// Lowest and highest frequency (GHz).
    pub band_ghz: Option<[f64; 2]>,
    /// Added to the fast time at which range is zero, of every track (ns).
    pub delay_change_ns: Option<f64>,
    /// Added to trajectory time minus radar time, of every track (s).
    pub time_offset_change_s: Option<f64>,
    /// Height of the image plane (m).
    pub z_m: Option<f64>,
    /// Propagation speed (m/s).
    pub light_speed_m_s: Option<f64>,
}

impl Edits {
    /// The campaign with the changes; `tracks` are those that the run prepared.
    ///
    /// # Errors
    /// A height for an image that is no plane, a delay for spectra, impossible settings.
    pub fn apply(&self, run: &Campaign, tracks: &[Track]) -> Result<Campaign, RequestError> {
        let mut campaign = run.clone();
        if let Some(band_ghz) = self.band_ghz {
            campaign.image.band_ghz = band_ghz;
        }
        if let Some(light_speed_m_s) = self.light_speed_m_s {
            campaign.image.light_speed_m_s = light_speed_m_s;
        }
        if let Some(z_m) = self.z_m {
            if campaign.image.terrain.is_some()
                || matches!(campaign.image.z_m, Some(Heights::Range(_)))
            {
                return Err(RequestError::Invalid {
                    what: "z_m",
                    expected: "no change, as the image is on terrain or is a volume".to_owned(),
                    found: z_m.to_string(),
                });
            }
            campaign.image.z_m = Some(Heights::Plane(z_m));
        }
        self.clean_by(&mut campaign.preprocess);
        for track in &mut campaign.track {
            if let Some(own) = &mut track.preprocess {
                self.clean_by(own);
            }
        }
        self.change_delays(&mut campaign, tracks)?;
        self.change_offsets(&mut campaign, tracks);
        checked(&campaign)
    }

    fn clean_by(&self, section: &mut PreprocessSection) {
        section.background = self.background.or(section.background);
        section.gate_ns = self.gate_ns.unwrap_or(section.gate_ns);
    }

    /// States the delay in force of each track with the change added, instead of its zero-timing.
    fn change_delays(&self, campaign: &mut Campaign, tracks: &[Track]) -> Result<(), RequestError> {
        let Some(change_ns) = self.delay_change_ns.filter(|change| *change != 0.0) else {
            return Ok(());
        };
        let delay = |track: &Track| match &track.cleaned {
            Some(cleaned) => Ok(Delay::Nanoseconds(change_ns - 1e9 * cleaned.shift_s)),
            None => Err(RequestError::Invalid {
                what: "delay_change_ns",
                expected: "no change, as the log holds spectra".to_owned(),
                found: change_ns.to_string(),
            }),
        };
        campaign.preprocess.zero_timing = None;
        if let ([], [only]) = (campaign.track.as_slice(), tracks) {
            campaign.radar.delay_ns = Some(delay(only)?);
        }
        for (section, track) in campaign.track.iter_mut().zip(tracks) {
            section.radar.delay_ns = Some(delay(track)?);
            if let Some(own) = &mut section.preprocess {
                own.zero_timing = None;
            }
        }
        Ok(())
    }

    fn change_offsets(&self, campaign: &mut Campaign, tracks: &[Track]) {
        let Some(change_s) = self.time_offset_change_s.filter(|change| *change != 0.0) else {
            return;
        };
        let offset = |track: &Track| Some(TimeOffset::Seconds(track.time_offset_s + change_s));
        if let ([], [only]) = (campaign.track.as_slice(), tracks) {
            campaign.trajectory.time_offset_s = offset(only);
        }
        for (section, track) in campaign.track.iter_mut().zip(tracks) {
            section.trajectory.time_offset_s = offset(track);
        }
    }
}

/// The campaign as its file would be read: settings that are impossible are refused as there.
fn checked(campaign: &Campaign) -> Result<Campaign, RequestError> {
    Ok(Campaign::parse(&toml::to_string(campaign)?)?)
}
