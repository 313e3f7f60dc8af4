//! The processing chain as a library: from raw logs, or arrays in memory, to focused and measured
//! images. It writes no file and prints nothing.
//!
//! ```text
//! Campaign ──survey()──► Survey ──read, position──► [Recording] + Scene
//!  (TOML)                (files)                        │ prepare: align, clean, calibrate
//!                                                       ▼
//!                   ImageRequest ──────────────►  Prepared ──measure──► Measurement
//!                   (pixels, looks)                     │ image, any number of times
//!                                                       ▼
//!                   ImageSink ◄──looks, slices──    Focused
//! ```
//!
//! - Each stage is a function of its own with the parameters it uses: [`read`], [`position`],
//!   [`align`], [`clean`], [`focus`], [`measure`].
//! - A survey is a list of one or more tracks. [`Survey::prepare`] takes them from files,
//!   [`prepare()`] from memory; [`Prepared::image`] images what was prepared on any pixels.
//! - [`Control`] follows and cancels a run. [`Journal`] keeps what the stages cost and noticed, also
//!   when a later stage fails.
//! - [`ImageSink`] receives looks and volume slices one by one.
//!
//! ```
//! use acerra_chain::{Control, ImageRequest, Journal, MemorySink, campaign::Campaign};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let campaign = Campaign::parse(
//!     "[radar]\nfile = 'no-such-flight.npz'\n[image]\nx_m = [0, 1]\ny_m = [-1, 1]\n",
//! )?;
//! let (mut journal, control) = (Journal::default(), Control::default());
//! match campaign.survey().prepare(&mut journal, &control) {
//!     Ok(prepared) => {
//!         let request = ImageRequest::on(prepared.scene.pixels.clone());
//!         let focused = prepared.image(&request, &mut MemorySink::default(), &control)?;
//!         println!("{} pixels", focused.image.len());
//!     }
//!     // The message names the file; what was noticed until then is in the journal.
//!     Err(error) => assert!(error.to_string().starts_with("no-such-flight.npz: ")),
//! }
//! # Ok(())
//! # }
//! ```

pub mod align;
pub mod attitude_file;
pub mod autofocus;
pub mod boresight;
pub mod calibrate;
pub mod calibration;
pub mod campaign;
pub mod choices;
pub mod clean;
pub mod clock;
pub mod clock_shift;
pub mod control;
mod correction;
pub mod delay;
pub mod echoes;
mod elevation;
mod error;
pub mod evidence;
pub mod focus;
pub mod gate;
pub mod ground;
mod height_noise;
mod history;
pub mod inputs;
pub mod inversion;
mod journal;
pub mod looks;
pub mod measure;
pub mod memory;
pub mod offset;
mod path_text;
mod phase_history;
pub mod pixels;
pub mod plane;
pub mod position;
pub mod positioning;
mod prepare;
mod quantity;
pub mod radar_height;
pub mod read;
pub mod recording;
pub mod select;
pub mod sharpen;
pub mod sink;
pub mod space;
pub mod stages;
mod survey;
pub mod tiles;
mod trace_positions;
pub mod trajectory_file;
mod uncovered;
pub mod volume;
mod warnings;
pub mod weigh;
mod window;

pub use control::{Cancelled, Control, Progress};
pub use error::ChainError;
pub use focus::{FocusOptions, Focused, ImageRequest};
pub use ground::Scene;
pub use journal::Journal;
pub use phase_history::PhaseHistoryError;
pub use pixels::Pixels;
pub use prepare::{Prepared, Track, prepare, prepare_as_stated};
pub use recording::{Recording, TrackOptions};
pub use sink::{ImageSink, MemorySink};
pub use survey::{Survey, TrackSource};
pub use trace_positions::TracePositions;
pub use warnings::Warnings;
