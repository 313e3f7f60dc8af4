//! Waiting time of pulses for a better clock.

/// Longest time that pulses wait for a better clock (s): pulses per second take 16 s of a settled fix.
pub(crate) const CLOCK_WAIT_S: f64 = 30.0;

/// Whether pulses wait for a better clock that the session is wired for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Patience {
    /// Not yet.
    #[default]
    Fresh,
    /// Since a host time (s).
    Since(f64),
    /// No longer, for good.
    Over,
}

impl Patience {
    /// Whether pulses wait.
    pub fn is_waiting(self) -> bool {
        matches!(self, Self::Since(_))
    }

    /// Its state at a host time (s): over once the best clock is reached, after [`CLOCK_WAIT_S`], or where
    /// too many pulses wait.
    pub fn at(self, host_s: f64, has_best: bool, are_too_many: bool) -> Self {
        match self {
            _ if has_best => Self::Over,
            Self::Fresh => Self::Since(host_s),
            Self::Since(since_s) if are_too_many || host_s - since_s > CLOCK_WAIT_S => Self::Over,
            same => same,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patience_ends_once_and_for_good() {
        let waits = Patience::Fresh.at(5.0, false, false);
        assert_eq!(waits, Patience::Since(5.0));
        assert!(waits.at(35.0, false, false).is_waiting());
        for over in [
            waits.at(35.1, false, false),
            waits.at(6.0, true, false),
            waits.at(6.0, false, true),
            Patience::Fresh.at(5.0, true, false),
        ] {
            assert_eq!(over, Patience::Over);
            assert_eq!(over.at(7.0, false, false), Patience::Over);
        }
    }
}
