//! From the raw radargram to spectra: filters along fast time, zero-timing, background removal, gating, transform.
//!
//! Each stage is a pure function from one [`Radargram`](crate::Radargram) to the next. Heights are one number
//! a trace, m; sums are formed in double precision. Stages that can take long on thousands of traces have a
//! variant that can be cancelled (`…_with` a [`Control`](crate::Control)).

mod background;
mod background_gain;
mod components;
mod envelope;
mod filter;
mod gate;
mod surface;
mod surface_removal;
mod transform;
mod zero_timing;

use thiserror::Error;

use acerra_control::Cancelled;

pub use background::{Background, UnknownBackground, remove_background, remove_background_with};
pub use background_gain::BackgroundGain;
pub use envelope::{envelope, for_analytic_rows};
pub(crate) use envelope::{envelopes_about_mean, mean_trace};
pub use filter::{band_pass, dewow};
pub use gate::{Gate, apply_gate};
pub(crate) use surface::crest;
pub use surface::{SurfaceOptions, SurfacePick, SurfaceTrack, crests_near, track_surface};
pub use surface_removal::SurfaceRemoval;
pub use transform::{spectrum_at, spectrum_at_with, spectrum_by_direct_sum};
pub use zero_timing::{ZeroTiming, ZeroTimingResult, zero_timing};

/// Errors of the processing stages.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CleanError {
    /// Not one height a trace.
    #[error("expected one height for each of {traces} traces, found {heights}")]
    Heights {
        /// Traces there are.
        traces: usize,
        /// Heights given.
        heights: usize,
    },
    /// A height that the stage needs is not a positive number.
    #[error("height of trace {trace} must be a positive number of metres, found {height_m}")]
    Height {
        /// The trace.
        trace: usize,
        /// Height, m.
        height_m: f64,
    },
    /// Background removal would leave no signal.
    #[error("background removal by {method} needs at least {needed} traces, found {traces}")]
    TooFewTraces {
        /// The method.
        method: &'static str,
        /// Traces it needs.
        needed: usize,
        /// Traces there are.
        traces: usize,
    },
    /// A sliding window that is too short.
    #[error("a sliding window must hold at least 3 traces, found {window}")]
    Window {
        /// Traces in the window.
        window: usize,
    },
    /// The number of components is zero or equal to the number of traces.
    #[error("principal components to remove must be 1 to {most}, found {components}")]
    Components {
        /// Number found.
        components: usize,
        /// Largest number possible.
        most: usize,
    },
    /// A gate that is not an interval, or whose edges overlap.
    #[error(
        "a gate must end after it starts and its edges fit in it: [{start_s:e}, {end_s:e}] s, edges of {edge_s:e} s"
    )]
    Gate {
        /// Start about the surface, s.
        start_s: f64,
        /// End about the surface, s.
        end_s: f64,
        /// Length of an edge, s.
        edge_s: f64,
    },
    /// A window of fast time that is shorter than three samples.
    #[error(
        "a window of fast time must hold at least 3 samples, {step_s:e} s apart, found {window_s:e} s"
    )]
    DewowWindow {
        /// Window, s.
        window_s: f64,
        /// Sample spacing, s.
        step_s: f64,
    },
    /// A band that is empty, or that exceeds the frequencies of the samples.
    #[error(
        "expected a band of rising frequencies within 0 to {limit_hz:e} Hz, the range of the samples, found \
         {} to {} Hz", band_hz[0], band_hz[1]
    )]
    PassBand {
        /// Band found, Hz.
        band_hz: [f64; 2],
        /// Limit, Hz.
        limit_hz: f64,
    },
    /// A frequency outside the range of the samples.
    #[error(
        "frequency {frequency_hz} Hz is outside what samples every {step_s:e} s hold (below {limit_hz} Hz)"
    )]
    Frequency {
        /// Frequency wanted, Hz.
        frequency_hz: f64,
        /// Sample spacing, s.
        step_s: f64,
        /// Limit, Hz.
        limit_hz: f64,
    },
    /// The record ends before, or begins after, the times at which the surface is expected.
    #[error(
        "no surface echo to be expected in the window: fast time {window_start_s:e} to \
         {window_end_s:e} s, surface expected within {expected_start_s:e} to {expected_end_s:e} s"
    )]
    SurfaceOutside {
        /// First fast time recorded, s.
        window_start_s: f64,
        /// Last fast time recorded, s.
        window_end_s: f64,
        /// Earliest fast time of the surface, s.
        expected_start_s: f64,
        /// Latest fast time of the surface, s.
        expected_end_s: f64,
    },
    /// No echo that follows the height is clear enough.
    #[error(
        "no surface echo found: the best stack along 2h/c is {contrast_db:.1} dB above the median, at least \
         {needed_db:.1} dB are needed; give the delay instead"
    )]
    NoSurface {
        /// Contrast found, dB.
        contrast_db: f64,
        /// Contrast needed, dB.
        needed_db: f64,
    },
    /// A time to the surface that is not finite.
    #[error("the time to the surface must be finite in every trace, found none in trace {trace}")]
    SurfaceTime {
        /// The trace.
        trace: usize,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn check_heights(traces: usize, height_m: &[f64]) -> Result<(), CleanError> {
    if height_m.len() == traces {
        Ok(())
    } else {
        Err(CleanError::Heights {
            traces,
            heights: height_m.len(),
        })
    }
}
