//! Residuals of an epoch at the updated state.

use crate::float::double::Differences;
use crate::measurements::zero::ZeroDifference;
use std::sync::Arc;

/// Rover residuals and double differences at the updated state.
pub(super) struct Update {
    pub zero: Arc<[ZeroDifference]>,
    pub differences: Differences,
}
