//! Rover and base at one epoch: places, measurements, motion of the base.

pub(crate) mod base_position;
pub(crate) mod epoch_input;
pub(crate) mod moving_base;
