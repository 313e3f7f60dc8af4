//! Noise of codes and phases, measured from the log itself.

pub(crate) mod calibration;
pub(crate) mod code_bias;
pub(crate) mod code_noise;
pub(crate) mod correlated;
pub(crate) mod phase_walk;
pub(crate) mod robust_codes;
pub(crate) mod series;
