//! The float solution: state, double differences, cycle slips.

pub(crate) mod double;
pub(crate) mod slips;
pub(crate) mod state;
pub(crate) mod time_difference;
