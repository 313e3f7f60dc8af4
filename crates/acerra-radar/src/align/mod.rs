//! Estimation of the offset between the radar's and the trajectory's clock from the data alone.
//!
//! ```text
//! Radargram ──┬─ echoes ─► height cue ──┐
//!             └─ activity ─► motion cue ┼─► OffsetLikelihood ──decide──► OffsetEstimate
//! FlightProfile (height, speed) ────────┘         ▲              (or a refusal that says why)
//! images scored by the caller ─► sharpness cue ───┘ decide_with
//! ```
//!
//! - *Height*: the fast time of the surface echo against 2h/c. Take-off, climbs, descents and the slow wander
//!   of straight flight all contribute. The delay at which range is zero is estimated together with the
//!   offset.
//! - *Motion*: the radargram changes from trace to trace when the platform moves.
//! - *Sharpness*: images formed at candidate offsets, scored by the caller.
//!
//! Each cue is a log-likelihood over the whole range of offsets, with its noise and the noise's correlation
//! in time estimated from the data. An offset is accepted only if no other offset agrees with the data; a
//! flight at constant height and speed is refused.
//!
//! ```
//! use acerra_radar::align::{FlightProfile, FlightState, OffsetOptions, offset_likelihood};
//! use acerra_radar::{Control, Radargram, Samples, two_way_delay_s};
//! # use std::f64::consts::TAU;
//!
//! // A flight that sways about 5 m, and a radar whose clock is 7.3 s behind.
//! let height = |t: f64| 5.0 + 0.3 * (0.9 * t).sin() + 0.2 * (0.37 * t).cos();
//! let state = |t| Some(FlightState { height_m: height(t), speed_m_s: 1.0 });
//! let profile = FlightProfile::sample([0.0, 60.0], state)?;
//!
//! let time_s: Vec<f64> = (0..400).map(|m| 0.07 * f64::from(m)).collect();
//! let samples = time_s.iter().flat_map(|t| {
//!     let echo_s = 8e-9 + two_way_delay_s(height(t + 7.3));
//!     (0..700).map(move |k| {
//!         let u = (20e-9 + 61e-12 * f64::from(k) - echo_s) / 0.4e-9;
//!         ((-u * u).exp() * (TAU * 3.95 * 0.4 * u).cos()) as f32
//!     })
//! });
//! let radargram = Radargram::new(time_s.clone(), 20e-9, 61e-12, Samples::Real(samples.collect()))?;
//!
//! let likelihood =
//!     offset_likelihood(&radargram, &profile, &OffsetOptions::default(), Control::default())?;
//! let (offset_s, _) = likelihood.total.best();
//! assert!((offset_s - 7.3).abs() < 0.02);
//! // `likelihood.decide()` states the offset with its deviation and the delay, or says why not.
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod activity;
mod curve;
mod echo;
mod error;
mod estimate;
mod height;
mod height_cue;
mod height_fit;
mod mixture;
mod motion;
mod noise;
mod offset;
mod profile;
mod scan;
mod sharpness;
mod surface;

pub use activity::activity;
pub use curve::LikelihoodCurve;
pub use error::AlignError;
pub use estimate::{
    Candidate, ClockPrior, OffsetEstimate, OffsetLikelihood, OffsetOptions, offset_likelihood,
};
pub use height_cue::HeightCue;
pub use motion::MotionCue;
pub use offset::{CoarseOffset, OffsetSearch, coarse_offset};
pub use profile::{FlightProfile, FlightState};
pub use sharpness::SharpnessCue;
