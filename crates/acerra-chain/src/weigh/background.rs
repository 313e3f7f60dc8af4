//! Findings on the background: what its removal takes from targets, and what it leaves of still echoes.

use std::f64::consts::TAU;

use acerra_radar::Control as RadarControl;
use acerra_radar::clean::{BackgroundGain, CleanError};
use num_complex::Complex64;

use super::history::distance_m;
use super::strongest::strongest;
use crate::clean::removal;
use crate::control::{Cancelled, Control};
use crate::evidence::{Finding, background_loss, still_echoes};
use crate::focus::Focused;
use crate::prepare::{Prepared, Track};

/// Targets further than this below the strongest say little (dB).
const FLOOR_DB: f64 = -6.0;
/// Frequencies, evenly over the band, at which echoes are compared.
const FREQUENCIES: usize = 16;

/// Judges the background of a track's radargram by the places of the strongest targets; nothing where its log
/// holds spectra.
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
    let mut findings = Vec::new();
    let stop = control.cancel_flag().map_or(RadarControl::new(), |flag| {
        RadarControl::new().cancelled_by(flag)
    });
    let gain = match BackgroundGain::of(&traces.raw, removal(track.background), stop) {
        Ok(gain) => gain,
        Err(CleanError::Cancelled(_)) => return Err(Cancelled),
        // What cannot be removed was refused before.
        Err(_) => None,
    };
    if let Some(gain) = gain
        && let Some(point_m) = strongest(prepared, focused, FLOOR_DB).first()
        && let Some(kept) = kept(prepared, track, &gain, *point_m)
    {
        findings.push(background_loss(kept));
    }
    findings.extend(still_share(prepared, track).map(still_echoes));
    Ok(findings)
}

/// Share of its amplitude that the echo of a point keeps, on average over the band.
fn kept(
    prepared: &Prepared,
    track: &Track,
    gain: &BackgroundGain,
    point_m: [f64; 3],
) -> Option<f64> {
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
