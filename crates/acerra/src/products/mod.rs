//! What a run leaves behind: files, and how they get there.

mod cuts;
pub mod deliver;
pub mod image_npz;
pub mod inputs;
pub mod pictures;
mod report_data;
pub mod run_json;
pub mod stack_npz;
pub mod stages;
pub mod staging;
