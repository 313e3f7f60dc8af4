//! Radar imaging by the adjoint of the scattering operator.
//!
//! This crate computes an image of a scene from the spectra and positions of a moving antenna, by Eq. (3) of
//! Catapano et al. 2020: σ̃(r) = Σ_m w_m Σ_n E(m, n) e^{+j4πf_n R_m/c} / R_m². The error relative to that sum
//! in double precision stays below a stated accuracy, on planes, tilted planes, uneven ground and volumes,
//! along any trajectory. The transposed operator models echoes of an image; [`metrics`] measures targets,
//! [`psf`] and [`resolution`] predict the resolution of a flight, and [`sensitivity`] the effect of
//! positioning errors on an image.
//!
//! ```text
//! PulseArrays ──► Pulses ──────┐                          ┌──► image ──► ImageView ──► Measurement
//! PlaneGrid, TiltedGrid, ──► ImageGrid ──► ImagingPlan ───┤
//! SurfaceGrid                  │                │         └──► PlanReport, SelfCheck
//! PlanOptions ─────────────────┘                │
//! Control (cancel, progress) ───────────────────┘
//!
//! image ──► Forward ──► spectra          (flight, band) ──► PointSpread ──► Analysis
//! ```
//!
//! ```
//! use acerra_imaging::reference::{self, Scatterer};
//! use acerra_imaging::{
//!     Complex32, Complex64, Control, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses,
//!     SPEED_OF_LIGHT_M_S, Spreading,
//! };
//! // A track along y, 5 m up, and the echoes of one target.
//! let position_m: Vec<[f64; 3]> = (0..101).map(|m| [0.0, 0.03 * f64::from(m) - 1.5, 5.0]).collect();
//! let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
//! let target = Scatterer { position_m: [2.0, 0.2, 0.0], reflectivity: Complex64::ONE };
//! let (c, spreading) = (SPEED_OF_LIGHT_M_S, Spreading::InverseSquare);
//! let spectrum = reference::forward(&position_m, &frequency_hz, &[target], c, spreading)?;
//! let pulses = Pulses::new(PulseArrays {
//!     position_m: &position_m,
//!     frequency_hz: &frequency_hz,
//!     spectrum: &spectrum,
//!     weight: &[1.0; 101],
//!     light_speed_m_s: c,
//! })?;
//!
//! let grid = PlaneGrid::from_ranges([1.0, 3.0], [-0.8, 1.2], 0.0, 0.02)?;
//! let plan = ImagingPlan::new(pulses, grid, &PlanOptions::default().with_accuracy(1e-3))?;
//! let mut image = vec![Complex32::ZERO; plan.pixels()];
//! plan.run(&mut image, Control::default())?;
//! let peak = (0..image.len()).max_by(|a, b| image[*a].norm().total_cmp(&image[*b].norm()));
//! let [x_m, y_m, _] = grid.point_m(peak.unwrap_or(0));
//! assert!((x_m - 2.0).abs() < 0.03 && (y_m - 0.2).abs() < 0.03);
//! # Ok::<(), acerra_imaging::ImagingError>(())
//! ```
//!
//! Conventions: SI units; `[x, y, z]` = `[east, north, up]` in metres; images are row-major
//! `[rows, columns]`; signals vary as e^{jωt}, so an echo from range R has phase e^{−j4πfR/c}. The
//! double-precision sums of [`reference`](mod@reference) are the standard of every faster path.

pub mod error;

mod checks;
mod control;
pub mod delay_sums;
mod engine;
pub mod grid;
mod incidence;
mod kernel;
pub mod live;
pub mod looks;
pub mod metrics;
pub mod plan;
pub mod psf;
pub mod pulses;
pub mod refraction;
pub mod resolution;
mod sampling;
pub mod sensitivity;
pub mod tracks;
mod vector;
pub mod volume;

pub use acerra_control::{Control, Progress};
pub use engine::reference;
pub use error::ImagingError;
pub use grid::{ImageGrid, PlaneGrid, SurfaceGrid, TiltedGrid, VolumeGrid};
pub use incidence::IncidenceWeight;
pub use kernel::level::SimdLevel;
pub use live::LiveImage;
pub use num_complex::{Complex32, Complex64};
pub use plan::{
    Engine, Forward, ImagingPlan, PlanOptions, PlanReport, SelfCheck, TrialImage, TrialImages,
    image,
};
pub use pulses::{PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading};
pub use volume::{ForwardVolume, VolumeRun, image_volume, image_volume_planned_once};
