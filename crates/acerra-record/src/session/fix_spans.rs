//! When a receiver had a fix, from its bytes in the log.

use acerra_gnss::ubx::FixState;

/// Longest gap between two messages reporting a fix across which the fix counts as held (s).
const LONGEST_GAP_S: f64 = 3.0;
/// Time that a receiver's pulses take to settle once it has a fix (s).
const SETTLES_S: f64 = 1.0;

/// Host times at which a receiver had a fix without interruption.
#[derive(Default)]
pub(super) struct FixSpans {
    spans: Vec<Span>,
    is_lost: bool,
}

struct Span {
    /// Start of the recording.
    start: usize,
    from_s: f64,
    until_s: f64,
}

impl FixSpans {
    /// Adds the fix state reported at `host_s` in one `start` of the recording; times increase within a start.
    pub fn take(&mut self, state: &FixState, start: usize, host_s: f64) {
        if !state.has_fix {
            self.is_lost = true;
            return;
        }
        let is_lost = std::mem::take(&mut self.is_lost);
        let goes_on = |span: &&mut Span| {
            !is_lost && span.start == start && host_s - span.until_s <= LONGEST_GAP_S
        };
        match self.spans.last_mut().filter(goes_on) {
            Some(span) => span.until_s = span.until_s.max(host_s),
            None => self.spans.push(Span {
                start,
                from_s: host_s,
                until_s: host_s,
            }),
        }
    }

    /// Whether the receiver had a fix at `host_s`, and long enough before for its pulses to settle.
    pub fn is_settled(&self, start: usize, host_s: f64) -> bool {
        let after = self
            .spans
            .partition_point(|span| (span.start, span.from_s + SETTLES_S) <= (start, host_s));
        self.spans[..after]
            .last()
            .is_some_and(|span| span.start == start && host_s <= span.until_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fix_counts_once_it_is_settled_and_until_it_is_lost() {
        let mut spans = FixSpans::default();
        let mut take = |start, host_s, has_fix| {
            let state = FixState {
                has_fix,
                satellites: 9,
                height_m: None,
            };
            spans.take(&state, start, host_s);
        };
        for k in 0..50 {
            let host_s = 0.2 * f64::from(k);
            take(1, host_s, !(3.9..6.1).contains(&host_s));
        }
        // The host's clock starts again; then the receiver is silent.
        for host_s in [0.5, 1.0, 2.0, 3.0, 9.0, 9.5] {
            take(2, host_s, true);
        }
        for (start, host_s, expected) in [
            (1, 0.5, false),
            (1, 1.5, true),
            (1, 3.7, true),
            (1, 3.95, false),
            (1, 5.0, false),
            (1, 6.9, false),
            (1, 7.5, true),
            (1, 9.9, false),
            (2, 1.2, false),
            (2, 1.7, true),
            (2, 5.0, false),
            (2, 9.4, false),
            (3, 2.0, false),
        ] {
            assert_eq!(
                spans.is_settled(start, host_s),
                expected,
                "{start} {host_s}"
            );
        }
    }
}
