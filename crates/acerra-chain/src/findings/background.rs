//! Findings on the background: the loss of targets by its removal, the rest of constant echoes, and the
//! length of its window.

use std::f64::consts::TAU;
use std::ops::Range;

use acerra_imaging::{Complex32, PlaneGrid};
use acerra_radar::Spectrum;
use acerra_radar::clean::{BackgroundGain, spectrum_at};
use num_complex::Complex64;

use super::median::median;
use super::paths::Paths;
use super::strongest::strongest;
use crate::align::geometry::ImageGeometry;
use crate::choices::Background;
use crate::clean::{CleanedTraces, cleaned_with, removal};
use crate::control::{Cancelled, Control};
use crate::echoes::quick_look;
use crate::echoes::sharpen::{coarse, patches};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::{Prepared, Track};

/// Targets further than this below the strongest are not judged (dB).
const FLOOR_DB: f64 = -6.0;

/// Frequencies, evenly over the band, at which echoes are compared.
const FREQUENCIES: usize = 16;

/// Pixels of an image in which echoes are looked for.
const PIXELS: f64 = 60_000.0;

/// Judges the background of a track's radargram; nothing where its log holds spectra.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    control: &Control<'_>,
) -> Result<Vec<Finding>, Cancelled> {
    let Some(traces) = &track.cleaned else {
        return Ok(Vec::new());
    };
    control.check()?;
    let gain = removal(track.background).and_then(BackgroundGain::of);
    let kept = match (gain, &traces.removal) {
        (Some(gain), _) => kept_of_a_point(prepared, focused, track, |_, echo| {
            gain.kept(echo, &traces.lines)
        }),
        (None, Some(surface)) => {
            kept_of_a_point(prepared, focused, track, |f, echo| surface.kept(f, echo))
        }
        (None, None) => kept_of_the_mean(prepared, focused, track, traces),
    };
    let mut findings = Vec::new();
    findings.extend(kept.map(background_loss));
    findings.extend(still_share(prepared, track).map(still_echoes));
    Ok(findings)
}

/// Share of its amplitude that the echo of a point at the strongest target's place keeps, on average over the
/// band.
fn kept_of_a_point(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    kept: impl Fn(f64, &[Complex64]) -> Option<f64>,
) -> Option<f64> {
    let point_m = *strongest(focused, FLOOR_DB).first()?;
    let path_m = Paths::of(prepared, focused).to_m(point_m, track.range.clone());
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let stride = frequency_hz.len().div_ceil(FREQUENCIES).max(1);
    let shares = frequency_hz.iter().step_by(stride).map(|f| {
        let turns = -TAU * f / prepared.scene.light_speed_m_s;
        let echo: Vec<Complex64> = path_m
            .iter()
            .map(|path| Complex64::from_polar(1.0, turns * path))
            .collect();
        kept(*f, &echo)
    });
    let shares: Vec<f64> = shares.collect::<Option<_>>()?;
    (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
}

/// Share of their amplitudes that the strongest echoes of a track's image without the mean alone keep under the
/// background in force: the median over them. Uneven ground counts as the plane in the middle of its heights.
fn kept_of_the_mean(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    traces: &CleanedTraces,
) -> Option<f64> {
    let height_m = prepared.aligned.height_m.get(track.range.clone())?;
    let position_m = prepared.aligned.position_m.get(track.range.clone())?;
    let light_m_s = prepared.scene.light_speed_m_s;
    let mean = cleaned_with(Background::Mean, traces, height_m).ok()?;
    let spectrum = |clean| spectrum_at(clean, &prepared.spectrum.frequency_hz).ok();
    let (mean, in_force) = (spectrum(&mean)?, spectrum(&traces.clean)?);
    let mut grid = focused.pixels.grid;
    grid.z_m = focused.pixels.middle_m();
    let grid = coarse(grid, PIXELS).ok()?;
    let image = |spectrum: &Spectrum, patch: &PlaneGrid| -> Option<Vec<Complex32>> {
        quick_look(position_m, spectrum, *patch, light_m_s).ok()
    };
    let kept = patches(position_m, &mean, grid, light_m_s).ok()?;
    let kept = kept.iter().filter_map(|patch| {
        let before = image(&mean, patch)?;
        let after = image(&in_force, patch)?;
        let level = |k: &usize| before[*k].norm();
        let top = (0..before.len()).max_by(|a, b| level(a).total_cmp(&level(b)))?;
        (level(&top) > 0.0).then(|| f64::from(after[top].norm() / before[top].norm()))
    });
    median(kept.collect::<Vec<_>>())
}

/// Share of the power of a track's spectra that their mean over the traces holds.
fn still_share(prepared: &Prepared, track: &Track) -> Option<f64> {
    let width = prepared.spectrum.frequency_hz.len();
    let part = track.range.start * width..track.range.end * width;
    let values = prepared.spectrum.values.get(part)?;
    let mut sum = vec![Complex64::default(); width];
    for trace in values.chunks_exact(width.max(1)) {
        sum.iter_mut().zip(trace).for_each(|(s, v)| *s += v);
    }
    let power: f64 = values.iter().map(Complex64::norm_sqr).sum();
    let still: f64 = sum.iter().map(Complex64::norm_sqr).sum();
    let traces = track.range.len();
    (power > 0.0 && traces > 1).then(|| still / (traces as f64 * power))
}

/// The length of the background's window, where it has one, and the Fresnel zone below the flight.
pub(super) fn window_of_background(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<Finding> {
    let Background::Window { window } = track.background else {
        return None;
    };
    let path_m: f64 = prepared
        .aligned
        .path_m
        .get(track.range.clone())?
        .iter()
        .sum();
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    let lines = prepared.aligned.lines(track.range.clone());
    let longest = lines.iter().map(Range::len).max()?;
    Some(background_window(&BackgroundWindow {
        path_m: path_m * window.min(longest) as f64 / track.range.len().max(1) as f64,
        wavelength_m: geometry.light_speed_m_s / middle_hz,
        range_m: median(
            prepared.aligned.height_m[track.range.clone()]
                .iter()
                .copied(),
        )?
        .abs(),
    }))
}

/// A background that is the mean of a window of traces about each trace.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BackgroundWindow {
    /// Path flown over the window (m).
    pub path_m: f64,
    /// Wavelength (m).
    pub wavelength_m: f64,
    /// Range of the scene (m).
    pub range_m: f64,
}

/// Judges the length of a background window by the first Fresnel zone, √(λR/2).
///
/// Within the zone the echo of a target at closest approach keeps its phase, so that the mean over
/// the window is the echo itself and takes it away.
fn background_window(window: &BackgroundWindow) -> Finding {
    let zone_m = (0.5 * window.wavelength_m * window.range_m).sqrt();
    let verdict = if window.path_m >= 2.0 * zone_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("background_window", window.path_m, "m", verdict)
        .expecting(2.0 * zone_m)
        .because(format!(
            "the background's window covers {:.2} m of path, the first Fresnel zone is {zone_m:.2} \
             m: targets are taken for background ([preprocess] background)",
            window.path_m
        ))
}

/// Amplitude that a background may take from a target (dB).
const MOST_TAKEN_DB: f64 = 3.0;

/// Below this the echo is gone, whatever is left (dB).
const GONE_DB: f64 = 60.0;

/// Judges a background by the share of its amplitude that it leaves a point target.
fn background_loss(kept: f64) -> Finding {
    let loss_db = (-20.0 * kept.max(0.0).log10()).clamp(0.0, GONE_DB);
    let verdict = if loss_db <= MOST_TAKEN_DB {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("background_loss", loss_db, "dB", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => format!(
                "removing the background takes {loss_db:.1} dB from the strongest echoes: targets are kept"
            ),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "removing the background takes {loss_db:.1} dB from the strongest echoes: targets are taken for \
                 background, weakened and split ([preprocess] background)"
            ),
        })
}

/// Judges the power that does not change from trace to trace in the spectra that are imaged, as a share of
/// their power: above one half, the background has not been removed.
fn still_echoes(share: f64) -> Finding {
    let verdict = if share <= 0.5 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("still_echoes", share, "share of the power", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => format!(
                "{:.0} % of the power imaged does not change from trace to trace: the background is removed",
                100.0 * share
            ),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "{:.0} % of the power imaged does not change from trace to trace: coupling or an even surface, \
                 which no background removal has taken, lies over the targets ([preprocess] background, \
                 gate_ns)",
                100.0 * share
            ),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_background_that_takes_half_of_an_echo_is_doubtful() {
        assert_eq!(background_loss(0.9).verdict, Verdict::Agrees);
        let half = background_loss(0.5);
        assert_eq!(half.verdict, Verdict::Doubtful);
        assert!((half.value.unwrap() - 6.02).abs() < 0.01);
        // A window may turn an echo's sign.
        assert_eq!(background_loss(-0.1).value, Some(GONE_DB));
    }

    #[test]
    fn echoes_that_mostly_stand_still_are_doubtful() {
        assert_eq!(still_echoes(0.3).verdict, Verdict::Agrees);
        assert_eq!(still_echoes(0.7).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_window_within_the_fresnel_zone_is_doubtful() {
        // √(0.076 m · 10 m / 2) = 0.62 m.
        let judge = |path_m| {
            let seen = BackgroundWindow {
                path_m,
                wavelength_m: 0.076,
                range_m: 10.0,
            };
            background_window(&seen).verdict
        };
        assert_eq!(judge(0.3), Verdict::Doubtful);
        assert_eq!(judge(5.0), Verdict::Agrees);
    }
}
