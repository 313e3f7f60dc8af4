//! Confirmation of fixes by a second pass, and contradictions between fixes.

pub(crate) mod agreement;
pub(crate) mod contradiction;
