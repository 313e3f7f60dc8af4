//! Rover and base at one epoch: places, measurements, motion of the base; the sky of a log.

pub(crate) mod base_position;
pub(crate) mod epoch_input;
pub(crate) mod moving_base;
pub(crate) mod sky;
