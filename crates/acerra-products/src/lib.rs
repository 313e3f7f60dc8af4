//! What a run leaves behind: files, and how they get there.

mod cuts;
pub mod deliver;
pub mod image_npz;
pub mod names;
pub mod pictures;
pub mod report;
mod report_data;
pub mod run_json;
