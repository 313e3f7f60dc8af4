//! Writing the results of a calibration to the keys of the campaign file.

use acerra_chain::calibrate::{Calibrated, Parameter, RestDelay};
use acerra_chain::campaign::{Campaign, ZeroTiming};
use acerra_settings::{Assignment, Step, Value};

/// The keys of everything that was observed.
pub(super) fn keys(campaign: &Campaign, found: &Calibrated) -> Vec<Assignment> {
    let value = |parameter| {
        let estimate = found.estimate(parameter)?;
        let sigma = estimate.sigma?;
        let (_, per_si) = parameter.unit();
        Some(rounded(estimate.value * per_si, sigma * per_si))
    };
    let mut keys = Vec::new();
    if let Some(delay_ns) = value(Parameter::Delay) {
        keys.extend(delay_keys(campaign, delay_ns));
    }
    let offsets = campaign.track.len().max(1);
    for track in 0..offsets {
        if let Some(offset_s) = value(Parameter::ClockOffset(track)) {
            let key = Assignment::new("trajectory", "time_offset_s", Value::Number(offset_s));
            keys.push(key.below(way_to(campaign, track)));
        }
    }
    let arm = [Parameter::Forward, Parameter::Left, Parameter::Up].map(value);
    if arm.iter().any(Option::is_some) {
        let held = found.values.lever_arm_m;
        let arm = [0, 1, 2].map(|i| arm[i].unwrap_or(held[i]));
        for track in 0..offsets {
            let key = Assignment::new("trajectory", "lever_arm_m", Value::Numbers(arm.to_vec()));
            keys.push(key.below(way_to(campaign, track)));
        }
    }
    if found
        .estimate(Parameter::RangeScale)
        .is_some_and(|e| e.sigma.is_some())
    {
        let speed = campaign.image.light_speed_m_s / (1.0 + found.values.range_scale);
        let speed = Value::Number(speed.round());
        keys.push(Assignment::new("image", "light_speed_m_s", speed));
    }
    keys
}

/// The keys of a delay found at rest.
#[must_use]
pub fn keys_at_rest(campaign: &Campaign, found: &RestDelay) -> Vec<Assignment> {
    delay_keys(campaign, rounded(found.delay_s * 1e9, found.sigma_s * 1e9))
}

/// The delay in every track, and a zero-timing that uses it.
fn delay_keys(campaign: &Campaign, delay_ns: f64) -> Vec<Assignment> {
    let each = campaign.each_track();
    let mut keys = Vec::new();
    for (track, one) in each.iter().enumerate() {
        let delay = Assignment::new("radar", "delay_ns", Value::Number(delay_ns));
        keys.push(delay.below(way_to(campaign, track)));
        let stated = one.preprocess.zero_timing;
        let overruled = stated.is_some_and(|stated| stated != ZeroTiming::None);
        let own = campaign
            .track
            .get(track)
            .is_none_or(|t| t.preprocess.is_some());
        if overruled && (own || track == 0) {
            let none = Value::Word("none".to_owned());
            let timing = Assignment::new("preprocess", "zero_timing", none);
            keys.push(if own {
                timing.below(way_to(campaign, track))
            } else {
                timing
            });
        }
    }
    keys
}

/// Path to the tables of a track: the root of a campaign with a single track.
fn way_to(campaign: &Campaign, track: usize) -> Vec<Step> {
    if campaign.track.is_empty() {
        return Vec::new();
    }
    vec![Step::Table("track".to_owned()), Step::Number(track)]
}

/// A value with one digit more than its deviation warrants.
fn rounded(value: f64, sigma: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped")]
    let digits = (1.0 - sigma.max(1e-12).log10().floor()).clamp(0.0, 9.0) as i32;
    let scale = 10.0_f64.powi(digits);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stated_zero_timing_gives_way_to_the_delay() {
        let campaign = |zero_timing: &str| {
            Campaign::parse(&format!(
                "[radar]\nfile = 'a.mrm'\n[trajectory]\nfile = 'a.pos'\n[preprocess]\n\
                 {zero_timing}\n[image]\nx_m = [0, 1]\ny_m = [0, 1]\n"
            ))
            .unwrap()
        };
        let found = RestDelay {
            delay_s: 10.123_456e-9,
            sigma_s: 0.02e-9,
            contrast_db: 40.0,
            coupling_seen: true,
            traces: 9,
        };
        let keys = keys_at_rest(&campaign("zero_timing = 'first-trace'"), &found);
        assert_eq!(keys[0].value, Value::Number(10.123));
        assert_eq!((keys.len(), keys[1].key.as_str()), (2, "zero_timing"));
        assert_eq!(keys_at_rest(&campaign(""), &found).len(), 1);
    }
}
