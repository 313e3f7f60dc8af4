//! Self-checks of plans against the double-precision sum.

pub(super) mod forward;
pub(super) mod imaging;
pub(super) mod places;
