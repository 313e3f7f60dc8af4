//! Calibration of the delay alone, from a radar at rest before a reflector at a measured range.

use acerra_radar::{Radargram, Samples};

use super::echo::{Crest, Profiles, median};
use super::error::CalibrateError;

/// Known quantities of a radar at rest.
#[derive(Clone, Copy, Debug)]
pub struct AtRest {
    /// Range of the reflector from the antennas' phase centre (m).
    pub range_m: f64,
    /// Standard deviation of that range (m).
    pub range_sigma_m: f64,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
    /// Band of the pulse (Hz).
    pub band_hz: [f64; 2],
}

/// The delay found at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestDelay {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Standard deviation, the range's included (s).
    pub sigma_s: f64,
    /// The echo above the median of the mean trace (dB).
    pub contrast_db: f64,
    /// Whether the direct coupling of the antennas was seen at the time that the delay predicts: an
    /// independent confirmation.
    pub coupling_seen: bool,
    /// Traces that show the echo.
    pub traces: usize,
}

/// Delays tried (s).
const DELAY_S: [f64; 2] = [-20e-9, 20e-9];
/// Arrival of the direct coupling after range zero (s): antennas up to 0.6 m apart, and the largest shift of
/// the crest by ringing.
const COUPLING_S: [f64; 2] = [-0.5e-9, 2.5e-9];
/// Contrast needed of echo and coupling (dB).
const NEEDED_DB: f64 = 12.0;

/// Finds the delay from traces of a radar at rest.
///
/// The strongest echo counts as the direct coupling where another echo follows at the stated range, else as
/// the reflector's.
///
/// # Errors
/// No echo at that range, a band that the samples do not hold.
pub fn delay_at_rest(radargram: &Radargram, rest: &AtRest) -> Result<RestDelay, CalibrateError> {
    let mean = Profiles::new(&mean_trace(radargram)?, rest.band_hz);
    let echo_s = 2.0 * rest.range_m / rest.light_speed_m_s;
    let [start_s, end_s] = mean.span_s();
    let (from_s, to_s) = (
        (echo_s + DELAY_S[0]).max(start_s),
        (echo_s + DELAY_S[1]).min(end_s),
    );
    let strongest = highest(&mean, start_s, end_s);
    let behind = strongest.and_then(|coupling| {
        let expected_s = coupling.fast_time_s + echo_s;
        let found = highest(
            &mean,
            expected_s - COUPLING_S[1],
            expected_s - COUPLING_S[0],
        );
        found.filter(|crest| decibels(crest) >= NEEDED_DB)
    });
    let echo = behind.or_else(|| highest(&mean, from_s, to_s));
    let contrast_db = echo.as_ref().map_or(0.0, decibels);
    let echo = echo
        .filter(|_| contrast_db >= NEEDED_DB)
        .ok_or(CalibrateError::NothingAtRange {
            range_m: rest.range_m,
            contrast_db,
            needed_db: NEEDED_DB,
        })?;
    let (picked_s, scatter_s, traces) = over_traces(radargram, rest.band_hz, echo.fast_time_s);
    let delay_s = picked_s - echo_s;
    let coupling = highest(&mean, delay_s + COUPLING_S[0], delay_s + COUPLING_S[1]);
    Ok(RestDelay {
        delay_s,
        sigma_s: scatter_s.hypot(2.0 * rest.range_sigma_m / rest.light_speed_m_s),
        contrast_db,
        coupling_seen: coupling.is_some_and(|crest| decibels(&crest) >= NEEDED_DB),
        traces,
    })
}

fn decibels(crest: &Crest) -> f64 {
    20.0 * crest.contrast.log10()
}

fn highest(profiles: &Profiles, from_s: f64, to_s: f64) -> Option<Crest> {
    let [start_s, end_s] = profiles.span_s();
    // A crest needs neighbours: three samples within the record.
    let margin_s = 3.0 * profiles.step_s();
    let (from_s, to_s) = (from_s.max(start_s + margin_s), to_s.min(end_s - margin_s));
    let middle_s = 0.5 * (from_s + to_s);
    profiles.crest(0, middle_s, 0.5 * (to_s - from_s))
}

/// Median fast time of the echo over the traces, the deviation of the median, and the number of traces that
/// show the echo.
fn over_traces(radargram: &Radargram, band_hz: [f64; 2], about_s: f64) -> (f64, f64, usize) {
    const HALF_WIDTH_S: f64 = 0.5e-9;
    let profiles = Profiles::new(radargram, band_hz);
    let found: Vec<f64> = (0..radargram.traces)
        .filter_map(|trace| profiles.crest(trace, about_s, HALF_WIDTH_S))
        .map(|crest| crest.fast_time_s)
        .collect();
    if found.is_empty() {
        return (about_s, radargram.fast_time_step_s, 0);
    }
    let middle_s = median(found.iter().copied());
    let spread_s = 1.4826 * median(found.iter().map(|t| (t - middle_s).abs()));
    // The median of n values scatters by √(π/2n) of theirs.
    let count = found.len() as f64;
    let scatter_s = spread_s * (std::f64::consts::FRAC_PI_2 / count).sqrt();
    (middle_s, scatter_s, found.len())
}

/// The mean of all traces.
fn mean_trace(radargram: &Radargram) -> Result<Radargram, CalibrateError> {
    let n = radargram.samples_per_trace;
    let mut sum = vec![num_complex::Complex64::default(); n];
    for trace in 0..radargram.traces {
        for (s, v) in sum.iter_mut().zip(radargram.trace(trace)) {
            *s += v / radargram.traces as f64;
        }
    }
    let samples = if radargram.samples.is_complex() {
        Samples::Complex(
            sum.iter()
                .map(|z| num_complex::Complex32::new(z.re as f32, z.im as f32))
                .collect(),
        )
    } else {
        Samples::Real(sum.iter().map(|z| z.re as f32).collect())
    };
    Radargram::new(
        vec![radargram.time_s.first().copied().unwrap_or(0.0)],
        radargram.fast_time_start_s,
        radargram.fast_time_step_s,
        samples,
    )
    .map_err(|cause| CalibrateError::Clean {
        track: "1".to_owned(),
        cause: cause.into(),
    })
}
