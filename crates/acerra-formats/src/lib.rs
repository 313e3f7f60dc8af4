//! Radar files of other makers, as one neutral type.
//!
//! ```text
//! file ──open──► Recording: channels of traces over fast time or frequency, with what is known of each
//!                           header facts, remarks, statements that contradict each other
//! ```
//!
//! | format | read | with |
//! | --- | --- | --- |
//! | SEG-Y, revisions 0 to 2 ([`segy`]) | samples, places, stamps, several antennas | – |
//! | GSSI DZT ([`dzt`]) | 8, 16, 32 bits, channels, time zero | DZG, DZX |
//! | Sensors & Software DT1 ([`dt1`]) | samples, positions along the line | HD, GPS |
//! | MALÅ rd3, rd7 ([`mala`]) | 16, 32 bits | rad, cor |
//! | gprMax, HDF5, MATLAB 7.3 ([`hdf5`]) | every receiver and component; named arrays | – |
//! | MATLAB 5 ([`matlab5`]) | named arrays | – |
//! | Touchstone ([`touchstone`]), analyser tables ([`analyser_csv`]) | sweeps | – |
//! | FMCW ([`fmcw`]) | beat signals, deramped | TOML for raw samples |
//!
//! Kinds are recognised by content. Readers hold no more than [`Limits`] admit, count the bytes that they skip, and
//! name the place of what is wrong.

pub mod analyser_csv;
pub mod dt1;
pub mod dzt;
pub mod fmcw;
pub mod hdf5;
pub mod mala;
pub mod matlab5;
pub mod segy;
pub mod touchstone;

mod antenna;
mod bytes;
mod companion;
mod error;
mod fixes;
mod keys;
mod limits;
mod named;
mod open;
mod recording;
mod traces;

pub use antenna::AntennaFrequency;
pub use error::{FormatError, Place};
pub use limits::Limits;
pub use open::{open, recognise};
pub use recording::{Axis, Channel, Contradiction, Format, Positions, Recording, Values};
