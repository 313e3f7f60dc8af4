//! Result of the next part of a satellite's navigation message.

use crate::orbits::navigation::{GlonassEphemeris, KeplerEphemeris, Klobuchar};

/// Result of a subframe, page or string.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Decoded {
    /// No result yet: parts of one issue are missing, or the part contains no ephemeris.
    Pending,
    /// A Keplerian ephemeris of parts of one issue.
    Kepler(Box<KeplerEphemeris>),
    /// A GLONASS ephemeris of strings of one superframe.
    Glonass(Box<GlonassEphemeris>),
    /// Ionosphere coefficients (GPS page 18 of subframe 4).
    Ionosphere(Klobuchar),
    /// Wrong check bits, or a part with contradictory content.
    Invalid,
}
