//! The wire from an emulated radio's pulse to an emulated receiver's time-mark input.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pulses that wait; a receiver that nobody reads loses older ones.
const MOST_WAITING: usize = 4_096;

/// A wire that carries pulses at world times. Each end holds a copy of it.
#[derive(Debug, Clone)]
pub struct PulseLine {
    state: Arc<Mutex<State>>,
}

#[derive(Debug)]
struct State {
    waiting_s: VecDeque<f64>,
    /// Edges counted; the receiver's counter has 16 bits.
    count: u16,
    loss: f64,
    random: ChaCha8Rng,
}

/// The latest of several edges, as a receiver reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatestEdge {
    /// World time (s).
    pub at_s: f64,
    /// Number of edges so far, modulo 2¹⁶.
    pub count: u16,
}

impl PulseLine {
    /// A wire on which this share of the pulses is lost. The count of edges wraps soon.
    #[must_use]
    pub fn new(loss: f64, seed: u64) -> Self {
        let state = State {
            waiting_s: VecDeque::new(),
            count: u16::MAX - 100,
            loss: loss.clamp(0.0, 1.0),
            random: ChaCha8Rng::seed_from_u64(seed),
        };
        Self {
            state: Arc::new(Mutex::new(state)),
        }
    }

    /// A pulse at a world time (s).
    pub fn pulse(&self, at_s: f64) {
        let mut guard = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let state = &mut *guard;
        if state.random.random_bool(state.loss) {
            return;
        }
        if state.waiting_s.len() >= MOST_WAITING {
            state.waiting_s.pop_front();
        }
        state.waiting_s.push_back(at_s);
    }

    /// The latest edge up to a world time, of those since the last call.
    #[must_use]
    pub fn latest(&self, until_s: f64) -> Option<LatestEdge> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let mut latest = None;
        while let Some(at_s) = state.waiting_s.front().copied().filter(|s| *s <= until_s) {
            state.waiting_s.pop_front();
            state.count = state.count.wrapping_add(1);
            latest = Some(LatestEdge {
                at_s,
                count: state.count,
            });
        }
        latest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_edge_is_told_with_the_count_of_all() {
        let line = PulseLine::new(0.0, 1);
        for k in 0..150 {
            line.pulse(0.1 * f64::from(k));
        }
        let first = line.latest(4.95).unwrap();
        assert_eq!((first.at_s, first.count), (4.9, u16::MAX - 50));
        assert_eq!(line.latest(4.95), None);
        assert_eq!(line.latest(1e3).unwrap().count, 49);
    }
}
