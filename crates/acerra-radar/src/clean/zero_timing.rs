//! Zero-timing: fast time becomes the two-way delay (paper §2).

use super::background::median_of;
use super::surface::{SurfaceOptions, SurfaceTrack, track_surface};
use super::{CleanError, check_heights};
use crate::constants::two_way_delay_s;
use crate::radargram::Radargram;

/// Ways of zero-timing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ZeroTiming {
    /// The surface echo of the first trace is placed at 2h/c, as in the paper.
    FirstTrace(SurfaceOptions),
    /// The median of the surface echoes of all traces is placed at 2h/c: one poor first trace has no effect.
    AllTraces(SurfaceOptions),
    /// Fast time is shifted by a given number of seconds.
    Shift(f64),
    /// The delay at which range is zero is known by calibration, s.
    Delay(f64),
    /// Fast time is unchanged.
    None,
}

/// Result of zero-timing.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroTimingResult {
    /// The radargram with its fast time shifted.
    pub radargram: Radargram,
    /// The shift, s: new fast time = old fast time + shift.
    pub shift_s: f64,
    /// The followed surface echo, in the old fast time, where one was searched.
    pub surface: Option<SurfaceTrack>,
    /// Surface echo less 2h/c after the shift, for each trace, s.
    pub residual_s: Vec<Option<f64>>,
    /// Median of the residuals, s: 0 where the first trace alone defines the shift.
    pub median_residual_s: Option<f64>,
    /// Median distance of the residuals from their median, s.
    pub spread_s: Option<f64>,
}

/// Shifts fast time so that it is the two-way delay 2R/c.
///
/// `height_m` is the radar's height above the surface at each trace; traces whose height is NaN
/// are left out.
///
/// # Errors
/// As [`track_surface`]; for [`ZeroTiming::FirstTrace`] also if the first trace has no height or
/// its surface lies outside the window.
pub fn zero_timing(
    radargram: Radargram,
    height_m: &[f64],
    method: &ZeroTiming,
) -> Result<ZeroTimingResult, CleanError> {
    check_heights(radargram.traces, height_m)?;
    let given = |radargram: Radargram, shift_s: f64| ZeroTimingResult {
        residual_s: vec![None; radargram.traces],
        radargram: radargram.shifted(shift_s),
        shift_s,
        surface: None,
        median_residual_s: None,
        spread_s: None,
    };
    let (options, first_only) = match method {
        ZeroTiming::None => return Ok(given(radargram, 0.0)),
        ZeroTiming::Shift(shift_s) => return Ok(given(radargram, *shift_s)),
        ZeroTiming::Delay(delay_s) => return Ok(given(radargram, -delay_s)),
        ZeroTiming::FirstTrace(options) => (options, true),
        ZeroTiming::AllTraces(options) => (options, false),
    };
    if first_only && !(height_m[0].is_finite() && height_m[0] > 0.0) {
        return Err(CleanError::Height {
            trace: 0,
            height_m: height_m[0],
        });
    }
    let surface = track_surface(&radargram, height_m, options)?;
    let delays: Vec<Option<f64>> = surface
        .picks
        .iter()
        .zip(height_m)
        .map(|(pick, &h)| pick.map(|p| p.fast_time_s - two_way_delay_s(h)))
        .collect();
    let mut known: Vec<f64> = delays.iter().flatten().copied().collect();
    let delay_s = match (first_only, delays[0]) {
        (true, Some(first)) => first,
        (false, _) if !known.is_empty() => median_of(&mut known),
        _ => {
            return Err(CleanError::SurfaceOutside {
                window_start_s: radargram.fast_time_start_s,
                window_end_s: radargram.fast_time_end_s(),
                expected_start_s: two_way_delay_s(height_m[0]) + surface.delay_s,
                expected_end_s: two_way_delay_s(height_m[0]) + surface.delay_s,
            });
        }
    };
    let residual_s: Vec<Option<f64>> = delays.iter().map(|d| d.map(|d| d - delay_s)).collect();
    let mut residuals: Vec<f64> = residual_s.iter().flatten().copied().collect();
    let median = median_of(&mut residuals);
    let mut distances: Vec<f64> = residuals.iter().map(|r| (r - median).abs()).collect();
    Ok(ZeroTimingResult {
        radargram: radargram.shifted(-delay_s),
        shift_s: -delay_s,
        surface: Some(surface),
        residual_s,
        median_residual_s: Some(median),
        spread_s: Some(median_of(&mut distances)),
    })
}
