//! Data of the page of a positioning run.

use acerra_chain::read::inputs::InputFile;
use acerra_gnss::PpkSolution;

/// Data of the page of a positioning run.
#[derive(Clone, Debug)]
pub struct PpkReport<'a> {
    /// Heading and window title.
    pub title: String,
    /// Version of the program.
    pub version: String,
    /// The run.
    pub solution: &'a PpkSolution,
    /// Least ratio of the second-best to the best set of integers for a fix, as used; none where
    /// ambiguities were not resolved.
    pub ratio_threshold: Option<f64>,
    /// Distance between the positions of the forward and the backward pass, one per epoch of the solution,
    /// NaN where only one pass has a position (m). Empty where the distances were not kept: then the page
    /// shows the distances of those epochs at which the passes disagree.
    pub pass_difference_m: Vec<f64>,
    /// Further remarks, from the readers; those of the run are shown in any case.
    pub warnings: Vec<String>,
    /// Input files.
    pub inputs: Vec<InputFile>,
    /// The options in force, as text.
    pub configuration: String,
}
