//! The processing chain as a library: from raw logs, or arrays in memory, to focused and measured images. The
//! library writes no file and prints nothing.
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
//! - Each stage is a separate function with its own parameters: [`read`], [`position`], [`align`], [`clean`],
//!   [`focus`], [`measure`].
//! - A survey is a list of one or more tracks. [`Survey::prepare`] takes them from files, [`prepare()`] from
//!   memory; [`Prepared::image`] images the prepared survey on any pixels.
//! - [`Control`] follows and cancels a run. [`Journal`] keeps cost and remarks of the stages, also when a
//!   later stage fails.
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
pub mod autofocus;
pub mod calibrate;
pub mod campaign;
pub mod choices;
pub mod clean;
pub mod control;
pub mod echoes;
mod error;
pub mod findings;
pub mod focus;
pub mod journal;
pub mod look;
pub mod measure;
pub mod position;
mod prepare;
pub mod read;
pub mod scene;
mod side_by_side;
pub mod soil;
mod survey;

pub use align::recording::{Recording, TrackOptions};
pub use control::{Cancelled, Control, Progress};
pub use error::ChainError;
pub use focus::sink::{ImageSink, MemorySink};
pub use focus::{FocusOptions, Focused, ImageRequest};
pub use journal::Journal;
pub use journal::warnings::Warnings;
pub use prepare::{Prepared, Track, prepare, prepare_as_stated};
pub use read::phase_history::PhaseHistoryError;
pub use read::trace_positions::TracePositions;
pub use scene::Scene;
pub use scene::pixels::Pixels;
pub use survey::{Survey, TrackSource};
