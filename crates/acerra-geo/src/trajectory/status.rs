//! Stated quality of a position.

/// The kind of solution a position comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SolutionStatus {
    /// Carrier phase with integer ambiguities: centimetres.
    Fixed,
    /// Carrier phase with real ambiguities: decimetres.
    Float,
    /// Code with satellite-based corrections.
    Sbas,
    /// Code against a base: decimetres to metres.
    Dgps,
    /// Code alone: metres.
    Single,
    /// Precise point positioning.
    Ppp,
    /// Not from GNSS: motion capture, simulation, a table without a quality column. Accepted as stated.
    External,
    /// A quality mark that no convention explains, or a receiver's dead reckoning.
    Unknown,
}

impl SolutionStatus {
    /// Every status, best first as RTKLIB counts them.
    pub const ALL: [Self; 8] = [
        Self::Fixed,
        Self::Float,
        Self::Sbas,
        Self::Dgps,
        Self::Single,
        Self::Ppp,
        Self::External,
        Self::Unknown,
    ];

    /// From RTKLIB's Q: 1 fix, 2 float, 3 SBAS, 4 DGPS, 5 single, 6 PPP; anything else is unknown.
    #[must_use]
    pub const fn from_rtklib_q(q: u32) -> Self {
        match q {
            1 => Self::Fixed,
            2 => Self::Float,
            3 => Self::Sbas,
            4 => Self::Dgps,
            5 => Self::Single,
            6 => Self::Ppp,
            _ => Self::Unknown,
        }
    }

    /// Whether the position is of the grade that imaging needs: [`Self::Fixed`] or
    /// [`Self::External`].
    #[must_use]
    pub const fn is_fixed(self) -> bool {
        matches!(self, Self::Fixed | Self::External)
    }

    /// The one of two that promises less.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        let rank = |s: Self| match s {
            Self::External => 0,
            Self::Fixed => 1,
            Self::Ppp => 2,
            Self::Float => 3,
            Self::Dgps => 4,
            Self::Sbas => 5,
            Self::Single => 6,
            Self::Unknown => 7,
        };
        if rank(other) > rank(self) {
            other
        } else {
            self
        }
    }

    /// One word, as written in `trajectory.csv`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Float => "float",
            Self::Sbas => "sbas",
            Self::Dgps => "dgps",
            Self::Single => "single",
            Self::Ppp => "ppp",
            Self::External => "external",
            Self::Unknown => "unknown",
        }
    }

    /// The status of that [`name`](Self::name), case ignored.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|status| status.name().eq_ignore_ascii_case(name))
    }
}

impl std::fmt::Display for SolutionStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Number of positions of each status.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatusCounts([usize; 8]);

impl StatusCounts {
    /// Positions of one status.
    #[must_use]
    pub const fn of(&self, status: SolutionStatus) -> usize {
        self.0[status as usize]
    }

    /// All positions.
    #[must_use]
    pub fn total(&self) -> usize {
        self.0.iter().sum()
    }

    /// Positions of the grade that imaging needs ([`SolutionStatus::is_fixed`]).
    #[must_use]
    pub fn fixed(&self) -> usize {
        SolutionStatus::ALL
            .into_iter()
            .filter(|s| s.is_fixed())
            .map(|s| self.of(s))
            .sum()
    }

    /// Statuses that occur, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (SolutionStatus, usize)> + '_ {
        SolutionStatus::ALL
            .into_iter()
            .map(|s| (s, self.of(s)))
            .filter(|&(_, n)| n > 0)
    }
}

impl FromIterator<SolutionStatus> for StatusCounts {
    fn from_iter<I: IntoIterator<Item = SolutionStatus>>(statuses: I) -> Self {
        let mut counts = Self::default();
        for status in statuses {
            counts.0[status as usize] += 1;
        }
        counts
    }
}

/// `952 fixed, 3 float`.
impl std::fmt::Display for StatusCounts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, (status, count)) in self.iter().enumerate() {
            write!(f, "{}{count} {status}", if i > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_codes_return() {
        for status in SolutionStatus::ALL {
            assert_eq!(SolutionStatus::from_name(status.name()), Some(status));
            assert_eq!(SolutionStatus::ALL[status as usize], status);
        }
        use SolutionStatus::{Dgps, Fixed, Float, Ppp, Sbas, Single, Unknown};
        let by_q = [Unknown, Fixed, Float, Sbas, Dgps, Single, Ppp, Unknown];
        for (q, status) in (0..).zip(by_q) {
            assert_eq!(SolutionStatus::from_rtklib_q(q), status);
        }
    }

    #[test]
    fn counts_say_what_there_is() {
        use SolutionStatus::{External, Fixed, Float};
        let counts: StatusCounts = [Fixed, Float, Fixed, External].into_iter().collect();
        assert_eq!(
            (counts.total(), counts.fixed(), counts.of(Fixed)),
            (4, 3, 2)
        );
        assert_eq!(counts.to_string(), "2 fixed, 1 float, 1 external");
        assert_eq!(Fixed.worse(Float), Float);
    }
}
