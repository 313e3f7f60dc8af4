//! Positioning of a rover log against a base log: preparation, passes, alternative settings, diagnosis.

pub(crate) mod alternatives;
pub(crate) mod attempt;
pub(crate) mod both_passes;
pub(crate) mod diagnose;
pub(crate) mod preparation;
pub(crate) mod process;
