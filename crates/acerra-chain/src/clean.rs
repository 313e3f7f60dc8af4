//! Stage `clean`: from raw traces to spectra that hold the scene alone.

use acerra_radar::clean::{
    Background as Removal, CleanError as Refused, Gate as FastTimeGate, SurfaceOptions,
    ZeroTiming as Timing, ZeroTimingResult, apply_gate, remove_background, spectrum_at,
    zero_timing,
};
use acerra_radar::{Radargram, RadargramError, Spectrum};

use crate::align::Aligned;
use crate::choices::{Background, Delay, Gate, ZeroTiming};
use crate::read::RadarContent;
use crate::warnings::Warnings;

/// Parameters of the stage `clean`.
#[derive(Clone, Debug)]
pub struct CleanOptions {
    /// Fast time at which range is zero, when calibrated (ns).
    pub delay_ns: Option<Delay>,
    /// How the fast time at which range is zero is found.
    pub zero_timing: ZeroTiming,
    /// What is subtracted from every trace.
    pub background: Background,
    /// The part of each trace that is kept.
    pub gate_ns: Gate,
    /// Evenly spaced frequencies of the spectra (Hz).
    pub frequency_hz: Vec<f64>,
}

impl Default for CleanOptions {
    /// The paper's: zero-timing by the first trace, the mean as background, a gate about 2h/c, 341
    /// frequencies over 3.1 to 4.8 GHz.
    fn default() -> Self {
        Self {
            delay_ns: None,
            zero_timing: ZeroTiming::default(),
            background: Background::default(),
            gate_ns: Gate::default(),
            frequency_hz: frequencies_hz([3.1, 4.8], 341),
        }
    }
}

impl CleanOptions {
    /// For traces that are clean already and whose fast time is 2R/c: spectra alone.
    #[must_use]
    pub fn none() -> Self {
        Self {
            zero_timing: ZeroTiming::None,
            background: Background::None,
            gate_ns: Gate::None,
            ..Self::default()
        }
    }

    /// Whether the fast time at which range is zero is stated, rather than found from the surface
    /// echo.
    #[must_use]
    pub fn is_calibrated(&self) -> bool {
        if self.delay_ns == Some(Delay::Auto) {
            return false;
        }
        match self.zero_timing {
            ZeroTiming::FirstTrace => false,
            ZeroTiming::None | ZeroTiming::Shift { .. } => true,
        }
    }
}

/// Why traces cannot be cleaned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CleanError {
    /// A trace number beyond the log.
    #[error(transparent)]
    Traces(#[from] RadargramError),
    /// Zero-timing fails.
    #[error(
        "[preprocess] zero_timing (state [radar] delay_ns, or zero_timing = \"none\", where the \
         surface echo cannot be seen): {0}"
    )]
    ZeroTiming(Refused),
    /// The background cannot be removed.
    #[error("[preprocess] background: {0}")]
    Background(Refused),
    /// A trace stands below the ground, where the gate has no meaning.
    #[error(
        "[preprocess] gate_ns: trace {trace} stands {depth_m:.3} m below the ground, where 2h/c has \
         no meaning; expected [image] z_m or terrain below the flight, or gate_ns = \"none\""
    )]
    BelowGround {
        /// Number of the trace in the log.
        trace: usize,
        /// How far below (m).
        depth_m: f64,
    },
    /// The gate cannot be applied.
    #[error("[preprocess] gate_ns: {0}")]
    Gate(Refused),
    /// The spectra cannot be had at these frequencies.
    #[error("[image] band_ghz: {0}")]
    Band(Refused),
}

/// Clean spectra, and the radargrams on the way to them.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// Spectra of the selected traces, fast time zero-timed.
    pub spectrum: Spectrum,
    /// What happened to the traces; absent where the file brought spectra.
    pub traces: Option<CleanedTraces>,
}

/// The selected traces before and after cleaning.
#[derive(Clone, Debug)]
pub struct CleanedTraces {
    /// Zero-timed, otherwise raw.
    pub raw: Radargram,
    /// Without background, gated.
    pub clean: Radargram,
    /// Added to fast time (s), by delay and zero-timing together.
    pub shift_s: f64,
    /// Picks of the surface echo, where they were wanted.
    pub surface: Option<Surface>,
    /// The gate in force about 2h/c (s).
    pub gate_s: Option<[f64; 2]>,
}

/// The surface echo against the height.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Fast time of the echo after the shift (s); none where it was not found.
    pub fast_time_s: Vec<Option<f64>>,
    /// Median of the echo less 2h/c (s).
    pub median_residual_s: Option<f64>,
    /// Median distance from that median (s).
    pub spread_s: Option<f64>,
    /// Level of the echo above everything else that was tried (dB).
    pub contrast_db: f64,
}

/// Cleans the selected traces; spectra that the file brought pass as they are.
///
/// # Errors
/// A step that refuses its input, with the reason.
pub fn clean(
    content: &RadarContent,
    aligned: &Aligned,
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<Cleaned, CleanError> {
    match content {
        RadarContent::Spectrum(spectrum) => Ok(Cleaned {
            spectrum: spectrum.select(&aligned.traces)?,
            traces: None,
        }),
        RadarContent::Radargram(radargram) => {
            let raw = radargram.select(&aligned.traces)?;
            clean_traces(raw, aligned, options, warnings)
        }
    }
}

fn clean_traces(
    raw: Radargram,
    aligned: &Aligned,
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<Cleaned, CleanError> {
    let timed = time(raw, &aligned.height_m, options, warnings)?;
    let raw = timed.radargram;
    let clean = remove_background(raw.clone(), removal(options.background))
        .map_err(CleanError::Background)?;
    // Before the gate is settled, a view below the flight is assumed.
    let is_above = aligned.height_m.iter().all(|h| *h > 0.0);
    let gate = match options.gate_ns {
        Gate::Auto if !is_above => None,
        choice => gate(choice),
    };
    let clean = match &gate {
        None => clean,
        Some(gate) => gated(clean, aligned, gate)?,
    };
    let spectrum = spectrum_at(&clean, &options.frequency_hz).map_err(CleanError::Band)?;
    let surface = timed.surface.map(|track| Surface {
        fast_time_s: track
            .picks
            .iter()
            .map(|pick| pick.as_ref().map(|p| p.fast_time_s + timed.shift_s))
            .collect(),
        median_residual_s: timed.median_residual_s,
        spread_s: timed.spread_s,
        contrast_db: track.contrast_db,
    });
    let traces = CleanedTraces {
        raw,
        clean,
        shift_s: timed.shift_s,
        surface,
        gate_s: gate.map(|gate| [gate.start_s, gate.end_s]),
    };
    Ok(Cleaned {
        spectrum,
        traces: Some(traces),
    })
}

/// The same traces with another background removed, otherwise cleaned alike; `height_m` as they were.
pub(crate) fn cleaned_with(
    background: Background,
    traces: &CleanedTraces,
    height_m: &[f64],
) -> Result<Radargram, CleanError> {
    let clean = remove_background(traces.raw.clone(), removal(background))
        .map_err(CleanError::Background)?;
    match traces.gate_s {
        None => Ok(clean),
        Some(about_s) => apply_gate(clean, height_m, &gate_of(about_s)).map_err(CleanError::Gate),
    }
}

pub(crate) fn removal(background: Background) -> Removal {
    match background {
        Background::Mean => Removal::Mean,
        Background::Median => Removal::Median,
        Background::Window { window } => Removal::Sliding { window },
        Background::Components { components } => Removal::Components { components },
        Background::None => Removal::None,
    }
}

fn gate(choice: Gate) -> Option<FastTimeGate> {
    Some(gate_of(choice.about_ns()?.map(|ns| ns * 1e-9)))
}

fn gate_of([start_s, end_s]: [f64; 2]) -> FastTimeGate {
    FastTimeGate {
        start_s,
        end_s,
        edge_s: FastTimeGate::default().edge_s.min(0.5 * (end_s - start_s)),
    }
}

fn gated(
    clean: Radargram,
    aligned: &Aligned,
    gate: &FastTimeGate,
) -> Result<Radargram, CleanError> {
    let height_m = &aligned.height_m;
    if let Some(trace) = height_m.iter().position(|h| *h <= 0.0) {
        return Err(CleanError::BelowGround {
            trace: aligned.traces[trace],
            depth_m: -height_m[trace],
        });
    }
    apply_gate(clean, height_m, gate).map_err(CleanError::Gate)
}

/// Puts fast time to 2R/c.
fn time(
    raw: Radargram,
    height_m: &[f64],
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<ZeroTimingResult, CleanError> {
    let given_ns = options.delay_ns.and_then(Delay::given_ns);
    let delay_s = given_ns.map(|ns| ns * 1e-9);
    let method = match options.zero_timing {
        ZeroTiming::FirstTrace => {
            let mut options = SurfaceOptions::default();
            options.approximate_delay_s = delay_s;
            match height_m.first() {
                Some(first_m) if *first_m <= 0.0 => {
                    warnings.add(format!(
                        "zero-timing by the median of all traces: the first stands {:.2} m below the ground of the \
                         image ([trajectory] origin_deg_m, [image] z_m)",
                        -first_m
                    ));
                    Timing::AllTraces(options)
                }
                _ => Timing::FirstTrace(options),
            }
        }
        ZeroTiming::None => delay_s.map_or(Timing::None, Timing::Delay),
        ZeroTiming::Shift { shift_ns } => Timing::Shift(shift_ns * 1e-9 - delay_s.unwrap_or(0.0)),
    };
    let timed = zero_timing(raw, height_m, &method).map_err(CleanError::ZeroTiming)?;
    if let Some(residual_s) = timed.median_residual_s
        && residual_s.abs() > 0.3e-9
    {
        warnings.add(format!(
            "the surface echo lies {:+.2} ns from 2h/c in the median of the traces: zero-timing, \
             heights or the image plane are off by {:.0} mm",
            residual_s * 1e9,
            residual_s.abs() * 0.15e12
        ));
    }
    Ok(timed)
}

/// `count` evenly spaced frequencies over a band, both ends included (Hz).
#[must_use]
pub fn frequencies_hz(band_ghz: [f64; 2], count: usize) -> Vec<f64> {
    let [low, high] = band_ghz.map(|f| f * 1e9);
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    let step = if count > 1 {
        (high - low) / (count - 1) as f64
    } else {
        0.0
    };
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    (0..count).map(|n| low + n as f64 * step).collect()
}
