//! Findings on the clock offset: by height and motion of the flight, and by its deviation.

use super::median::median;
use super::surface::height_speaks;
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::prepare::{Prepared, Track};

/// Judges the clock offset of a track by the likelihood of all offsets and by its deviation.
pub(super) fn weigh(prepared: &Prepared, track: &Track) -> Vec<Finding> {
    let likely = clock_seen(track).map(|seen| {
        // Motion that is not clear, or heights no better than the wander itself, may doubt an offset only.
        let is_gross = || moves_far(prepared, track, &seen);
        let most = if height_speaks(prepared, track) || is_clear_motion(track) && is_gross() {
            Verdict::Contradicts
        } else {
            Verdict::Doubtful
        };
        clock_offset(&seen).at_most(most)
    });
    likely
        .into_iter()
        .chain(offset_sigma(prepared, track))
        .collect()
}

/// Whether starts and halts, unmistakable in echoes and positions, narrowed the likelihood.
fn is_clear_motion(track: &Track) -> bool {
    track
        .likelihood
        .as_ref()
        .is_some_and(|l| l.prior().is_some())
}

/// Whether the offset in force displaces targets by more than five resolution cells relative to the best
/// offset.
fn moves_far(prepared: &Prepared, track: &Track, seen: &ClockSeen) -> bool {
    let apart_s = (seen.offset_s - seen.best_s).abs();
    median_speed_m_s(prepared, track).is_some_and(|v| v * apart_s > FAR_M)
}

/// Five resolution cells of ultra-wideband images (m).
const FAR_M: f64 = 5.0 * ALONG_TRACK_M;

/// Displacement of targets by the deviation of an estimated or recorded offset, at the median speed of the
/// traces.
fn offset_sigma(prepared: &Prepared, track: &Track) -> Option<Finding> {
    let judged_at = |speed_m_s| match (&track.search, &track.recorded_clock) {
        (Some(search), _) => Some(clock_offset_sigma(search.estimate.sigma_s, speed_m_s)),
        (None, Some(clock)) => Some(recorded_clock_sigma(clock.sigma_s, speed_m_s)),
        (None, None) => None,
    };
    judged_at(median_speed_m_s(prepared, track)?)
}

/// Median speed of the traces of a track (m/s).
fn median_speed_m_s(prepared: &Prepared, track: &Track) -> Option<f64> {
    let positions = prepared.aligned.position_m.get(track.range.clone())?;
    let times = prepared.aligned.time_s.get(track.range.clone())?;
    let pairs = positions.windows(2).zip(times.windows(2));
    let speed = pairs.filter(|(_, t)| t[1] > t[0]).map(|(p, t)| {
        let square: f64 = (0..3).map(|i| (p[1][i] - p[0][i]).powi(2)).sum();
        square.sqrt() / (t[1] - t[0])
    });
    median(speed)
}

/// The offset in force, and the likelihood of all offsets.
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

/// The offset in force, and the likelihood of all offsets by height and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClockSeen {
    /// The offset in force: trajectory time minus radar time (s).
    pub offset_s: f64,
    /// The most likely offset, and its standard deviation (s).
    pub best_s: f64,
    /// Standard deviation (s).
    pub sigma_s: f64,
    /// Log-likelihood of the offset in force below the maximum.
    pub below_best: f64,
}

/// Log-likelihoods below the best that are doubtful (odds of 3000 to 1) and contradict.
const DOUBTFUL_BELOW: f64 = 8.0;
const CONTRADICTING_BELOW: f64 = 20.0;

/// Offsets nearer than this to the best agree with it: the error by sloping ground and by the lever arm under
/// tilt (s).
const SAME_S: f64 = 0.03;

/// Largest deviation of an offset that counts as determined (s): at 1.5 m/s three deviations are a resolution
/// cell.
const LARGEST_SIGMA_S: f64 = 0.015;

/// Judges the clock offset by its likelihood.
fn clock_offset(seen: &ClockSeen) -> Finding {
    let apart_s = (seen.offset_s - seen.best_s).abs();
    let verdict = if apart_s <= SAME_S.max(3.0 * seen.sigma_s) || seen.below_best < DOUBTFUL_BELOW {
        Verdict::Agrees
    } else if seen.below_best < CONTRADICTING_BELOW {
        Verdict::Doubtful
    } else {
        Verdict::Contradicts
    };
    Finding {
        checks: (seen.sigma_s <= LARGEST_SIGMA_S).then_some(Setting::ClockOffset),
        sigma: Some(seen.sigma_s),
        ..Finding::judged("clock_offset", seen.offset_s, "s", verdict)
    }
    .expecting(seen.best_s)
    .because(format!(
        "the echoes follow the flight's height and motion best {:+.3} s (± {:.3} s) from the offset \
         in force, whose log-likelihood is {:.0} below ([trajectory] time_offset_s; is this the \
         trajectory of this flight?)",
        seen.best_s - seen.offset_s,
        seen.sigma_s,
        seen.below_best
    ))
}

/// Places along the track that are uncertain by more than this are doubted (m): a resolution cell of
/// ultra-wideband images.
const ALONG_TRACK_M: f64 = 0.05;

/// Judges an offset found from the data by the uncertainty of places along the track.
fn clock_offset_sigma(sigma_s: f64, speed_m_s: f64) -> Finding {
    let along_m = sigma_s * speed_m_s;
    along_track(along_m).because(format!(
        "the clock offset was found to ± {:.0} ms: at {speed_m_s:.1} m/s every target is uncertain by \
         {along_m:.2} m along the track (one standard deviation); take-off, climbs or turns in the log \
         determine it better ([trajectory] time_offset_s)",
        1e3 * sigma_s
    ))
}

/// Judges the offset of a recorded clock by the uncertainty of places along the track that its stated
/// deviation implies.
fn recorded_clock_sigma(sigma_s: f64, speed_m_s: f64) -> Finding {
    let along_m = sigma_s * speed_m_s;
    along_track(along_m).because(format!(
        "the clock offset is that of the clock recorded with the radar log, which states ± {:.2} ms: at \
         {speed_m_s:.1} m/s every target is uncertain by {along_m:.3} m along the track (one standard \
         deviation); measured latencies or time marks give a better one ([radio] latency_ms and [gnss] \
         latency_ms of the session, UBX-TIM-TM2)",
        1e3 * sigma_s
    ))
}

/// Uncertainty of a place along the track that is doubted.
fn along_track(along_m: f64) -> Finding {
    let verdict = if along_m <= ALONG_TRACK_M {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("clock_offset_sigma", along_m, "m", verdict).expecting(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_that_moves_targets_by_more_than_a_cell_is_doubted() {
        assert_eq!(clock_offset_sigma(0.02, 1.5).verdict, Verdict::Agrees);
        let wide = clock_offset_sigma(0.04, 1.5);
        assert_eq!(wide.verdict, Verdict::Doubtful);
        assert!((wide.value.unwrap_or(0.0) - 0.06).abs() < 1e-12);
        assert_eq!(recorded_clock_sigma(2e-4, 2.0).verdict, Verdict::Agrees);
        assert_eq!(recorded_clock_sigma(0.04, 2.0).verdict, Verdict::Doubtful);
    }

    #[test]
    fn an_offset_far_less_likely_than_the_best_contradicts() {
        let at = |offset_s, below_best| {
            clock_offset(&ClockSeen {
                offset_s,
                best_s: 6.52,
                sigma_s: 0.004,
                below_best,
            })
            .verdict
        };
        assert_eq!(at(6.53, 3.0), Verdict::Agrees);
        assert_eq!(at(7.5, 4.0), Verdict::Agrees);
        assert_eq!(at(7.5, 12.0), Verdict::Doubtful);
        assert_eq!(at(24.5, 80.0), Verdict::Contradicts);
    }
}
