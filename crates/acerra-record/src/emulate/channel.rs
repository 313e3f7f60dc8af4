//! A bad link: messages lost, repeated, delayed, overtaken.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Faults of a link's messages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impairments {
    /// Share of messages lost.
    pub loss: f64,
    /// Share of messages sent twice.
    pub repetition: f64,
    /// Share of messages held back for [`Impairments::held_back_s`], so that others overtake them.
    pub reordering: f64,
    /// Delay of those messages (s).
    pub held_back_s: f64,
    /// Delay of every message (s).
    pub delay_s: f64,
    /// Mean of a delay added to each message, exponentially distributed (s).
    pub jitter_s: f64,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for Impairments {
    fn default() -> Self {
        Self {
            loss: 0.0,
            repetition: 0.0,
            reordering: 0.0,
            held_back_s: 0.0,
            delay_s: 0.0,
            jitter_s: 0.0,
            seed: 1,
        }
    }
}

/// Actions of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChannelCounts {
    /// Messages given to the channel.
    pub messages: u64,
    /// Messages lost.
    pub lost: u64,
    /// Of those, messages in transit when the sender restarted.
    pub lost_on_restart: u64,
    /// Messages sent twice.
    pub repeated: u64,
    /// Messages held back.
    pub held_back: u64,
}

/// Messages in transit, each due at a time in microseconds of the emulator's clock.
pub struct Channel<T> {
    impairments: Impairments,
    random: ChaCha8Rng,
    on_way: BinaryHeap<Reverse<Due<T>>>,
    number: u64,
    counts: ChannelCounts,
}

/// A message with its due time; ordered by due time, then by order of sending.
struct Due<T> {
    at_us: u64,
    number: u64,
    message: T,
}

impl<T> PartialEq for Due<T> {
    fn eq(&self, other: &Self) -> bool {
        (self.at_us, self.number) == (other.at_us, other.number)
    }
}

impl<T> Eq for Due<T> {}

impl<T> PartialOrd for Due<T> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Due<T> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.at_us, self.number).cmp(&(other.at_us, other.number))
    }
}

impl<T: Clone> Channel<T> {
    /// An empty channel.
    #[must_use]
    pub fn new(impairments: Impairments) -> Self {
        Self {
            impairments,
            random: ChaCha8Rng::seed_from_u64(impairments.seed),
            on_way: BinaryHeap::new(),
            number: 0,
            counts: ChannelCounts::default(),
        }
    }

    /// Sends a message at `now_us`.
    pub fn send(&mut self, now_us: u64, message: T) {
        let bad = self.impairments;
        self.counts.messages += 1;
        if self.random.random_bool(bad.loss.clamp(0.0, 1.0)) {
            self.counts.lost += 1;
            return;
        }
        let copies = if self.random.random_bool(bad.repetition.clamp(0.0, 1.0)) {
            self.counts.repeated += 1;
            2
        } else {
            1
        };
        for _ in 0..copies {
            let uniform: f64 = self.random.random();
            let mut delay_s = bad.delay_s - bad.jitter_s * (1.0 - uniform).ln();
            if self.random.random_bool(bad.reordering.clamp(0.0, 1.0)) {
                self.counts.held_back += 1;
                delay_s += bad.held_back_s;
            }
            self.number += 1;
            self.on_way.push(Reverse(Due {
                at_us: now_us + (1e6 * delay_s.max(0.0)) as u64,
                number: self.number,
                message: message.clone(),
            }));
        }
    }

    /// The next message that is due by `now_us`.
    pub fn take_due(&mut self, now_us: u64) -> Option<T> {
        if self.on_way.peek()?.0.at_us > now_us {
            return None;
        }
        self.on_way.pop().map(|due| due.0.message)
    }

    /// When the next message is due.
    #[must_use]
    pub fn next_due_us(&self) -> Option<u64> {
        self.on_way.peek().map(|due| due.0.at_us)
    }

    /// Every message in transit is lost, as when the sender restarts.
    pub fn clear(&mut self) {
        let on_way = self.on_way.len() as u64;
        self.counts.lost += on_way;
        self.counts.lost_on_restart += on_way;
        self.on_way.clear();
    }

    /// Faults of the channel so far.
    #[must_use]
    pub fn counts(&self) -> ChannelCounts {
        self.counts
    }
}
