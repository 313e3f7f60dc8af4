//! Findings on a track's radargram: the surface echo beside 2h/c.

use acerra_radar::clean::{SurfaceOptions, track_surface};

use crate::evidence::{Finding, SurfaceSeen, surface};
use crate::prepare::{Prepared, Track};
use crate::weigh::median;

/// Picks below which an echo says nothing.
const LEAST_PICKS: usize = 20;
/// How far from 2h/c the surface echo is looked for where fast time is calibrated (s).
const SEARCH_S: f64 = 15e-9;
/// Timing of the echo itself (ns).
const TIMING_NS: f64 = 0.05;

/// Judges the radargram of a track; nothing where its log holds spectra.
pub(super) fn weigh(prepared: &Prepared, track: &Track) -> Vec<Finding> {
    surface_seen(prepared, track)
        .map(|seen| surface(&seen))
        .unwrap_or_default()
}

/// The surface echo of the zero-timed traces, where one follows the height.
fn surface_seen(prepared: &Prepared, track: &Track) -> Option<SurfaceSeen> {
    let traces = track.cleaned.as_ref()?;
    let aligned = &prepared.aligned;
    let height_m = aligned.height_m.get(track.range.clone())?;
    let options = SurfaceOptions {
        approximate_delay_s: Some(0.0),
        search_s: SEARCH_S,
        ..SurfaceOptions::default()
    };
    let echo = track_surface(&traces.raw, height_m, &options).ok()?;
    let two_way_s = |height_m: f64| 2.0 * height_m / prepared.scene.light_speed_m_s;
    let (position, residual_ns): (Vec<f64>, Vec<f64>) = echo
        .picks
        .iter()
        .zip(height_m)
        .enumerate()
        .filter_map(|(k, (pick, height_m))| {
            let pick = pick.as_ref()?;
            let share = k as f64 / echo.picks.len() as f64;
            Some((share, 1e9 * (pick.fast_time_s - two_way_s(*height_m))))
        })
        .unzip();
    if residual_ns.len() < LEAST_PICKS {
        return None;
    }
    let level_ns = median(residual_ns.iter().copied())?;
    let spread_ns = 1.4826 * median(residual_ns.iter().map(|r| (r - level_ns).abs()))?;
    let sigma_z_m = aligned
        .sigma_m
        .get(track.range.clone())
        .and_then(|sigma| median(sigma.iter().map(|s| s[2])));
    let expected_spread_ns = TIMING_NS.hypot(1e9 * two_way_s(sigma_z_m.unwrap_or(0.02)));
    let (drift_ns, drift_sigma_ns) = drift(&position, &residual_ns, spread_ns);
    Some(SurfaceSeen {
        level_ns,
        spread_ns,
        expected_spread_ns,
        drift_ns,
        drift_sigma_ns,
        is_calibrated: track.is_calibrated,
    })
}

/// Change over the flight of a straight line through the residuals, and its standard deviation
/// (ns).
fn drift(position: &[f64], residual_ns: &[f64], spread_ns: f64) -> (f64, f64) {
    let count = position.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (middle, level) = (mean(position), mean(residual_ns));
    let (mut product, mut square) = (0.0, 0.0);
    for (p, r) in position.iter().zip(residual_ns) {
        // Strays must not tilt the line.
        let r = (r - level).clamp(-3.0 * spread_ns, 3.0 * spread_ns);
        product += (p - middle) * r;
        square += (p - middle).powi(2);
    }
    if square <= 0.0 {
        return (0.0, f64::INFINITY);
    }
    (product / square, spread_ns / square.sqrt())
}
