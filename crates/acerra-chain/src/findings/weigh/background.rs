//! Findings on the background: what its removal takes from targets, and what it leaves of still echoes.

use std::f64::consts::TAU;

use acerra_imaging::{Complex32, PlaneGrid};
use acerra_radar::Spectrum;
use acerra_radar::clean::{BackgroundGain, spectrum_at};
use num_complex::Complex64;

use super::median::median;
use super::strongest::strongest;
use crate::choices::Background;
use crate::clean::{CleanedTraces, cleaned_with, removal};
use crate::control::{Cancelled, Control};
use crate::echoes::history::distance_m;
use crate::echoes::quick_look;
use crate::echoes::sharpen::{coarse, patches};
use crate::findings::evidence::{Finding, background_loss, still_echoes};
use crate::focus::Focused;
use crate::prepare::{Prepared, Track};

/// Targets further than this below the strongest say little (dB).
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
    let kept = match BackgroundGain::of(removal(track.background)) {
        Some(gain) => kept_of_a_point(prepared, focused, track, gain),
        None => kept_of_the_mean(prepared, focused, track, traces),
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
    gain: BackgroundGain,
) -> Option<f64> {
    let point_m = *strongest(prepared, focused, FLOOR_DB).first()?;
    let position_m = prepared.aligned.position_m.get(track.range.clone())?;
    let range_m: Vec<f64> = position_m.iter().map(|p| distance_m(*p, point_m)).collect();
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let stride = frequency_hz.len().div_ceil(FREQUENCIES).max(1);
    let shares = frequency_hz.iter().step_by(stride).map(|f| {
        let turns = -2.0 * TAU * f / prepared.scene.light_speed_m_s;
        let echo: Vec<Complex64> = range_m
            .iter()
            .map(|r| Complex64::from_polar(1.0, turns * r))
            .collect();
        gain.kept(&echo)
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
