//! The positioning engine: preparation, filter passes, merging.

mod ambiguity;
mod base;
mod code_noise;
mod combine;
mod confirm;
mod constellation;
mod demo5;
mod diagnose;
mod double;
mod filter;
mod glonass;
mod measurement;
mod noise;
mod outliers;
mod pass;
mod plausible;
mod precision;
mod single;
mod slips;
mod state;
mod zero;

pub(crate) use base::base_position;
pub(crate) use code_noise::MeasuredNoise;
pub(crate) use combine::combine;
pub(crate) use constellation::Constellation;
pub(crate) use diagnose::{base_gaps, missing_navigation, phases_and_copies};
pub(crate) use filter::{EpochResult, RoverEpoch};
pub(crate) use glonass::GlonassPlan;
pub(crate) use measurement::{Epoch, epochs};
pub(crate) use pass::Prepared;
pub(crate) use plausible::reject_implausible;
pub(crate) use single::SingleContext;
