//! Identification of the surface among the echoes that follow the height.

use super::curve::LikelihoodCurve;
use super::height_cue::{Grid, HeightCue};

/// Share of what the best echo explains below which another echo is excluded: the picks of all echoes are of the same
/// traces, and the surface is seen in most.
pub(super) const RIVAL: f64 = 0.5;
/// Distance below which an echo that moves with a stronger echo counts as a side lobe of the latter, s: five
/// lobes of 0.6 ns for a band of 1.7 GHz.
const LOBES_S: f64 = 3e-9;
/// Largest difference of the offsets of echoes that move together, s.
const SAME_OFFSET_S: f64 = 0.1;

/// The echoes that may be the surface: those that explain at least [`RIVAL`] of what the best one explains, with an
/// evidence in proportion to it.
pub(super) fn surfaces(cues: Vec<HeightCue>) -> Vec<HeightCue> {
    let best = cues
        .iter()
        .max_by(|a, b| a.explained.total_cmp(&b.explained));
    let Some((explained, evidence)) = best.map(|cue| (cue.explained, cue.evidence)) else {
        return cues;
    };
    let share = |cue: &HeightCue| cue.explained / explained.max(f64::MIN_POSITIVE);
    let rivals = cues.iter().filter(|cue| share(cue) >= RIVAL);
    let weighed = |cue: &HeightCue| HeightCue {
        evidence: share(cue) * evidence,
        ..cue.clone()
    };
    rivals.map(weighed).collect()
}

/// Log-likelihood of every offset where any one of the echoes may be the surface, or none: the mean of their
/// likelihoods over that of an echo that ignores the height, and 1.
pub(super) fn any_of(cues: &[HeightCue], grid: Grid) -> LikelihoodCurve {
    let share = (cues.len().max(1) as f64).ln();
    let excess: Vec<f64> = cues
        .iter()
        .map(|cue| cue.evidence - cue.curve.best().1 - share)
        .collect();
    let log_likelihood = (0..grid.count)
        .map(|k| {
            let each = || {
                let terms = cues.iter().zip(&excess);
                terms.map(|(cue, excess)| cue.curve.log_likelihood[k] + excess)
            };
            let top = each().fold(0.0, f64::max);
            top + ((-top).exp() + each().map(|x| (x - top).exp()).sum::<f64>()).ln()
        })
        .collect();
    LikelihoodCurve {
        start_s: grid.start_s,
        step_s: grid.step_s,
        log_likelihood,
    }
}

/// The surface's echo at an offset: the echo that fits best by all cues together, or a stronger echo within
/// [`LOBES_S`], since side lobes follow the height as well as their main lobe.
pub(super) fn surface_at(cues: &[HeightCue], offset_s: f64) -> Option<HeightCue> {
    let worth = |cue: &HeightCue| cue.evidence - cue.curve.best().1 + cue.curve.at(offset_s);
    let speaking = || cues.iter().filter(|cue| worth(cue) > 0.0);
    let best = speaking().max_by(|a, b| worth(a).total_cmp(&worth(b)))?;
    let moves_along = |cue: &&HeightCue| {
        (cue.delay_s - best.delay_s).abs() < LOBES_S
            && (cue.offset_s - best.offset_s).abs() <= SAME_OFFSET_S
    };
    speaking()
        .filter(moves_along)
        .max_by(|a, b| a.envelope.total_cmp(&b.envelope))
        .cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An echo that follows the height at offset 0: delay (ns), evidence, envelope.
    fn cue(delay_ns: f64, evidence: f64, envelope: f64) -> HeightCue {
        let log_likelihood = (-50..=50).map(|k| -0.1 * f64::from(k * k)).collect();
        HeightCue {
            curve: LikelihoodCurve {
                start_s: -0.5,
                step_s: 0.01,
                log_likelihood,
            },
            offset_s: 0.0,
            delay_s: 1e-9 * delay_ns,
            delay_sigma_s: 1e-11,
            residual_s: 5e-11,
            stray_share: 0.1,
            picks: 400,
            correlation_length: 10.0,
            stated_sigma_s: 0.0,
            evidence,
            preference: evidence,
            explained: 10.0 * evidence,
            envelope,
        }
    }

    #[test]
    fn the_main_lobe_is_the_surface_where_a_side_lobe_is_followed_longer() {
        let lobes = vec![cue(5.3, 129.0, 188.0), cue(6.8, 54.0, 1390.0)];
        let surface = surface_at(&lobes, 0.0).unwrap();
        assert!((surface.delay_s - 6.8e-9).abs() < 1e-15);
    }

    #[test]
    fn a_stronger_echo_elsewhere_does_not_replace_the_surface() {
        let far = vec![cue(5.3, 129.0, 188.0), cue(12.0, 54.0, 1390.0)];
        assert!((surface_at(&far, 0.0).unwrap().delay_s - 5.3e-9).abs() < 1e-15);
        // It follows the height at another time.
        let mut other = cue(6.8, 54.0, 1390.0);
        other.offset_s = 3.0;
        let surface = surface_at(&[cue(5.3, 129.0, 188.0), other], 0.0).unwrap();
        assert!((surface.delay_s - 5.3e-9).abs() < 1e-15);
        // It does not follow the height at all.
        let silent = vec![cue(5.3, 129.0, 188.0), cue(6.8, -1.0, 1390.0)];
        assert!((surface_at(&silent, 0.0).unwrap().delay_s - 5.3e-9).abs() < 1e-15);
        assert!(surface_at(&[cue(6.8, -1.0, 1390.0)], 0.0).is_none());
    }

    #[test]
    fn an_echo_that_explains_few_traces_is_no_rival_of_one_that_explains_most() {
        let kept = |each: &[f64]| {
            let explains = |explained: &f64| HeightCue {
                explained: *explained,
                ..cue(10.0, 20.0, 100.0)
            };
            let of = surfaces(each.iter().map(explains).collect());
            let pairs = of.iter().map(|cue| (cue.explained, cue.evidence));
            pairs.collect::<Vec<_>>()
        };
        assert_eq!(kept(&[140.0, 950.0, 75.0]), [(950.0, 20.0)]);
        // Two echoes that explain about as many traces both remain.
        assert_eq!(kept(&[375.0, 500.0]), [(375.0, 15.0), (500.0, 20.0)]);
        assert!(kept(&[]).is_empty());
    }
}
