//! Findings on a track's radargram: clock, fast-time zero, surface echo, coupling, spectrum.

use acerra_radar::clean::{SurfaceOptions, track_surface};

use acerra_radar::Radargram;
use acerra_radar::quality::{self, spectrum_occupancy};

use crate::findings::evidence::{
    ClockSeen, CouplingSeen, Finding, SurfaceSeen, Verdict, band, band_used, clock_offset,
    clock_offset_sigma, coupling, delay_before_zero, recorded_clock_sigma, surface, zero_timing,
};
use crate::findings::weigh::altimeter;
use crate::findings::weigh::median::median;
use crate::prepare::{Prepared, Track};

/// Picks below which an echo says nothing.
const LEAST_PICKS: usize = 20;
/// How far from 2h/c the surface echo is looked for where fast time is calibrated (s).
const SEARCH_S: f64 = 15e-9;
/// Timing of the echo itself (ns).
const TIMING_NS: f64 = 0.05;

/// Log-likelihood over an unrelated echo from which the one that follows the height is believed.
const LEAST_EVIDENCE: f64 = 12.0;
/// Standard deviation of heights up to which they are believed to follow the flight (m).
const BELIEVED_SIGMA_M: f64 = 0.1;
/// Coupling stands so far above the rest of the mean trace (dB), this still (s), and no further
/// than this from fast time zero (s).
const COUPLING_CONTRAST_DB: f64 = 20.0;
const COUPLING_SPREAD_S: f64 = 0.1e-9;
const COUPLING_REACH_S: f64 = 25e-9;

/// Judges the radargram of a track; nothing where its log holds spectra.
pub(super) fn weigh(prepared: &Prepared, track: &Track, band_hz: [f64; 2]) -> Vec<Finding> {
    let mut findings = Vec::new();
    findings.extend(clock_seen(track).map(|seen| {
        // Motion alone, or heights no better than the wander itself, may doubt an offset only.
        let most = if height_speaks(prepared, track) {
            Verdict::Contradicts
        } else {
            Verdict::Doubtful
        };
        clock_offset(&seen).at_most(most)
    }));
    findings.extend(offset_sigma(prepared, track));
    let Some(traces) = &track.cleaned else {
        return findings;
    };
    findings.extend(delay_before_zero(-1e9 * traces.shift_s));
    findings.extend(delay_seen(prepared, track, traces.shift_s));
    // An echo counts as the surface where it is known to follow the height.
    if follows_height(track)
        && let Some(seen) = surface_seen(prepared, track)
    {
        // Over a short stretch a strong target may be taken for the surface: where the height itself
        // does not speak against the offset, the spread may doubt only.
        let speaks = height_speaks(prepared, track);
        findings.extend(surface(&seen).into_iter().map(|finding| {
            if finding.name == "surface_spread" && !speaks {
                finding.at_most(Verdict::Doubtful)
            } else {
                finding
            }
        }));
    }
    if !follows_height(track) {
        findings.extend(altimeter::weigh(prepared, track, traces));
    }
    findings.extend(coupling_seen(&traces.raw).map(|seen| coupling(&seen)));
    if let Some(spectrum) = spectrum_occupancy(&traces.raw) {
        let ghz = |band: [f64; 2]| band.map(|f| f * 1e-9);
        let occupied = spectrum.occupied_share_of(band_hz);
        findings.push(band(occupied, ghz(band_hz), ghz(spectrum.band_hz)));
        findings.push(band_used(ghz(band_hz), ghz(spectrum.band_hz)));
    }
    findings
}

/// What the deviation of an offset that was searched or recorded makes of places, at the median speed of
/// the traces.
fn offset_sigma(prepared: &Prepared, track: &Track) -> Option<Finding> {
    let judged_at = |speed_m_s| match (&track.search, &track.recorded_clock) {
        (Some(search), _) => Some(clock_offset_sigma(search.estimate.sigma_s, speed_m_s)),
        (None, Some(clock)) => Some(recorded_clock_sigma(clock.sigma_s, speed_m_s)),
        (None, None) => None,
    };
    let positions = prepared.aligned.position_m.get(track.range.clone())?;
    let times = prepared.aligned.time_s.get(track.range.clone())?;
    let pairs = positions.windows(2).zip(times.windows(2));
    let speed = pairs.filter(|(_, t)| t[1] > t[0]).map(|(p, t)| {
        let square: f64 = (0..3).map(|i| (p[1][i] - p[0][i]).powi(2)).sum();
        square.sqrt() / (t[1] - t[0])
    });
    judged_at(median(speed)?)
}

/// Whether an echo of the log clearly follows the height of the flight.
fn follows_height(track: &Track) -> bool {
    let height = track.likelihood.as_ref().and_then(|l| l.height.as_ref());
    height.is_some_and(|cue| cue.evidence >= LEAST_EVIDENCE)
}

/// Whether the height of the surface echo by itself speaks against the offset in force, and the
/// positions' heights are good enough to be believed.
fn height_speaks(prepared: &Prepared, track: &Track) -> bool {
    let Some(cue) = track.likelihood.as_ref().and_then(|l| l.height.as_ref()) else {
        return false;
    };
    let sigma_z_m = height_sigma_m(prepared, track);
    let below = cue.curve.best().1 - cue.curve.at(track.time_offset_s);
    cue.evidence >= LEAST_EVIDENCE
        && below >= LEAST_EVIDENCE
        && sigma_z_m.is_none_or(|sigma_m| sigma_m <= BELIEVED_SIGMA_M)
}

/// Median deviation of the positions' heights (m), where they state any.
fn height_sigma_m(prepared: &Prepared, track: &Track) -> Option<f64> {
    let sigma_m = prepared.aligned.sigma_m.get(track.range.clone())?;
    median(sigma_m.iter().map(|s| s[2]))
}

/// The offset in force beside the likelihood of all offsets.
fn clock_seen(track: &Track) -> Option<ClockSeen> {
    let likelihood = track.likelihood.as_ref()?;
    let best = likelihood.candidates.first()?;
    let total = &likelihood.total;
    Some(ClockSeen {
        offset_s: track.time_offset_s,
        best_s: best.offset_s,
        sigma_s: best.sigma_s,
        below_best: total.at(best.offset_s) - total.at(track.time_offset_s),
    })
}

/// The fast time of range zero by the echo that follows the height, where one clearly does.
fn delay_seen(prepared: &Prepared, track: &Track, shift_s: f64) -> Option<Finding> {
    let cue = track.likelihood.as_ref()?.height.as_ref()?;
    (cue.evidence >= LEAST_EVIDENCE).then(|| {
        let height_s =
            2.0 * height_sigma_m(prepared, track).unwrap_or(0.0) / prepared.scene.light_speed_m_s;
        let sigma_ns = 1e9 * cue.delay_sigma_s.hypot(height_s);
        zero_timing(-1e9 * shift_s, 1e9 * cue.delay_s, sigma_ns)
    })
}

/// The direct coupling, where the window begins before it and it stands out and still.
fn coupling_seen(raw: &Radargram) -> Option<CouplingSeen> {
    let seen = quality::coupling(raw)?;
    let is_coupling = seen.contrast_db >= COUPLING_CONTRAST_DB
        && seen.spread_s <= COUPLING_SPREAD_S
        && seen.fast_time_s.abs() <= COUPLING_REACH_S
        && raw.fast_time_start_s < seen.fast_time_s - 1e-9;
    is_coupling.then_some(CouplingSeen {
        delay_ns: 1e9 * seen.fast_time_s,
        spread_ns: 1e9 * seen.spread_s,
    })
}

/// The surface echo of the zero-timed traces, where one follows the height.
fn surface_seen(prepared: &Prepared, track: &Track) -> Option<SurfaceSeen> {
    let traces = track.cleaned.as_ref()?;
    let aligned = &prepared.aligned;
    let height_m = aligned.height_m.get(track.range.clone())?;
    let mut options = SurfaceOptions::default().with_approximate_delay_s(0.0);
    options.search_s = SEARCH_S;
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
    let sigma_z_m = height_sigma_m(prepared, track);
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
