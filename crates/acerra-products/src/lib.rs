//! Products of a run: files, and their publication.
//!
//! ```text
//! campaign file ──run_campaign──► Outcome ──deliver──► image.npz, pictures, maps, run.json, report.html
//!                     │
//!                     └─ looks, slices ──NpzSink──► looks.npz, volume.npz
//! ```

pub mod calibration;
mod correction;
mod cuts;
pub mod data;
pub mod deliver;
pub mod display;
mod failure;
pub mod image_npz;
mod maps;
pub mod names;
pub mod outcome;
pub mod pictures;
mod plain;
mod process;
mod provenance;
pub mod report;
mod report_data;
mod run;
pub mod run_record;
mod soil;
mod space;
pub mod stack_npz;
pub mod staging;
mod survey_check;
pub mod surveyed;
pub mod tiles;
pub mod traces;
mod uncertainty;

pub use failure::failure_text;
pub use outcome::Outcome;
pub use plain::{PlainWriter, plain_text};
pub use process::{NamedCampaign, RunError, process};
pub use run::{RunRequest, Wanted, run_campaign, run_campaign_with};
pub use tiles::{Share, TilesMade, make_tiles, merge_tiles};
