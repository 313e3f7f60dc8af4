//! Beat signals of frequency-modulated radars, as spectra.
//!
//! | file | read | holds |
//! | --- | --- | --- |
//! | NPZ | [`read_beat_npz`] | `beat` `[traces, samples]`, real or complex, with `start_frequency_hz`, `slope_hz_per_s`, `sample_rate_hz` |
//! | TOML with raw samples of a DCA1000 | [`read_dca1000`] | `[fmcw]` with `file` and the layout of the samples |

mod dca1000;
mod deramp;
mod npz;
mod settings;

pub use dca1000::read_dca1000;
pub use deramp::{Chirp, deramp};
pub use npz::{is_beat_npz, read_beat_npz};
pub use settings::{FmcwSettings, Layout, is_fmcw_settings};
