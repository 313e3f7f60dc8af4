//! Delay and phase of each track's instrument, removed before the tracks are imaged together.

use std::f64::consts::TAU;

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::tracks::{
    Calibration, CalibrationOptions as SearchOptions, CommonTarget, Estimate, calibrate_on_target,
};
use acerra_imaging::{
    Complex32, ImagingError, ImagingPlan, PlanOptions, PlaneGrid, Pulses, Spreading, SurfaceGrid,
};
use acerra_radar::Spectrum;
use serde::Serialize;

use crate::align::recording::InstrumentError;
use crate::choices::{CalibrationSource, Weight};
use crate::control::{Cancelled, Control};
use crate::echoes::Echoes;
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;
use crate::scene::Scene;

/// Options of the calibration of tracks against one another.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationOptions {
    /// Source of each track's delay and phase.
    pub source: CalibrationSource,
    /// Largest delay that is searched, to either side (ns).
    pub window_ns: f64,
    /// Position of the target that all tracks see (m); by default the maximum of the first track's image on
    /// which the others agree.
    pub target_m: Option<[f64; 3]>,
    /// Weight of each trace in the images of the search.
    pub weight: Weight,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self {
            source: CalibrationSource::Given,
            window_ns: 3.0,
            target_m: None,
            weight: Weight::Trace,
        }
    }
}

/// Reason for which tracks cannot be calibrated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// A track that the imaging operators refuse.
    #[error("[[track]] {track}: {cause}")]
    Track {
        /// The track.
        track: String,
        /// Reason.
        cause: ImagingError,
    },
    /// No target on which the tracks agree.
    #[error("[tracks] calibration: {0}")]
    Target(ImagingError),
    /// The first track's image is empty.
    #[error("[tracks] calibration: the first track's image is empty")]
    Empty,
    /// The search cannot be imaged.
    #[error(transparent)]
    Imaging(ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<ImagingError> for CalibrationError {
    fn from(error: ImagingError) -> Self {
        match error {
            ImagingError::Cancelled => Self::Cancelled(Cancelled),
            error => Self::Imaging(error),
        }
    }
}

/// Echoes of a track, which the calibration corrects in place.
#[derive(Debug)]
pub(crate) struct TrackEchoes {
    pub name: String,
    pub aligned: Aligned,
    pub spectrum: Spectrum,
    pub calibration: TrackCalibration,
}

/// Delay and phase removed from a track's spectra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TrackCalibration {
    /// Given by the campaign file, in nanoseconds and degrees.
    pub given_delay_ns: f64,
    /// Given by the campaign file.
    pub given_phase_deg: f64,
    /// Further delay and phase relative to the first track, found on a common target.
    pub found: Option<FoundCalibration>,
}

/// Delay and phase found on the common target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FoundCalibration {
    /// Delay, in nanoseconds.
    pub delay_ns: f64,
    /// Standard deviation of the delay, in nanoseconds.
    pub delay_sigma_ns: f64,
    /// Phase at the middle of the band, in degrees.
    pub phase_deg: f64,
    /// Standard deviation of the phase, in degrees.
    pub phase_sigma_deg: f64,
    /// Level of the target over the rest of its profile, in decibels.
    pub contrast_db: f64,
}

impl FoundCalibration {
    fn of(estimate: &Estimate, frequency_hz: &[f64]) -> Self {
        let middle_hz = 0.5 * (frequency_hz[0] + frequency_hz[frequency_hz.len() - 1]);
        let Calibration { delay_s, phase_rad } = estimate.calibration;
        let phase = phase_rad - TAU * middle_hz * delay_s;
        Self {
            delay_ns: delay_s * 1e9,
            delay_sigma_ns: estimate.delay_sigma_s * 1e9,
            phase_deg: (phase - TAU * (phase / TAU).round()).to_degrees(),
            phase_sigma_deg: estimate.phase_sigma_rad.to_degrees(),
            contrast_db: estimate.contrast_db,
        }
    }
}

impl TrackCalibration {
    /// Delay and phase stated for the instrument, before anything is estimated.
    pub(crate) fn given(error: InstrumentError) -> Self {
        Self {
            given_delay_ns: error.delay_ns,
            given_phase_deg: error.phase_deg,
            found: None,
        }
    }
}

/// Removes delay and phase from every track: the stated values, and the values found on a common target.
///
/// # Errors
/// Tracks that see no common target, cancellation.
pub(crate) fn calibrate(
    tracks: &mut [TrackEchoes],
    options: &CalibrationOptions,
    scene: &Scene,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<(), CalibrationError> {
    for track in tracks.iter_mut() {
        let given = Calibration {
            delay_s: track.calibration.given_delay_ns * 1e-9,
            phase_rad: track.calibration.given_phase_deg.to_radians(),
        };
        remove(given, &mut track.spectrum)?;
    }
    // A single track is its own reference.
    if options.source == CalibrationSource::Given || tracks.len() < 2 {
        return Ok(());
    }
    control.check()?;
    let found = common_target(tracks, options, scene, control)?;
    for (track, estimate) in tracks.iter_mut().zip(&found.estimates) {
        let estimated = FoundCalibration::of(estimate, &track.spectrum.frequency_hz);
        if estimated.contrast_db < 10.0 || estimated.delay_ns.abs() > 0.98 * options.window_ns {
            warnings.add(doubt(&track.name, found.position_m, &estimated));
        }
        track.calibration.found = Some(estimated);
        remove(estimate.calibration, &mut track.spectrum)?;
    }
    Ok(())
}

fn remove(calibration: Calibration, spectrum: &mut Spectrum) -> Result<(), ImagingError> {
    if calibration != Calibration::default() {
        calibration.remove(&spectrum.frequency_hz, &mut spectrum.values)?;
    }
    Ok(())
}

fn doubt(track: &str, target_m: [f64; 3], estimated: &FoundCalibration) -> String {
    format!(
        "[[track]] {track}: its calibration is uncertain: the common target at x = {:.2} m, y = {:.2} m is \
         {:.1} dB above the rest, {:+.2} ns from the first track's; state [tracks] target_m, or delay_ns \
         and phase_deg",
        target_m[0], target_m[1], estimated.contrast_db, estimated.delay_ns
    )
}

/// The target on which all tracks agree best, and delay and phase of each track found on the target.
fn common_target(
    tracks: &[TrackEchoes],
    options: &CalibrationOptions,
    scene: &Scene,
    control: &Control<'_>,
) -> Result<CommonTarget, CalibrationError> {
    let echoes = tracks.iter().map(|track| Echoes {
        spectrum: &track.spectrum,
        aligned: &track.aligned,
        light_speed_m_s: scene.light_speed_m_s,
    });
    let weight: Vec<Vec<f64>> = echoes.clone().map(|e| e.weights(options.weight)).collect();
    let pulses: Vec<Pulses<'_>> = echoes
        .zip(&weight)
        .zip(tracks)
        .map(|((echoes, weight), track)| {
            echoes
                .pulses(weight)
                .map_err(|cause| CalibrationError::Track {
                    track: track.name.clone(),
                    cause,
                })
        })
        .collect::<Result<_, _>>()?;
    let (candidates, stated_z_m) = match options.target_m {
        Some(target) => (vec![target], Some(target[2])),
        None => (candidates(&pulses[0], scene, control)?, None),
    };
    let height = |x: f64, y: f64| stated_z_m.unwrap_or_else(|| scene.ground.below_m(x, y));
    let search = SearchOptions {
        window_s: options.window_ns * 1e-9,
        spreading: Spreading::InverseSquare,
    };
    let cancel = control.operation();
    calibrate_on_target(&pulses, &candidates, search, &height, cancel).map_err(
        |error| match error {
            ImagingError::Cancelled => Cancelled.into(),
            error => CalibrationError::Target(error),
        },
    )
}

/// Maxima of a track's image on at most [`PIXELS`] pixels.
fn candidates(
    pulses: &Pulses<'_>,
    scene: &Scene,
    control: &Control<'_>,
) -> Result<Vec<[f64; 3]>, CalibrationError> {
    /// Largest number of pixels of the image in which maxima are searched.
    const PIXELS: f64 = 1e6;
    /// Level relative to the greatest maximum down to which maxima are tried, dB.
    const FLOOR_DB: f64 = -10.0;
    const MOST: usize = 32;
    let ground = &scene.ground;
    let fine = scene.pixels.grid;
    let sides = [fine.nx, fine.ny].map(|n| {
        #[expect(clippy::cast_precision_loss, reason = "a count of pixels")]
        let n = n as f64;
        n * fine.pixel_m
    });
    let grid = PlaneGrid::from_ranges(
        [fine.x0_m, fine.x_m(fine.nx - 1)],
        [fine.y0_m, fine.y_m(fine.ny - 1)],
        ground.below_m(fine.x0_m, fine.y0_m),
        fine.pixel_m.max((sides[0] * sides[1] / PIXELS).sqrt()),
    )?;
    let surface = if ground.is_uneven() {
        let height = |x, y| Ok::<_, ImagingError>(ground.below_m(x, y));
        Some(SurfaceGrid::in_parallel(grid, height)?)
    } else {
        None
    };
    let options = PlanOptions::default()
        .with_accuracy(1e-2)
        .with_check_pixels(16);
    let cancel = control.operation();
    let plan = match &surface {
        Some(surface) => ImagingPlan::with_control(*pulses, surface, &options, cancel),
        None => ImagingPlan::with_control(*pulses, grid, &options, cancel),
    }?;
    let mut image = vec![Complex32::default(); grid.len()];
    plan.run(&mut image, cancel)?;
    let view = ImageView::new(&image, grid)?;
    let maxima = strongest_maxima(&view, FLOOR_DB, MOST);
    if maxima.is_empty() {
        return Err(CalibrationError::Empty);
    }
    Ok(maxima
        .into_iter()
        .map(|[x, y]| [x, y, ground.below_m(x, y)])
        .collect())
}
