//! The quality of a solution.

/// Quality of a solution, with RTKLIB's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quality {
    /// 1: ambiguities fixed to integers.
    Fixed,
    /// 2: carrier phase with float ambiguities.
    Float,
    /// 3: corrected by SBAS.
    Sbas,
    /// 4: differential pseudoranges.
    Dgps,
    /// 5: single-point position.
    Single,
    /// 6: precise point positioning.
    Ppp,
}

impl Quality {
    /// The number `.pos` files use (1–6).
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8 + 1
    }
}
