//! Antenna calibrations in ANTEX 1.4: the phase centre of a receiver's antenna by frequency and direction.
//!
//! A pseudorange or phase is measured to the antenna's phase centre, positions are those of the antenna
//! reference point (ARP). The phase centre offset (PCO), a vector in the antenna's axes, and the phase centre
//! variation (PCV) over direction relate the two. Antennas are assumed levelled and oriented to the north, as
//! calibrations assume.

mod calibration;
mod file;

pub use calibration::{AntennaCalibration, FrequencyCalibration};
pub use file::{AntexFile, read_antex};
