//! Inversion: the scene that explains the data, instead of the adjoint's image of them.
//!
//! ```text
//! Pulses ──► Flight (weights √w) ──┬─► SceneOperator (fast) ─┐
//!                                  └─► PointOperator (f64)  ─┴─► Weighted (even columns)
//!                                                                  │ LinearOperator
//!   measure_noise ──► λ, δ ──►  solve_spectral │ cgls │ solve_sparse │ clean + restore
//!                                                                  │
//!                                               scene, History ──► point_response (resolution)
//! ```
//!
//! - [`solve_spectral`]: truncated SVD, and Tikhonov with its parameter by discrepancy or L-curve, from one
//!   Golub–Kahan–Lanczos bidiagonalisation with reorthogonalisation.
//! - [`cgls`](cgls()): conjugate gradients for least squares, in the memory of two scenes.
//! - [`solve_sparse`]: FISTA, complex ℓ1, or group-sparse over tracks.
//! - [`clean`](clean()): CLEAN with the true, place-dependent point spread.
//! - [`point_response`]: a method's response to a single point: its resolution operator there.
//!
//! Every solver knows the operator by its action alone. The weights of the pulses enter as their square
//! roots on both sides ([`Flight`]), so that L⁺ of the weighted data is the image of Eq. (3) of Catapano
//! et al. 2020 and forward and adjoint are a pair under plain inner products.

pub mod bidiagonal;
pub mod cgls;
pub mod clean;
pub mod columns;
mod error;
mod flight;
pub mod history;
mod noise;
mod operator;
pub mod parameter;
mod points;
pub mod projected;
mod relief;
mod resolution;
mod restore;
mod scene;
pub mod sparse;
pub mod spectral;
mod vector;
mod weighted;

pub use cgls::{CglsOptions, CglsSolution, cgls};
pub use clean::{CleanInput, CleanOptions, CleanSolution, Component, clean};
pub use columns::even_weights;
pub use error::InvertError;
pub use flight::Flight;
pub use history::{History, Iteration, Stop};
pub use noise::{NoiseLevel, measure_noise};
pub use operator::LinearOperator;
pub use parameter::ParameterChoice;
pub use points::PointOperator;
pub use resolution::{PointResponse, point_response};
pub use restore::restore;
pub use scene::{Ground, SceneOperator};
pub use sparse::{
    SparseOptions, SparseSolution, TrackData, greatest_lambda, solve_sparse, sparse_bytes,
};
pub use spectral::{Regularization, SpectralOptions, SpectralSolution, solve_spectral};
pub use weighted::Weighted;
