//! Blur of an image by positioning errors: loss of peak, shift and widening.
//!
//! [`predict`] computes the blur by theory, [`simulate`] by Monte Carlo with confidence intervals, for errors
//! that are independent at every pulse, drift slowly, or both ([`ErrorModel`]).
//!
//! | figure | by theory | given |
//! | --- | --- | --- |
//! | loss at the target's place | double sum of Gaussian coherences | always: it is exact |
//! | loss at the peak, widening | double sum about the least-squares shift | while focused |
//! | shift | least squares, plus the peak's motion in its own speckle, to first order | while focused, coherence of 3 dB |
//!
//! Focused means that the power about the shifted place is 10 dB above the power of random phases, and that
//! its coherent part is no less than 6 dB below the rest.

pub(crate) mod criteria;
pub(crate) mod geometry;
pub(crate) mod model;
pub(crate) mod monte_carlo;
pub(crate) mod nodes;
pub(crate) mod normal;
pub(crate) mod theory;

pub use model::ErrorModel;
pub use monte_carlo::{Estimate, MonteCarlo, Simulated, simulate};
pub use theory::{Blur, predict};
