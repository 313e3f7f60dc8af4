//! Compensated phase history data, CPHD 1.x (NGA.STND.0068): spectra with positions, as programs for
//! synthetic aperture radar exchange them.
//!
//! ```text
//! PhaseHistory ──write_cphd──► CPHD 1.1.0 (FX domain, CF8, one channel a track)
//! CPHD 1.x, monostatic, FX domain ──read_cphd──► PhaseHistory of one channel
//! ```
//!
//! A CPHD file gives the phase of every echo relative to the echo of a point on the ground, the
//! stabilization reference point (SRP): of a target whose echo comes ΔTOA later than the SRP's, the
//! signal is e^{jSGN·2πf·ΔTOA}. Acerra's spectra give the phase relative to the antenna, e^{−j4πfR/c}. Written
//! files have SGN = −1, and with τ = 2R/c of the SRP the two are related by
//! `signal = spectrum · e^{+j2πfτ}`, pulse by pulse.
//!
//! Two pulses over a scene, written and read:
//!
//! ```
//! use std::io::Cursor;
//!
//! use acerra_cphd::{Channel, EvenFrequencies, PhaseHistory, ReadOptions, Scene, read_cphd, write_cphd};
//! use acerra_geo::geodesy::{EnuFrame, Geodetic};
//! use num_complex::Complex64;
//!
//! let history = PhaseHistory {
//!     frame: EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0)),
//!     channels: vec![Channel {
//!         name: "flight".to_owned(),
//!         time_s: vec![0.0, 0.02],
//!         position_m: vec![[0.0, -0.02, 8.0], [0.0, 0.02, 8.0]],
//!         frequency: EvenFrequencies { first_hz: 3.1e9, step_hz: 5e6, count: 3 },
//!         spectrum: vec![Complex64::new(0.5, -0.25); 6].into(),
//!         fast_time_s: None,
//!     }],
//!     start: None,
//!     description: Default::default(),
//! };
//! let scene = Scene { middle_m: [5.0, 0.0, 0.0], pixel_m: 0.05, nx: 100, ny: 80 };
//! let mut file = Cursor::new(Vec::new());
//! write_cphd(&mut file, &history, &scene)?;
//! let again = read_cphd(file, &ReadOptions::default())?;
//! let (found, expected) = (&again.history.channels[0], &history.channels[0]);
//! assert_eq!(found.frequency.count, 3);
//! assert!((found.spectrum[4] - expected.spectrum[4]).norm() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod band;
mod document;
mod error;
mod geometry;
mod header;
mod layout;
mod markup;
mod model;
mod pulse;
mod read;
mod signal;
mod vectors;
mod write;

pub use error::{ReadError, WriteError};
pub use layout::{ReadOptions, is_cphd};
pub use model::{Channel, Description, EvenFrequencies, PhaseHistory, SPEED_OF_LIGHT_M_S, Scene};
pub use read::{CphdFile, read_cphd};
pub use write::write_cphd;
