//! Boresight of the antenna at each trace.

use acerra_geo::trajectory::Attitude;

/// Straight down: the antenna of a level platform, in east, north, up as in forward, left, up.
pub const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
/// Along the carrier's nose, in forward, left, up: the axis of a camera.
pub const FORWARD: [f64; 3] = [1.0, 0.0, 0.0];

/// Directions in which an axis of a platform or a gimbal points, trace by trace. Both lists are as long as the
/// traces, or empty where no trace has an attitude.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boresights {
    /// Unit vectors east, north, up.
    pub looks: Vec<[f64; 3]>,
    /// Whether the direction is from the trace's attitude; otherwise the direction is repeated from the trace
    /// before, or straight down.
    pub is_own: Vec<bool>,
}

impl Boresights {
    /// The directions of `axis` (forward, left, up) in each attitude.
    #[must_use]
    pub fn of(attitudes: &[Option<Attitude>], axis: [f64; 3]) -> Self {
        if attitudes.iter().all(Option::is_none) {
            return Self::default();
        }
        let mut held = DOWN;
        let looks = attitudes.iter().map(|attitude| {
            held = attitude.map_or(held, |attitude| attitude.rotate(axis));
            held
        });
        Self {
            looks: looks.collect(),
            is_own: attitudes.iter().map(Option::is_some).collect(),
        }
    }

    /// Whether no trace has an attitude.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.looks.is_empty()
    }

    /// Appends the directions of `more` further traces to those of `traces`: where only one side has attitudes the
    /// other counts as level.
    pub(crate) fn append_or_level(&mut self, traces: usize, mut other: Self, more: usize) {
        if self.is_empty() && other.is_empty() {
            return;
        }
        self.level(traces);
        other.level(more);
        self.append(other);
    }

    /// Appends the directions of further traces; where only one side has attitudes, none has.
    pub(crate) fn append_or_none(&mut self, traces: usize, other: Self) {
        if traces > 0 && self.is_empty() || other.is_empty() {
            *self = Self::default();
        } else {
            self.append(other);
        }
    }

    fn level(&mut self, traces: usize) {
        self.looks.resize(traces, DOWN);
        self.is_own.resize(traces, false);
    }

    fn append(&mut self, mut other: Self) {
        self.looks.append(&mut other.looks);
        self.is_own.append(&mut other.is_own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_turn_with_the_attitude_and_are_held_where_there_is_none() {
        assert!(Boresights::of(&[None, None], DOWN).is_empty());
        // Rolled by 30° about forward = east: up turns to the south, down to the north.
        let (s, c) = 15_f64.to_radians().sin_cos();
        let rolled = Attitude::from_quaternion(c, s, 0.0, 0.0);
        let attitudes = [None, rolled, None, Some(Attitude::IDENTITY)];
        let found = Boresights::of(&attitudes, DOWN);
        assert_eq!(found.is_own, [false, true, false, true]);
        assert_eq!((found.looks[0], found.looks[3]), (DOWN, DOWN));
        assert_eq!(found.looks[1], found.looks[2]);
        let [x, y, z] = found.looks[1];
        assert!(x.abs() < 1e-12 && (y - 0.5).abs() < 1e-12 && (z + 0.75_f64.sqrt()).abs() < 1e-12);
        // A roll about the nose does not move the nose.
        let nose = Boresights::of(&attitudes, FORWARD);
        assert!((nose.looks[1][0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn tracks_without_attitudes_count_as_level_and_without_gimbals_as_unknown() {
        let looks = [0.6, 0.0, -0.8];
        let one = Boresights {
            looks: vec![looks],
            is_own: vec![true],
        };
        let mut all = Boresights::default();
        all.append_or_level(0, Boresights::default(), 2);
        assert!(all.is_empty());
        all.append_or_level(2, one.clone(), 1);
        all.append_or_level(3, Boresights::default(), 1);
        assert_eq!(all.looks, [DOWN, DOWN, looks, DOWN]);
        assert_eq!(all.is_own, [false, false, true, false]);

        let mut all = Boresights::default();
        all.append_or_none(0, one.clone());
        all.append_or_none(1, one.clone());
        assert_eq!(all.looks, [looks; 2]);
        all.append_or_none(2, Boresights::default());
        assert!(all.is_empty());
        all.append_or_none(4, one);
        assert!(all.is_empty());
    }
}
