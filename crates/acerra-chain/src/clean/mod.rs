//! Stage `clean`: from raw traces to spectra that hold the scene alone.

mod error;
mod options;
mod surface_path;
mod timing;

use std::ops::Range;

use acerra_radar::clean::{
    Background as Removal, Gate as FastTimeGate, SurfaceRemoval, apply_gate, band_pass, dewow,
    remove_background_with, spectrum_at,
};
use acerra_radar::{Control, Radargram, Spectrum};

use crate::choices::{Background, Gate};
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;
use crate::read::RadarContent;
use crate::scene::Scene;
pub(crate) use surface_path::surface_path_m;
use timing::time;
pub(crate) use timing::zero_s;

pub use error::CleanError;
pub use options::{CleanOptions, frequencies_hz};

/// Clean spectra, and the radargrams on the way to them.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// Spectra of the selected traces, fast time zero-timed.
    pub spectrum: Spectrum,
    /// Record of the processing of the traces; absent where the file held spectra.
    pub traces: Option<CleanedTraces>,
}

/// The selected traces before and after cleaning.
#[derive(Clone, Debug)]
pub struct CleanedTraces {
    /// Filtered along fast time and zero-timed, otherwise raw.
    pub raw: Radargram,
    /// Without background, gated.
    pub clean: Radargram,
    /// The lines that the traces are on, one after another.
    pub lines: Vec<Range<usize>>,
    /// Added to fast time (s), by delay and zero-timing together.
    pub shift_s: f64,
    /// Picks of the surface echo, where requested.
    pub surface: Option<Surface>,
    /// Removal of the surface's echo, where that echo was removed.
    pub removal: Option<SurfaceRemoval>,
    /// The gate in force about 2h/c (s).
    pub gate_s: Option<[f64; 2]>,
}

/// The surface echo against the height.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Fast time of the echo after the shift (s); none where the echo was not found.
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
    scene: &Scene,
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
            clean_traces(raw, aligned, scene, options, warnings)
        }
    }
}

fn clean_traces(
    raw: Radargram,
    aligned: &Aligned,
    scene: &Scene,
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<Cleaned, CleanError> {
    let timed = time(filtered(raw, options)?, aligned, options, warnings)?;
    let raw = timed.radargram;
    let removal = match options.background {
        Background::Surface => Some(surface_removal(aligned, scene)?),
        _ => None,
    };
    let lines = aligned.lines(0..raw.traces);
    let clean = without(raw.clone(), options.background, removal.as_ref(), &lines)?;
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
        lines,
        shift_s: timed.shift_s,
        surface,
        removal,
        gate_s: gate.map(|gate| [gate.start_s, gate.end_s]),
    };
    Ok(Cleaned {
        spectrum,
        traces: Some(traces),
    })
}

/// Traces without their running mean and frequencies outside the band, where the options state these filters.
///
/// # Errors
/// A window or a band that the traces do not hold.
pub(crate) fn filtered(
    mut raw: Radargram,
    options: &CleanOptions,
) -> Result<Radargram, CleanError> {
    if let Some(ns) = options.dewow_ns {
        raw = dewow(raw, 1e-9 * ns).map_err(CleanError::Dewow)?;
    }
    if let Some(ghz) = options.band_pass_ghz {
        raw = band_pass(raw, ghz.map(|f| 1e9 * f)).map_err(CleanError::BandPass)?;
    }
    Ok(raw)
}

/// Traces with another background removed, otherwise cleaned as before; `height_m` as in the call
/// before.
pub(crate) fn cleaned_with(
    background: Background,
    traces: &CleanedTraces,
    height_m: &[f64],
) -> Result<Radargram, CleanError> {
    let surface = traces.removal.as_ref();
    let clean = without(traces.raw.clone(), background, surface, &traces.lines)?;
    match traces.gate_s {
        None => Ok(clean),
        Some(about_s) => apply_gate(clean, height_m, &gate_of(about_s)).map_err(CleanError::Gate),
    }
}

/// The removal of a background that depends on the traces alone; none for the surface's echo, whose delay
/// depends on the heights.
pub(crate) const fn removal(background: Background) -> Option<Removal> {
    Some(match background {
        Background::Mean => Removal::Mean,
        Background::Median => Removal::Median,
        Background::Window { window } => Removal::Sliding { window },
        Background::Components { components } => Removal::Components { components },
        Background::None => Removal::None,
        Background::Surface => return None,
    })
}

fn surface_removal(aligned: &Aligned, scene: &Scene) -> Result<SurfaceRemoval, CleanError> {
    let path_m = surface_path_m(aligned, &scene.ground);
    let surface_s: Vec<f64> = path_m.iter().map(|p| p / scene.light_speed_m_s).collect();
    SurfaceRemoval::new(&surface_s).map_err(CleanError::Background)
}

/// Traces without their background; the mean where the echo of the surface has no removal.
fn without(
    raw: Radargram,
    background: Background,
    surface: Option<&SurfaceRemoval>,
    lines: &[Range<usize>],
) -> Result<Radargram, CleanError> {
    match (removal(background), surface) {
        (None, Some(surface)) => surface.remove(raw, Control::default()),
        (own, _) => remove_background_with(raw, own.unwrap_or_default(), lines, Control::default()),
    }
    .map_err(CleanError::Background)
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
