//! Echoes read from coherent sums of several traces, where single traces do not show them: clutter and
//! coupling at the same range are as strong, but do not add up along the reflector's curve.

use num_complex::Complex32;

use super::echo::median;
use super::focus::{Placed, curve_s};
use super::parameter::Values;
use super::search::Start;
use super::track::{Echo, Setting, TrackEchoes};

/// Share of the power along a reflector's curve that adds up coherently from which single traces show it.
const CLEAR: f64 = 0.5;
/// Mean power of the echo of a coherent sum over the incoherent power.
const WANTED_RATIO: f64 = 10.0;
/// Sums of each reflector at least, where the traces allow it.
const FEWEST_SUMS: usize = 10;
/// Half of the fast time in which the crest of a sum is looked for, and the stretch from which its floor is
/// taken (s).
const CREST_S: f64 = 0.8e-9;
const FLOOR_S: f64 = 4e-9;
/// Least level of a crest over the floor.
const LEAST_CONTRAST: f64 = 2.5;
/// Relative deviation that no crest falls below.
const LEAST_RELATIVE_SIGMA: f64 = 0.02;

/// Trace, weight and fast time (s) of a reflector's echo, trace by trace.
type Curve = Vec<(usize, f64, f64)>;

/// The echoes of a track by coherent sums; none where the track's single traces show the echoes.
pub(super) fn stretch_echoes(
    setting: &Setting<'_>,
    track: &TrackEchoes,
    number: usize,
    campaign: &Values,
    start: &Start,
) -> Option<Vec<Echo>> {
    if track.at_rest {
        return None;
    }
    let curves: Vec<(usize, Curve)> = start
        .stretches
        .iter()
        .map(|(stretch, focus)| {
            let placed = Placed::at(stretch, setting, track, campaign, start.offset_s, true);
            let curve = curve_s(&placed, setting, *focus, start.delay_s);
            (stretch.reflector, curve)
        })
        .collect();
    let share = coherent_share(track, &curves);
    if share > CLEAR {
        return None;
    }
    let traces: usize = curves.iter().map(|(_, curve)| curve.len()).sum();
    let most = traces / setting.reflector_m.len().max(1) / FEWEST_SUMS;
    let needed = WANTED_RATIO * (1.0 - share) / share.max(1e-3);
    let each = (needed.ceil() as usize).clamp(3, most.max(3));
    let half_c = 0.5 * setting.light_speed_m_s;
    let mut echoes = Vec::new();
    for (reflector, curve) in &curves {
        for part in curve.chunks(each).filter(|part| 2 * part.len() > each) {
            let middle = part[part.len() / 2];
            if let Some((later_s, contrast)) = crest(track, part) {
                echoes.push(Echo {
                    track: number,
                    reflector: *reflector,
                    time_s: track.profiles.time_s[middle.0],
                    range_m: half_c * (middle.2 + later_s - track.known_delay_s),
                    relative_sigma: contrast.recip().hypot(LEAST_RELATIVE_SIGMA),
                });
            }
        }
    }
    echoes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    Some(echoes)
}

/// The coherent share of the power along the curves: 1 where only the echo is present.
fn coherent_share(track: &TrackEchoes, curves: &[(usize, Curve)]) -> f64 {
    let (mut coherent, mut all) = (0.0, 0.0);
    for (_, curve) in curves {
        let weight: f64 = curve.iter().map(|(_, weight, _)| weight).sum();
        let power: f64 = curve
            .iter()
            .map(|(k, w, t)| w * f64::from(track.profiles.mixed_at(*k, *t).norm_sqr()))
            .sum();
        coherent += f64::from(sum_at(track, curve, 0.0).norm_sqr());
        all += weight * power;
    }
    coherent / f64::max(all, f64::MIN_POSITIVE)
}

/// The coherent sum of traces at delays after their curve.
fn sum_at(track: &TrackEchoes, curve: &[(usize, f64, f64)], later_s: f64) -> Complex32 {
    let turn = std::f64::consts::TAU * track.profiles.middle_hz();
    curve
        .iter()
        .map(|(trace, weight, time_s)| {
            let (sin, cos) = (turn * time_s).sin_cos();
            let turned = Complex32::new(cos as f32, sin as f32) * (*weight as f32);
            turned * track.profiles.mixed_at(*trace, time_s + later_s)
        })
        .sum()
}

/// Delay of the crest of a sum after its curve (s), and its level over the floor; none without a crest, or
/// where no crest is clear.
fn crest(track: &TrackEchoes, curve: &[(usize, f64, f64)]) -> Option<(f64, f64)> {
    let step_s = track.profiles.step_s();
    let reach = (FLOOR_S / step_s).ceil() as i32;
    let level = |k: i32| f64::from(sum_at(track, curve, f64::from(k) * step_s).norm());
    let levels: Vec<f64> = (-reach..=reach).map(level).collect();
    let near = (CREST_S / step_s).floor() as i32;
    let at = |k: i32| levels[(k + reach) as usize];
    let top = (-near..=near).max_by(|a, b| at(*a).total_cmp(&at(*b)))?;
    if top.abs() == near {
        return None;
    }
    let floor = median(levels.iter().copied()).max(f64::MIN_POSITIVE);
    let [before, here, after] = [at(top - 1), at(top), at(top + 1)];
    let bend = before - 2.0 * here + after;
    let part = if bend < 0.0 {
        0.5 * (before - after) / bend
    } else {
        0.0
    };
    let contrast = here / floor;
    (contrast >= LEAST_CONTRAST).then_some(((f64::from(top) + part) * step_s, contrast))
}
