//! The delay in force against the sharpness of images about it.

use std::ops::Range;

use acerra_radar::Spectrum;

use crate::align::delay::{DelayError, DelayScan, check_delay};
use crate::control::{Cancelled, Control};
use crate::findings::evidence::{Finding, delay_sharpness};
use crate::focus::ImageRequest;
use crate::prepare::{Prepared, Track};

/// Judges the delay of a track's radargram; spectra are taken as they come.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    request: &ImageRequest,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    if track.cleaned.is_none() || request.pixels.surface.is_some() {
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
