//! How messages travel between the radio and this computer.

mod framing;

pub use framing::{Deframer, frame_body};
