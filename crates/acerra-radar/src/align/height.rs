//! The height cue: the surface echo's fast time against 2h/c of the trajectory, over all echoes followed.

use rayon::prelude::*;

use super::echo::{Echoes, LEAST_PICKS};
use super::height_cue::{Grid, HeightCue};
use super::height_fit::Fit;
use super::mixture::Mixture;
use super::surface::surfaces;
use super::{AlignError, FlightProfile};
use acerra_control::Control;

/// Initial model of the residuals: an error of 3 cm, every fifth a stray.
const TYPICAL: Mixture = Mixture {
    sigma_s: 0.2e-9,
    stray_share: 0.2,
};
/// Logarithm of the prior odds against an echo being the surface.
const DOUBT: f64 = 4.0;
/// Largest spacing of the coarse grid of offsets, in steps of the fine one.
const COARSE: f64 = 4.0;
/// Number of echoes tried on the whole grid.
const KEPT: usize = 6;
/// Passes at most in which an echo is followed again at the offset of the last pass.
const PASSES: usize = 4;

/// The cues of the echoes that follow the height best, the best first.
///
/// All ridges are tried on a coarse grid of offsets. About the best few, the strongest echo of every trace near the
/// fast time that the height gives is followed: ridges may pass from one echo to another, and leave the surface in
/// fast climbs, which determine the offset best. `likely_s` is the width of the offsets that agree with the other
/// cues.
pub(super) fn height_cues(
    echoes: &Echoes,
    profile: &FlightProfile,
    grid: Grid,
    likely_s: f64,
    control: Control<'_>,
) -> Result<Vec<HeightCue>, AlignError> {
    // Between two offsets of the grid the residuals of a climb change by no more than their error.
    let change_s = profile.fast_echo_rate() * grid.step_s;
    let steps = (TYPICAL.sigma_s / change_s).floor().clamp(1.0, COARSE);
    let coarse = grid.every(steps as usize);
    let mut rough: Vec<HeightCue> = echoes
        .ridges(control)?
        .par_iter()
        .map(|ridge| Fit::new(ridge, profile, coarse).cue(TYPICAL, control))
        .collect::<Result<_, AlignError>>()?;
    rough.sort_by(|a, b| b.preference.total_cmp(&a.preference));
    let mut tried: Vec<HeightCue> = Vec::new();
    for cue in rough {
        if tried.len() < KEPT && !tried.iter().any(|other| other.is_same_echo(&cue)) {
            tried.push(cue);
        }
    }
    let found = followed(tried, echoes, profile, grid, control)?;
    // Offsets half a second apart count as independent trials, each of which may fit by chance.
    let trials = (likely_s / 0.5).max(1.0);
    let over_trials = |cue: HeightCue| HeightCue {
        evidence: cue.evidence - trials.ln() - DOUBT,
        ..cue
    };
    let mut cues = surfaces(found.into_iter().map(over_trials).collect());
    cues.retain(|cue| cue.evidence > 0.0);
    cues.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    Ok(cues)
}

/// The cues of the strongest echoes near the fast times that each cue gives, again until its offset stays; of cues
/// that lead to one echo, the first. A cue is dropped where few traces have an echo at its fast times.
fn followed(
    cues: Vec<HeightCue>,
    echoes: &Echoes,
    profile: &FlightProfile,
    grid: Grid,
    control: Control<'_>,
) -> Result<Vec<HeightCue>, AlignError> {
    let mut all: Vec<(HeightCue, bool)> = cues.into_iter().map(|cue| (cue, false)).collect();
    for _ in 0..PASSES {
        let again = |(cue, is_settled): (HeightCue, bool)| {
            if is_settled {
                return Ok(Some((cue, true)));
            }
            let next = followed_once(&cue, echoes, profile, grid, control)?;
            Ok(next.map(|next| {
                let moved_s = (next.offset_s - cue.offset_s).abs();
                let is_settled = next.is_same_echo(&cue) && moved_s <= grid.step_s;
                (next, is_settled)
            }))
        };
        let passed: Vec<Option<(HeightCue, bool)>> = all
            .into_par_iter()
            .map(again)
            .collect::<Result<_, AlignError>>()?;
        all = Vec::new();
        for (cue, is_settled) in passed.into_iter().flatten() {
            match all.iter_mut().find(|(other, _)| other.is_same_echo(&cue)) {
                Some((_, settled)) => *settled |= is_settled,
                None => all.push((cue, is_settled)),
            }
        }
        if all.iter().all(|(_, is_settled)| *is_settled) {
            break;
        }
    }
    Ok(all.into_iter().map(|(cue, _)| cue).collect())
}

/// The cue of the strongest echo of every trace near the fast time that a cue gives.
fn followed_once(
    cue: &HeightCue,
    echoes: &Echoes,
    profile: &FlightProfile,
    grid: Grid,
    control: Control<'_>,
) -> Result<Option<HeightCue>, AlignError> {
    let expected_s = |t: f64| profile.echo_delay_s(t + cue.offset_s) + cue.delay_s;
    let ridges = echoes.about(expected_s);
    let fits = ridges
        .iter()
        .filter(|ridge| ridge.time_s.len() >= LEAST_PICKS)
        .map(|ridge| Fit::about(ridge, profile, grid));
    let over_chance = |fit: &Fit<'_>| fit.over_chance_at(cue.offset_s, TYPICAL);
    fits.max_by(|a, b| over_chance(a).total_cmp(&over_chance(b)))
        .map(|fit| fit.cue(TYPICAL, control))
        .transpose()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::super::FlightState;
    use super::super::echo::Search;
    use super::super::profile::STEP_S;
    use super::*;
    use crate::constants::two_way_delay_s;
    use crate::radargram::{Radargram, Samples};

    const DELAY_S: f64 = 10e-9;
    const FAST_STEP_S: f64 = 61e-12;

    /// At rest, up to 6 m at 3 m/s, a hover that wanders, down again.
    fn height_m(t: f64) -> f64 {
        let climb_m = 3.0 * (t - 10.0).min(33.0 - t).clamp(0.0, 2.0);
        let hover = if (12.0..31.0).contains(&t) { 1.0 } else { 0.0 };
        0.3 + climb_m + 0.05 * hover * (1.3 * t).sin()
    }

    /// Traces with the ground's echo, and, in the hover, a three times stronger one 6 ns behind.
    fn radargram() -> Radargram {
        let time_s: Vec<f64> = (0..860).map(|k| 0.05 * f64::from(k)).collect();
        let pulse = |t_s: f64| {
            (-(t_s / 0.3e-9).powi(2)).exp() * (std::f64::consts::TAU * 3.95e9 * t_s).cos()
        };
        let mut state = 5_u64;
        let mut values = Vec::new();
        for t in &time_s {
            let ground_s = DELAY_S + two_way_delay_s(height_m(*t));
            let other = if (12.5..30.5).contains(t) { 3.0 } else { 0.0 };
            for k in 0..1100 {
                let fast_s = f64::from(k) * FAST_STEP_S;
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let noise = (state >> 40) as f64 / f64::from(1_u32 << 24) - 0.5;
                let echoes = pulse(fast_s - ground_s) + other * pulse(fast_s - ground_s - 6e-9);
                values.push((echoes + 0.1 * noise) as f32);
            }
        }
        Radargram::new(time_s, 0.0, FAST_STEP_S, Samples::Real(values)).unwrap()
    }

    #[test]
    fn an_echo_is_followed_from_an_offset_at_which_a_part_of_its_picks_fits() {
        const OFFSET_S: f64 = 100.0;
        let state = |t: f64| {
            Some(FlightState {
                height_m: height_m(t - OFFSET_S),
                speed_m_s: 1.0,
            })
        };
        let profile = FlightProfile::sample([OFFSET_S, OFFSET_S + 43.0], state).unwrap();
        let grid = Grid {
            start_s: OFFSET_S - 20.0,
            step_s: STEP_S,
            count: 2000,
            delay_s: [-1e-9, 20e-9],
        };
        let search = Search {
            window_s: [0.0, 67e-9],
            rate: profile.fast_echo_rate(),
            traces: 2000,
        };
        let control = Control::default();
        let echoes = Echoes::of(&radargram(), search, control).unwrap().unwrap();
        let cues = height_cues(&echoes, &profile, grid, 40.0, control).unwrap();
        let best = &cues[0];
        assert!((best.offset_s - OFFSET_S).abs() < 0.005, "{best:?}");
        assert!((best.delay_s - DELAY_S).abs() < 0.05e-9, "{best:?}");
        assert!(best.stray_share < 0.1 && best.evidence > 20.0, "{best:?}");
        // In the hover the echo fits at this offset too, in the climbs it does not.
        let off = HeightCue {
            offset_s: best.offset_s - 0.08,
            delay_s: best.delay_s + 0.3e-9,
            ..best.clone()
        };
        let found = followed(vec![off], &echoes, &profile, grid, control).unwrap();
        let found = &found[0];
        assert!((found.offset_s - OFFSET_S).abs() < 0.005, "{found:?}");
        assert!(found.explained > 0.9 * best.explained, "{found:?}");
    }
}
