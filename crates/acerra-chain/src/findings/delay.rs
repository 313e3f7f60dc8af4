//! Findings on the fast time of range zero: by the sharpness of images and by the echo that follows the height.

use std::ops::Range;

use acerra_radar::Spectrum;

use super::grid::LIGHT_SPEED_M_S;
use super::surface::{LEAST_EVIDENCE, MEAN_LEVEL_NS, height_sigma_m};
use crate::align::delay::{DelayCheck, DelayError, DelayScan, check_delay};
use crate::control::{Cancelled, Control};
use crate::focus::ImageRequest;
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::prepare::{Prepared, Track};

/// Judges the delay of a track's radargram above ground, where rays are straight; spectra are taken as they come.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    request: &ImageRequest,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    let is_flat = request.pixels.surface.is_none() && request.underground.is_none();
    if track.cleaned.is_none() || !is_flat {
        return Ok(None);
    }
    let spectrum = spectrum_of(&prepared.spectrum, track);
    let mut grid = request.pixels.grid;
    grid.z_m = request.pixels.middle_m();
    let scan = DelayScan {
        position_m: &prepared.aligned.position_m[track.range.clone()],
        spectrum: &spectrum,
        grid,
        light_speed_m_s: prepared.scene.light_speed_m_s,
    };
    match check_delay(scan, control) {
        Ok(seen) => Ok(seen.map(|seen| delay_sharpness(&seen))),
        Err(DelayError::Cancelled(cancelled)) => Err(cancelled),
        // Pixels that cannot be imaged are refused where they are.
        Err(_) => Ok(None),
    }
}

/// The spectra of one track.
fn spectrum_of(all: &Spectrum, track: &Track) -> Spectrum {
    let width = all.frequency_hz.len();
    let Range { start, end } = track.range.clone();
    Spectrum {
        time_s: all.time_s[start..end].to_vec(),
        frequency_hz: all.frequency_hz.clone(),
        values: all.values[start * width..end * width].to_vec(),
    }
}

/// The fast time of range zero by the echo that follows the height, where one clearly does.
pub(super) fn delay_seen(prepared: &Prepared, track: &Track, shift_s: f64) -> Option<Finding> {
    let cue = track.likelihood.as_ref()?.height.as_ref()?;
    (cue.evidence >= LEAST_EVIDENCE).then(|| {
        let height_s =
            2.0 * height_sigma_m(prepared, track).unwrap_or(0.0) / prepared.scene.light_speed_m_s;
        let sigma_ns = 1e9 * cue.delay_sigma_s.hypot(height_s);
        zero_timing(-1e9 * shift_s, 1e9 * cue.delay_s, sigma_ns)
    })
}

/// Log-likelihood below the sharpest delay from which the delay in force is doubted (odds of 160 000 to 1),
/// and least distance from the nearest delay that agrees (ns): 7.5 cm of range.
const DOUBTFUL_BELOW: f64 = 12.0;
const DOUBTFUL_NS: f64 = 0.5;

/// Largest deviation of a delay that counts as determined (ns).
const LARGEST_SIGMA_NS: f64 = 0.5;

/// Largest time of range zero before the radar's own time zero (ns): the error of a calibration of the
/// instrument.
const BEFORE_ZERO_NS: f64 = 1.0;

/// Judges the fast time taken for range zero, where it comes before the radar's own time zero: no instrument
/// receives before it transmits.
pub(super) fn delay_before_zero(delay_ns: f64) -> Option<Finding> {
    (delay_ns < -BEFORE_ZERO_NS).then(|| {
        Finding::judged("delay_before_zero", delay_ns, "ns", Verdict::Doubtful)
            .expecting(0.0)
            .because(format!(
                "range zero is taken {:.2} ns before the radar's own time zero, when nothing has been \
                 transmitted yet ([radar] delay_ns, [preprocess] zero_timing)",
                -delay_ns
            ))
    })
}

/// Judges the delay in force by the sharpness of images about it. Targets above or below the image plane are
/// sharp at another delay than targets in the plane, so that the delay is at most doubted.
fn delay_sharpness(seen: &DelayCheck) -> Finding {
    let off_ns = -1e9 * seen.later_s;
    let is_off = 1e9 * seen.outside_s > DOUBTFUL_NS && seen.below_best >= DOUBTFUL_BELOW;
    let verdict = if is_off {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Finding {
        checks: (1e9 * seen.sigma_s <= LARGEST_SIGMA_NS).then_some(Setting::Heights),
        sigma: Some(1e9 * seen.sigma_s),
        ..Finding::judged("delay_sharpness", off_ns, "ns", verdict)
    }
    .expecting(0.0)
    .because(format!(
        "the image is sharpest with range zero {:+.2} ns from the delay in force: {:+.2} m of range \
         ([radar] delay_ns, [preprocess] zero_timing, [image] z_m, heights)",
        -off_ns,
        -0.5e-9 * off_ns * LIGHT_SPEED_M_S
    ))
}

/// Delay of half a metre of range (ns).
const FAR_NS: f64 = 3.3;

/// Judges the fast time taken for range zero by the echo that follows the flight's height: `delay_ns` in
/// force, `seen_ns` ± `sigma_ns` by the echo.
pub(super) fn zero_timing(delay_ns: f64, seen_ns: f64, sigma_ns: f64) -> Finding {
    let sigma_ns = sigma_ns.hypot(MEAN_LEVEL_NS);
    let finding = Finding::compared("delay", delay_ns, seen_ns, sigma_ns, "ns");
    // An image half a metre above or below the ground may be meant.
    let is_far = (delay_ns - seen_ns).abs() > FAR_NS;
    let most = if is_far {
        Verdict::Contradicts
    } else {
        Verdict::Doubtful
    };
    finding.checking(Setting::Heights).at_most(most).because(format!(
        "fast time {delay_ns:.2} ns is taken for range zero, the echo that follows the flight's height \
         gives {seen_ns:.2} ns: {:+.2} m of range ([radar] delay_ns, [preprocess] zero_timing, heights)",
        0.5e-9 * (delay_ns - seen_ns) * LIGHT_SPEED_M_S
    ))
}
