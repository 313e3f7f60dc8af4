//! Which settings of a run nothing has checked.

use crate::findings::evidence::{Evidence, Finding, Setting, Unchecked, unchecked};
use crate::focus::FocusOptions;
use crate::position::Positions;
use crate::prepare::Prepared;

/// The settings that no finding of a run checks. Spectra are taken as they come, and so are positions
/// that stand in the radar's own file.
#[must_use]
pub fn weigh_unchecked(
    prepared: &Prepared,
    options: &FocusOptions,
    evidence: &Evidence,
) -> Vec<Unchecked> {
    let mut settings = Vec::new();
    if prepared.tracks.iter().any(|track| track.cleaned.is_some()) {
        settings.extend([Setting::Delay, Setting::Heights]);
    }
    let is_flown = |positions: &Positions| matches!(positions, Positions::Trajectory(_));
    if prepared
        .tracks
        .iter()
        .any(|track| track.cleaned.is_some() && is_flown(&track.positions))
    {
        settings.extend([
            Setting::ClockOffset,
            Setting::LeverArmForward,
            Setting::LeverArmLeft,
        ]);
    }
    if prepared.tracks.iter().any(|track| track.has_local_axes) {
        settings.push(Setting::Axes);
    }
    if options
        .incidence
        .is_some_and(|weight| weight.cosine_power > 0.0)
    {
        settings.push(Setting::AntennaAxis);
    }
    let is_of_base = |finding: &Finding| finding.name.starts_with("base_position");
    if evidence.findings().iter().any(is_of_base) {
        settings.push(Setting::Base);
    }
    unchecked(&settings, evidence.findings())
}
