//! Findings of a run: what is gathered from the stages, and how it is judged.

pub mod evidence;
pub mod weigh;
