//! The host's clock over GPS time by pulses per second.
//!
//! A pulse does not identify its second; the clock by times of arrival must identify the second. Pulses of a
//! locked receiver lie at one phase of that clock's second: the phase of most edges gives the receiver's
//! latency, and an edge at another phase is no pulse. The kernel numbers edges: where it counted more edges
//! than seconds passed, one edge was doubled, and its stamp may be of the later edge.

use acerra_geo::time::GpsTime;

use super::fit::{ClockLine, LEAST_PAIRS};
use super::logged::Latency;
use super::pulse::{LEAST_SHARE, MOST_SCATTER_S, MOST_WANDER_S, Pulse, PulseError};
use super::robust_line::{LinePair, RobustLine};

/// Deviations of the arrival clock that must be less than half a second.
const SURE_SIGMAS: f64 = 4.0;
/// Distance from their common phase within which pulses are examined (s): far more than the scatter of
/// pulses, far less than the width of a pulse.
const GATE_S: f64 = 0.01;
/// Deviations from the median line beyond which a pulse is outlying, and the least such distance (s).
const OUTLYING: f64 = 6.0;
const LEAST_OUTLYING_S: f64 = 10e-6;

/// The host's clock over GPS time, by pulses.
#[derive(Clone, Copy, Debug)]
pub(super) struct PulseLine {
    /// Host clock over GPS seconds after the origin.
    pub line: RobustLine,
    /// From the first pulse of the line to the last (s).
    pub span_s: f64,
    /// Pulses with a fix that are not on the line.
    pub outlying: usize,
    /// Pulses with doubled edges.
    pub doubled: usize,
    /// Pulses without a fix.
    pub without_fix: usize,
}

impl PulseLine {
    /// The line of the pulses, `arrivals` being the host's clock at first bytes over GPS seconds after
    /// `origin`, and `latency` the prior of the time from an epoch to its first byte.
    pub fn through(
        pulses: &[Pulse],
        arrivals: &ClockLine,
        origin: GpsTime,
        latency: Latency,
    ) -> Result<Self, PulseError> {
        let doubled = doubled_edges(pulses, arrivals.rate);
        let single = pulses.iter().zip(&doubled).filter(|(_, is)| !**is);
        let sound: Vec<f64> = single
            .filter(|(pulse, _)| pulse.has_fix)
            .map(|(pulse, _)| pulse.host_s)
            .collect();
        let doubled = doubled.iter().filter(|is| **is).count();
        let without_fix = pulses.iter().filter(|pulse| !pulse.has_fix).count();
        let too_few = |found| PulseError::TooFew {
            found,
            without_fix,
            doubled,
        };
        let ends = sound.first().zip(sound.last());
        let Some((first_s, last_s)) = ends.filter(|_| sound.len() >= LEAST_PAIRS) else {
            return Err(too_few(sound.len()));
        };
        let seconds = Seconds {
            arrivals,
            origin,
            latency,
            half_span_s: 0.5 * (last_s - first_s),
        };
        seconds.check(*first_s, *last_s)?;
        let near = seconds.at_one_phase(&sound);
        let not_seconds = |together| PulseError::NotSeconds {
            together,
            pulses: sound.len(),
        };
        let is_most = |count: usize| count as f64 >= LEAST_SHARE * sound.len() as f64;
        if !is_most(near.len()) {
            return Err(not_seconds(near.len()));
        }
        let kept = on_median_line(&near);
        if !is_most(kept.len()) {
            return Err(not_seconds(kept.len()));
        }
        let line = RobustLine::through(&kept).ok_or(too_few(kept.len()))?;
        if line.scatter_s > MOST_SCATTER_S {
            return Err(PulseError::Unsteady {
                scatter_s: line.scatter_s,
            });
        }
        if line.wander_s > MOST_WANDER_S {
            return Err(PulseError::Wandering {
                wander_s: line.wander_s,
            });
        }
        let ends = kept.first().zip(kept.last());
        Ok(Self {
            line,
            span_s: ends.map_or(0.0, |(first, last)| last.at_s - first.at_s),
            outlying: sound.len() - line.used,
            doubled,
            without_fix,
        })
    }
}

/// Of each pulse, whether the kernel counted more edges than seconds since the one before; `rate` is host
/// seconds in a second of GPS time.
fn doubled_edges(pulses: &[Pulse], rate: f64) -> Vec<bool> {
    let is_doubled = |pair: &[Pulse]| {
        let edges = pair[1].sequence.wrapping_sub(pair[0].sequence);
        let seconds = ((pair[1].host_s - pair[0].host_s) / rate).round();
        // A driver that was loaded again counts again.
        edges < 1 << 31 && f64::from(edges) > seconds
    };
    let first = pulses.first().map(|_| false);
    let others = pulses.windows(2).map(is_doubled);
    first.into_iter().chain(others).collect()
}

/// The arrival clock, by which pulses are numbered.
struct Seconds<'a> {
    arrivals: &'a ClockLine,
    origin: GpsTime,
    latency: Latency,
    half_span_s: f64,
}

impl Seconds<'_> {
    /// Checks that the arrival clock resolves whole seconds between two host times.
    fn check(&self, first_s: f64, last_s: f64) -> Result<(), PulseError> {
        let sigma_s = [first_s, last_s]
            .map(|host_s| self.arrivals.sigma_at_s(self.after_origin_s(host_s)))
            .into_iter()
            .fold(0.0, f64::max)
            .hypot(self.latency.sigma_s);
        let limit_s = 0.5 / SURE_SIGMAS;
        // Not so either where it is no number.
        if sigma_s < limit_s {
            return Ok(());
        }
        Err(PulseError::Ambiguous { sigma_s, limit_s })
    }

    /// GPS time by the arrival clock (s after the origin).
    fn after_origin_s(&self, host_s: f64) -> f64 {
        let line = self.arrivals;
        line.at_s + (host_s + self.latency.delay_s - line.reads_s) / line.rate
    }

    /// The pulses at the phase of the second at which most of them are, each with its second after the
    /// origin; of several in a second the one nearest to that phase.
    fn at_one_phase(&self, pulses_s: &[f64]) -> Vec<LinePair> {
        // The origin itself may lie within a second.
        let fraction_s = self.origin.fraction();
        let seconds: Vec<f64> = pulses_s
            .iter()
            .map(|host_s| self.after_origin_s(*host_s) + fraction_s)
            .collect();
        let reach_s = GATE_S + SURE_SIGMAS * self.arrivals.sigma_rate * self.half_span_s;
        let phase_s = most_common_phase_s(&seconds, reach_s);
        let mut found: Vec<(f64, f64, LinePair)> = Vec::new();
        for (second, host_s) in seconds.iter().zip(pulses_s) {
            let whole = (second - phase_s).round();
            let off_s = (second - phase_s - whole).abs();
            if off_s > reach_s {
                continue;
            }
            let pair = LinePair {
                at_s: whole - fraction_s,
                reads_s: *host_s,
            };
            match found.last_mut().filter(|last| last.0 == whole) {
                Some(last) if off_s < last.1 => *last = (whole, off_s, pair),
                Some(_) => {}
                None => found.push((whole, off_s, pair)),
            }
        }
        found.into_iter().map(|(_, _, pair)| pair).collect()
    }
}

/// The middle of the densest interval of this half width among the phases within a second.
fn most_common_phase_s(seconds: &[f64], reach_s: f64) -> f64 {
    let mut phases_s: Vec<f64> = seconds.iter().map(|s| s - s.round()).collect();
    phases_s.sort_by(f64::total_cmp);
    // The end of a second is the beginning of the next.
    let again: Vec<f64> = phases_s.iter().map(|p| p + 1.0).collect();
    let count = phases_s.len();
    phases_s.extend(again);
    let (mut end, mut best) = (0, (0, 0));
    for begin in 0..count {
        while end < begin + count && phases_s[end] <= phases_s[begin] + 2.0 * reach_s {
            end += 1;
        }
        if end - begin > best.0 {
            best = (end - begin, begin);
        }
    }
    let (held, begin) = best;
    let middle_s = phases_s.get(begin + held / 2).copied().unwrap_or(0.0);
    middle_s - middle_s.round()
}

/// The pairs but those far from the line of median slope and offset, which outlying pairs on one side
/// do not pull.
fn on_median_line(pairs: &[LinePair]) -> Vec<LinePair> {
    let half = pairs.len() / 2;
    let slope_of = |(a, b): (&LinePair, &LinePair)| (b.reads_s - a.reads_s) / (b.at_s - a.at_s);
    let slope = median(pairs.iter().zip(&pairs[half..]).map(slope_of).collect());
    let offset = |p: &LinePair| p.reads_s - slope * p.at_s;
    let value_s = median(pairs.iter().map(offset).collect());
    let off_s = |p: &LinePair| (offset(p) - value_s).abs();
    // The deviation of a normal distribution by the median of moduli.
    let usual_s = 1.4826 * median(pairs.iter().map(off_s).collect());
    let limit_s = (OUTLYING * usual_s).max(LEAST_OUTLYING_S);
    pairs
        .iter()
        .copied()
        .filter(|p| off_s(p) <= limit_s)
        .collect()
}

/// The middle value; 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_about_the_end_of_a_second_lie_together() {
        let seconds: Vec<f64> = (0..40)
            .map(|k| f64::from(k) + if k % 2 == 0 { 0.499 } else { 0.501 })
            .chain([0.1, 0.2, 0.3])
            .collect();
        let phase_s = most_common_phase_s(&seconds, GATE_S);
        assert!((phase_s.abs() - 0.5).abs() < 2e-3, "{phase_s}");
        assert_eq!(most_common_phase_s(&[], GATE_S), 0.0);
    }

    #[test]
    fn a_doubled_edge_is_one_that_no_second_goes_with() {
        let pulse = |sequence, host_s| Pulse {
            sequence,
            host_s,
            has_fix: true,
        };
        let pulses = [
            pulse(u32::MAX, 1.0),
            pulse(0, 2.0),
            // Two missed, one of them by the reader.
            pulse(2, 5.0),
            // An edge in between.
            pulse(4, 6.001),
            pulse(5, 6.9),
            // The other edge of it.
            pulse(6, 7.1),
            // A driver loaded again.
            pulse(1, 8.0),
        ];
        let doubled = doubled_edges(&pulses, 1.0);
        assert_eq!(doubled, [false, false, false, true, false, true, false]);
        assert!(doubled_edges(&[], 1.0).is_empty());
    }
}
