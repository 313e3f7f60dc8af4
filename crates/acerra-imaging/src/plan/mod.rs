//! Plans: from a request (data, pixels, accuracy) to an operator that keeps the accuracy, reports
//! its decisions and runs any number of times.
//!
//! ```text
//! Pulses ──────┐
//! ImageGrid ───┼──► planner ──► engine + PlanReport ──► run
//! PlanOptions ─┘    (error budget, cost, self-check)
//! ```

mod arrangement;
mod band;
mod bins;
mod budget;
mod check;
mod double;
mod estimate;
pub(crate) mod forward;
mod groups;
pub(crate) mod imaging;
mod operator;
pub(crate) mod options;
mod partitions;
mod planner;
pub(crate) mod report;
mod request;
mod sample;
pub(crate) mod slices;
mod trials;

pub use forward::Forward;
pub use imaging::{ImagingPlan, image};
pub use options::{Engine, PlanOptions, SelfCheck};
pub use report::{
    Decision, DirectChoice, DoubleChoice, FactorizedChoice, OperatorKind, PathShares, PlanReport,
    ShorterChoice,
};
pub use trials::{TrialImage, TrialImages};
