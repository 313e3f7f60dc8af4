//! Stage `clean`: from raw traces to spectra that hold the scene alone.

use acerra_radar::clean::{
    Background as Removal, Gate as FastTimeGate, SurfaceOptions, ZeroTiming as Timing,
    ZeroTimingResult, apply_gate, remove_background, spectrum_at, zero_timing,
};
use acerra_radar::{Radargram, Spectrum};
use anyhow::{Context, bail};

use super::align::Aligned;
use super::read::RadarContent;
use super::warnings::Warnings;
use crate::campaign::{Background, Campaign, Gate, ZeroTiming};

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
/// A stage that refuses its input, with the reason.
pub fn clean(
    campaign: &Campaign,
    content: &RadarContent,
    aligned: &Aligned,
    warnings: &mut Warnings,
) -> anyhow::Result<Cleaned> {
    match content {
        RadarContent::Spectrum(spectrum) => {
            let spectrum = spectrum.select(&aligned.traces)?;
            Ok(Cleaned {
                spectrum,
                traces: None,
            })
        }
        RadarContent::Radargram(radargram) => clean_traces(
            campaign,
            radargram.select(&aligned.traces)?,
            aligned,
            warnings,
        ),
    }
}

fn clean_traces(
    campaign: &Campaign,
    raw: Radargram,
    aligned: &Aligned,
    warnings: &mut Warnings,
) -> anyhow::Result<Cleaned> {
    let height_m = &aligned.height_m;
    let timed = time(campaign, raw, height_m, warnings)?;
    let raw = timed.radargram;

    let removal = match campaign.preprocess.background {
        Background::Mean => Removal::Mean,
        Background::Median => Removal::Median,
        Background::Window { window } => Removal::Sliding { window },
        Background::Components { components } => Removal::Components { components },
        Background::None => Removal::None,
    };
    let mut clean = remove_background(raw.clone(), removal).context("[preprocess] background")?;
    let mut gate_s = None;
    if let Gate::About(gate_ns) = campaign.preprocess.gate_ns {
        let [start_s, end_s] = gate_ns.map(|ns| ns * 1e-9);
        let edge_s = FastTimeGate::default().edge_s.min(0.5 * (end_s - start_s));
        if let Some(trace) = height_m.iter().position(|h| *h <= 0.0) {
            bail!(
                "[preprocess] gate_ns: trace {} stands {:.3} m below the ground, where 2h/c has no \
                 meaning; expected [image] z_m or terrain below the flight, or gate_ns = \"none\"",
                aligned.traces[trace],
                -height_m[trace]
            );
        }
        clean = apply_gate(
            clean,
            height_m,
            &FastTimeGate {
                start_s,
                end_s,
                edge_s,
            },
        )
        .context("[preprocess] gate_ns")?;
        gate_s = Some([start_s, end_s]);
    }
    let spectrum = spectrum_at(&clean, &frequencies_hz(campaign)).context("[image] band_ghz")?;
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
        gate_s,
    };
    Ok(Cleaned {
        spectrum,
        traces: Some(traces),
    })
}

/// Puts fast time to 2R/c.
fn time(
    campaign: &Campaign,
    raw: Radargram,
    height_m: &[f64],
    warnings: &mut Warnings,
) -> anyhow::Result<ZeroTimingResult> {
    let delay_s = campaign.radar.delay_ns.map(|ns| ns * 1e-9);
    let method = match campaign.zero_timing() {
        ZeroTiming::FirstTrace => {
            let mut options = SurfaceOptions::default();
            options.approximate_delay_s = delay_s;
            Timing::FirstTrace(options)
        }
        ZeroTiming::None => delay_s.map_or(Timing::None, Timing::Delay),
        ZeroTiming::Shift { shift_ns } => Timing::Shift(shift_ns * 1e-9 - delay_s.unwrap_or(0.0)),
    };
    let timed = zero_timing(raw, height_m, &method).context(
        "[preprocess] zero_timing (state [radar] delay_ns, or zero_timing = \"none\", where the \
         surface echo cannot be seen)",
    )?;
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

/// The evenly spaced frequencies that a campaign asks for (Hz).
#[must_use]
pub fn frequencies_hz(campaign: &Campaign) -> Vec<f64> {
    let [low, high] = campaign.image.band_ghz.map(|f| f * 1e9);
    let count = campaign.image.frequencies;
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    let step = if count > 1 {
        (high - low) / (count - 1) as f64
    } else {
        0.0
    };
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    (0..count).map(|n| low + n as f64 * step).collect()
}
