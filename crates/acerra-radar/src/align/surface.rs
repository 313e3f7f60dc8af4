//! Identification of the surface among the echoes that follow the height.

use super::curve::LikelihoodCurve;
use super::height_cue::{Grid, HeightCue};

/// Largest share of strays among the picks of an echo that is seen throughout the flight. For an echo seen in
/// a part of the flight, the largest share among the picks within a second of picks that fit the height
/// (picks that fit by chance are isolated).
const MOST_STRAYS: f64 = 0.5;
/// Largest share of strays within a second of the picks that fit the height, for an echo that follows the
/// height trace after trace; chosen on the random flights 1 to 120 of the validation book.
const FOLLOWED_STRAYS: f64 = 0.08;
/// Largest error of the picks of such an echo, s; chosen on the same flights.
const FOLLOWED_S: f64 = 0.5e-9;
/// Evidence from which an echo is beyond doubt: odds of 400 to 1.
const BEYOND_DOUBT: f64 = 6.0;
/// Evidence beyond doubt for an echo that follows the height only in a part of the flight, which may be a
/// chance choice of the part.
const OF_A_PART: f64 = 2.0 * BEYOND_DOUBT;
/// Distance below which offsets count as one, s.
const ONE_OFFSET_S: f64 = 0.1;
/// Distance below which an echo that moves with a stronger echo counts as a side lobe of the latter, s: five
/// lobes of 0.6 ns for a band of 1.7 GHz.
const LOBES_S: f64 = 3e-9;
/// Largest difference of the offsets of echoes that move together, s.
const SAME_OFFSET_S: f64 = 0.1;

impl HeightCue {
    /// Whether the echo follows the height trace after trace: few strays are among its picks, and the error of its picks
    /// is that of a surface. An echo that only crosses the height has strays before and after each crossing.
    fn is_followed(&self) -> bool {
        self.strays_about <= FOLLOWED_STRAYS && self.residual_s <= FOLLOWED_S
    }

    fn is_beyond_doubt(&self) -> bool {
        self.evidence >= BEYOND_DOUBT
    }
}

/// The echoes that may be the surface. Where an echo beyond doubt is [followed](HeightCue::is_followed) trace after trace,
/// echoes that are not followed do not count.
pub(super) fn surfaces(cues: Vec<HeightCue>) -> Vec<HeightCue> {
    let mut cues = seen(cues);
    if (cues.iter()).any(|cue| cue.is_followed() && cue.is_beyond_doubt()) {
        cues.retain(HeightCue::is_followed);
    }
    cues
}

/// The echoes seen throughout the flight, with few strays among their picks. Where none of these echoes is
/// beyond doubt and all echoes beyond doubt give one offset, echoes seen for a part of the flight with the
/// evidence [`OF_A_PART`] are included.
fn seen(mut cues: Vec<HeightCue>) -> Vec<HeightCue> {
    let is_seen = |cue: &HeightCue| cue.stray_share <= MOST_STRAYS;
    let admits_parts = !cues.iter().any(|cue| is_seen(cue) && cue.is_beyond_doubt())
        && are_near(cues.iter().filter(|cue| cue.is_beyond_doubt()));
    cues.retain(|cue| {
        let is_seen_in_part = cue.evidence >= OF_A_PART && cue.strays_about <= MOST_STRAYS;
        is_seen(cue) || (admits_parts && is_seen_in_part)
    });
    cues
}

/// Whether cues give [one](ONE_OFFSET_S) offset.
fn are_near<'a>(cues: impl Iterator<Item = &'a HeightCue>) -> bool {
    let (low_s, high_s) = cues.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), cue| {
        (low.min(cue.offset_s), high.max(cue.offset_s))
    });
    high_s - low_s <= ONE_OFFSET_S
}

/// Log-likelihood of every offset where any one of the echoes may be the surface, or none: the mean of their
/// likelihoods over that of an echo that ignores the height, and 1. Echoes [beyond doubt](BEYOND_DOUBT) have
/// equal weight, since their evidence over an echo that ignores the height does not compare them with each
/// other.
pub(super) fn any_of(cues: &[HeightCue], grid: Grid) -> LikelihoodCurve {
    let share = (cues.len().max(1) as f64).ln();
    let strongest = cues.iter().map(|cue| cue.evidence).fold(0.0, f64::max);
    let weight = |cue: &HeightCue| {
        if cue.is_beyond_doubt() {
            strongest
        } else {
            cue.evidence
        }
    };
    let excess: Vec<f64> = cues
        .iter()
        .map(|cue| weight(cue) - cue.curve.best().1 - share)
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
pub(super) fn surface_at(cues: Vec<HeightCue>, offset_s: f64) -> Option<HeightCue> {
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
            strays_about: 0.1,
            picks: 400,
            correlation_length: 10.0,
            stated_sigma_s: 0.0,
            evidence,
            preference: evidence,
            envelope,
        }
    }

    #[test]
    fn the_main_lobe_is_the_surface_where_a_side_lobe_is_followed_longer() {
        let lobes = vec![cue(5.3, 129.0, 188.0), cue(6.8, 54.0, 1390.0)];
        let surface = surface_at(lobes, 0.0).unwrap();
        assert!((surface.delay_s - 6.8e-9).abs() < 1e-15);
    }

    #[test]
    fn a_stronger_echo_elsewhere_does_not_replace_the_surface() {
        let far = vec![cue(5.3, 129.0, 188.0), cue(12.0, 54.0, 1390.0)];
        assert!((surface_at(far, 0.0).unwrap().delay_s - 5.3e-9).abs() < 1e-15);
        // It follows the height at another time.
        let mut other = cue(6.8, 54.0, 1390.0);
        other.offset_s = 3.0;
        let surface = surface_at(vec![cue(5.3, 129.0, 188.0), other], 0.0).unwrap();
        assert!((surface.delay_s - 5.3e-9).abs() < 1e-15);
        // It does not follow the height at all.
        let silent = vec![cue(5.3, 129.0, 188.0), cue(6.8, -1.0, 1390.0)];
        assert!((surface_at(silent, 0.0).unwrap().delay_s - 5.3e-9).abs() < 1e-15);
        assert!(surface_at(vec![cue(6.8, -1.0, 1390.0)], 0.0).is_none());
    }

    /// An echo at an offset (s): share of strays, share of strays about its picks, error (ns), evidence.
    fn cue_at(
        offset_s: f64,
        [stray_share, strays_about, residual_ns, evidence]: [f64; 4],
    ) -> HeightCue {
        let curve = LikelihoodCurve {
            start_s: offset_s,
            step_s: 0.01,
            log_likelihood: vec![0.0],
        };
        HeightCue {
            curve,
            offset_s,
            delay_s: 10e-9,
            delay_sigma_s: 1e-11,
            residual_s: 1e-9 * residual_ns,
            stray_share,
            strays_about,
            picks: 400,
            correlation_length: 10.0,
            stated_sigma_s: 0.0,
            evidence,
            preference: evidence,
            envelope: 100.0,
        }
    }

    #[test]
    fn an_echo_that_follows_the_height_outweighs_those_that_cross_it() {
        let offsets = |cues: &[HeightCue]| {
            let of = surfaces(cues.to_vec());
            of.iter().map(|cue| cue.offset_s).collect::<Vec<_>>()
        };
        let followed = cue_at(0.0, [0.45, 0.05, 0.05, 14.0]);
        let crossing = cue_at(-0.14, [0.81, 0.18, 0.05, 21.7]);
        let loose = cue_at(-0.17, [0.38, 0.12, 0.7, 22.5]);
        assert_eq!(offsets(&[crossing.clone(), followed.clone()]), [0.0]);
        assert_eq!(offsets(&[loose.clone(), followed]), [0.0]);
        // None is followed.
        assert_eq!(offsets(&[crossing, loose.clone()]), [-0.17]);
        // An echo that is followed in a part of the flight does not count where another is seen throughout it.
        let in_part = cue_at(0.0, [0.55, 0.05, 0.05, 14.0]);
        assert_eq!(offsets(&[in_part, loose]), [-0.17]);
    }
}
