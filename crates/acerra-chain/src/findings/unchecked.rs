//! Settings that no data check: wrong values of these leave every finding unchanged.

use acerra_geo::trajectory::TimeOrigin;
use serde::Serialize;

use crate::focus::FocusOptions;
use crate::focus::underground::Underground;
use crate::journal::evidence::Evidence;
use crate::journal::finding::{Finding, Setting};
use crate::position::Positions;
use crate::prepare::{Prepared, Track};

/// The settings that neither a finding of a run nor a surveyed point (`surveyed`) checks, of an image made with `options`
/// above or below the surface of the ground. Spectra are taken as they come, and so are positions in the radar's own file.
#[must_use]
pub fn weigh_unchecked(
    prepared: &Prepared,
    options: &FocusOptions,
    underground: Option<&Underground>,
    evidence: &Evidence,
    surveyed: &[Setting],
) -> Vec<Unchecked> {
    let mut settings = Vec::new();
    if prepared.tracks.iter().any(|track| track.cleaned.is_some()) {
        settings.extend([Setting::Delay, Setting::Heights]);
    }
    let flown = (prepared.tracks.iter()).filter_map(|track| match &track.positions {
        Positions::Trajectory(trajectory) if track.cleaned.is_some() => Some(trajectory),
        _ => None,
    });
    // Positions by trace number have no clock that could be offset.
    if (flown.clone()).any(|flown| flown.time_origin() != TimeOrigin::TraceNumbers) {
        settings.push(Setting::ClockOffset);
    }
    if flown.count() > 0 {
        settings.extend([Setting::LeverArmForward, Setting::LeverArmLeft]);
    }
    if prepared.tracks.iter().any(|track| track.has_local_axes) {
        settings.push(Setting::Axes);
    }
    if options
        .incidence
        .is_some_and(|weight| weight.cosine_power > 0.0)
    {
        settings.extend([Setting::AntennaAxis, Setting::AntennaPattern]);
    }
    if underground.is_some() {
        settings.push(Setting::Permittivity);
    }
    let is_of_base = |finding: &Finding| finding.name.starts_with("base_position");
    if evidence.findings().iter().any(is_of_base) {
        settings.push(Setting::Base);
    }
    let is_surveyed = surveyed.contains(&Setting::Heights);
    let mut tracks = prepared.tracks.iter();
    if prepared.scene.ground.is_uneven() && !is_surveyed && tracks.any(Track::has_zero_by_surface) {
        settings.push(Setting::Datum);
    }
    settings.retain(|setting| !surveyed.contains(setting));
    unchecked(&settings, evidence.findings())
}

/// A setting of a run that no finding checks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Unchecked {
    /// The setting, as the campaign file calls it.
    pub setting: &'static str,
    /// Effect of an error of the setting, and data that would check the setting.
    pub explanation: &'static str,
}

impl Setting {
    /// Text for a setting that nothing checks.
    const fn unchecked(self) -> Unchecked {
        match self {
            Self::ClockOffset => Unchecked {
                setting: "time_offset_s",
                explanation: "height, motion and sharpness do not determine the clock offset to a few \
                              hundredths of a second (the findings clock_offset and clock_offset_focus, \
                              where present, give the accuracy): an error of it moves targets along the \
                              track by as much as the platform flies meanwhile ([trajectory] \
                              time_offset_s). Take-off, turns and reflectors determine it.",
            },
            Self::Delay => Unchecked {
                setting: "delay_ns",
                explanation: "no surface echo that follows the flight's height, no direct coupling in the \
                              window and too few sharp targets determine the fast time of range zero: an \
                              error of 1 ns moves targets by 0.15 m or more ([radar] delay_ns, [preprocess] \
                              zero_timing, [image] light_speed_m_s). A reflector at a surveyed place \
                              determines it (acerra calibrate, [measure] survey).",
            },
            Self::Heights => Unchecked {
                setting: "heights",
                explanation: "no surface echo that follows the flight's height and too few sharp targets \
                              determine the height of the flight above the image plane: an error of it \
                              moves and blurs targets ([image] z_m, [trajectory] origin_deg_m, lever_arm_m \
                              up, height). A reflector at a surveyed place determines it (acerra calibrate, \
                              [measure] survey).",
            },
            Self::Datum => Unchecked {
                setting: "datum of the terrain",
                explanation: "the fast time of range zero was found by the surface echo over the heights of the \
                              terrain: an error that is common to these heights (sea level for the ellipsoid, \
                              another geoid) is taken up by the delay, and moves targets by about as much and \
                              more ([image] terrain, geoid_height_m). A stated [radar] delay_ns, of acerra \
                              calibrate or of the instrument, or a reflector at a surveyed place shows it.",
            },
            Self::LeverArmForward => Unchecked {
                setting: "lever_arm_m forward",
                explanation: "the platform turns too little, or too few targets are sharp, to determine the \
                              lever arm along its nose: an error of it moves every target by as much \
                              ([trajectory] lever_arm_m). Measure it on the platform.",
            },
            Self::LeverArmLeft => Unchecked {
                setting: "lever_arm_m left",
                explanation: "the platform turns too little, or too few targets are sharp, to determine the \
                              lever arm to its left: an error of it moves every target by as much \
                              ([trajectory] lever_arm_m). Measure it on the platform.",
            },
            Self::Base => Unchecked {
                setting: "base_ecef_m below 10 m",
                explanation: "the base's own single-point position shows errors of its stated position from \
                              about 10 m on: smaller ones move the whole image east and north by as much \
                              ([gnss] base_ecef_m). A surveyed point shows them.",
            },
            Self::Axes => Unchecked {
                setting: "axes of the positions",
                explanation: "a file gives the positions in a local frame, and ranges are the same in its \
                              mirror image: axes exchanged or of the wrong sign turn or mirror the image \
                              with the trajectory ([trajectory] file). A surveyed point off the track shows \
                              both.",
            },
            Self::Permittivity => Unchecked {
                setting: "relative_permittivity",
                explanation: "the permittivity of the ground sets every depth: an error of 10 % of it moves depths by \
                              5 %, and 1 cm of water on top that no layer states moves them by 9 cm over the index \
                              of the soil; a wrong thickness of a layer moves what is below the layer. No echo of a \
                              buried point exceeds the clutter, or their hyperbolas, seen from above, hardly change \
                              with it: the finding ground_permittivity, where there is one, gives bounds ([ground] \
                              relative_permittivity, surface_z_m, [[ground.layer]]). A target at a known depth, or a \
                              sample of the soil, determines it.",
            },
            Self::AntennaAxis => Unchecked {
                setting: "antenna_axis",
                explanation: "the antenna is taken to look straight down, and its tilt is unknown: 10° \
                              change the weight by a cos² pattern by up to 1.5 dB at 45° of incidence \
                              ([image] antenna_cosine_power, antenna_axis). Recorded attitudes give it \
                              ([trajectory] file).",
            },
            Self::AntennaPattern => Unchecked {
                setting: "antenna_cosine_power",
                explanation: "no echo shows the antenna's pattern: a wrong power changes the levels of \
                              targets off the antenna's axis, and which maxima are listed ([image] \
                              antenna_cosine_power). The antenna's measured pattern determines it.",
            },
        }
    }
}

/// The settings among `settings` that no finding checks.
fn unchecked(settings: &[Setting], findings: &[Finding]) -> Vec<Unchecked> {
    let is_checked = |setting: &Setting| {
        findings
            .iter()
            .filter_map(|finding| finding.checks)
            .any(|checked| {
                checked == *setting || (checked, *setting) == (Setting::Heights, Setting::Delay)
            })
    };
    settings
        .iter()
        .filter(|setting| !is_checked(setting))
        .map(|setting| setting.unchecked())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::delay::zero_timing;

    #[test]
    fn the_surface_echo_checks_delay_and_heights_and_the_coupling_the_delay() {
        let mut findings = vec![Finding::compared("image_contrast", 30.0, 30.0, 1.0, "dB")];
        let named = |findings: &[Finding]| -> Vec<&str> {
            let settings = [Setting::Delay, Setting::Heights, Setting::ClockOffset];
            unchecked(&settings, findings)
                .iter()
                .map(|one| one.setting)
                .collect()
        };
        assert_eq!(named(&findings), ["delay_ns", "heights", "time_offset_s"]);
        let coupling = Finding::compared("coupling_delay", 1.0, 1.0, 0.5, "ns");
        findings.push(coupling.checking(Setting::Delay));
        assert_eq!(named(&findings), ["heights", "time_offset_s"]);
        findings.push(zero_timing(10.0, 10.1, 0.1));
        assert_eq!(named(&findings), ["time_offset_s"]);
    }
}
