//! Cleaning and imaging with changed settings.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use acerra_chain::campaign::Campaign;
use acerra_chain::focus::inversion::Method;
use acerra_chain::{
    Control, Journal, MemorySink, Pixels, Prepared, Recording, Scene, prepare_as_stated,
};
use acerra_imaging::{ImagingError, PlaneGrid, SurfaceGrid};
use num_complex::Complex32;
use serde::{Deserialize, Serialize};

use crate::engine::coherence::coherence;
use crate::engine::edits::Edits;
use crate::engine::place::checked_place;
use crate::engine::radargram::TrackRadargram;
use crate::error::RequestError;

/// Pixels of an image's self-check: fewer than a run's, as the image is needed at once.
const CHECK_PIXELS: usize = 32;

/// Largest number of pixels of one image.
const MOST_PIXELS: usize = 4_000_000;

/// The pixels that are in view.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// East of the first pixel's centre (m).
    pub x0_m: f64,
    /// North of the first pixel's centre (m).
    pub y0_m: f64,
    /// Side of a pixel (m).
    pub pixel_m: f64,
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
    /// Height of a horizontal slice (m); the ground of the run by default.
    #[serde(default)]
    pub z_m: Option<f64>,
}

impl View {
    /// The pixels, on the ground of the run or on the requested slice.
    ///
    /// # Errors
    /// A view without pixels, of too many, or at an impossible place.
    pub fn pixels(&self, scene: &Scene) -> Result<Pixels, RequestError> {
        let count = self.nx.checked_mul(self.ny);
        if !count.is_some_and(|n| (1..=MOST_PIXELS).contains(&n)) {
            return Err(RequestError::Invalid {
                what: "view",
                expected: format!("1 to {MOST_PIXELS} pixels"),
                found: format!("{} × {}", self.nx, self.ny),
            });
        }
        let [x0_m, y0_m, _] = checked_place([self.x0_m, self.y0_m, self.z_m.unwrap_or(0.0)])?;
        let ground_m = scene.ground.below_m(x0_m, y0_m);
        let origin_m = [x0_m, y0_m, self.z_m.unwrap_or(ground_m)];
        let grid = PlaneGrid::new(origin_m, self.pixel_m, [self.nx, self.ny])?;
        if self.z_m.is_some() || !scene.ground.is_uneven() {
            return Ok(Pixels::plane(grid));
        }
        let height = |x_m, y_m| Ok::<f64, ImagingError>(scene.ground.below_m(x_m, y_m));
        Ok(Pixels::surface(SurfaceGrid::in_parallel(grid, height)?))
    }
}

/// An image asked for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageOrder {
    /// Pixels.
    pub view: View,
    /// Changes to the run's settings.
    #[serde(default)]
    pub edits: Edits,
    /// First and last pulse to image, counted over all tracks; all by default.
    #[serde(default)]
    pub pulses: Option<[usize; 2]>,
    /// Whether the coherence of the images of their first and second half is computed instead.
    #[serde(default)]
    pub coherence: bool,
}

/// An image made.
#[derive(Debug)]
pub struct Made {
    /// Row-major, row 0 at the smallest y.
    pub values: Vec<Complex32>,
    /// Largest level (dB against amplitude 1); none of an image without values.
    pub maximum_db: Option<f64>,
    /// Pulses in it.
    pub pulses: usize,
    /// Time of cleaning (ms); 0 where cleaned data were reused.
    pub cleaning_ms: f64,
    /// What imaging took (ms).
    pub imaging_ms: f64,
    /// The settings' number: radargrams of another are out of date.
    pub revision: u64,
}

/// The data of a run, cleaned with certain settings.
#[derive(Debug)]
pub struct Current {
    /// The changes to the run's settings.
    pub edits: Edits,
    /// The settings.
    pub campaign: Campaign,
    /// The data.
    pub prepared: Prepared,
    /// Levels of each track's radargrams.
    pub radargrams: Vec<Option<TrackRadargram>>,
    /// Counts the settings tried; 0 for those of the run.
    pub revision: u64,
}

/// The logs of a run in memory.
#[derive(Debug)]
pub(super) struct Workbench {
    /// The data as the run had them.
    base: Arc<Current>,
    scene: Scene,
    recordings: Mutex<Vec<Recording>>,
    current: Mutex<Arc<Current>>,
    /// Settings tried so far.
    tried: AtomicU64,
}

impl Workbench {
    /// Reads, positions and cleans the logs as the run did.
    pub fn open(campaign: Campaign, control: &Control<'_>) -> Result<Self, RequestError> {
        let survey = campaign.survey();
        let mut journal = Journal::default();
        let (recordings, scene) = survey.recordings(&mut journal, control)?;
        let warnings = &mut journal.warnings;
        let prepared = prepare_as_stated(
            &recordings,
            scene.clone(),
            &survey.calibration,
            warnings,
            control,
        )?;
        let prepared = corrected(prepared, &campaign, control)?;
        let base = Arc::new(Current::new(Edits::default(), campaign, prepared, 0));
        Ok(Self {
            current: Mutex::new(Arc::clone(&base)),
            base,
            scene,
            recordings: Mutex::new(recordings),
            tried: AtomicU64::new(0),
        })
    }

    /// The data with the settings tried last.
    pub fn current(&self) -> Arc<Current> {
        let current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(&current)
    }

    /// The campaign with changes.
    pub fn campaign(&self, edits: &Edits) -> Result<Campaign, RequestError> {
        if *edits == Edits::default() {
            return Ok(self.base.campaign.clone());
        }
        edits.apply(&self.base.campaign, &self.base.prepared.tracks)
    }

    /// The data with changes: cleaned again unless they are those at hand.
    fn with(&self, edits: &Edits, control: &Control<'_>) -> Result<Arc<Current>, RequestError> {
        let mut recordings = self
            .recordings
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        // Whoever waited finds a newer request in its place.
        control.check().map_err(|_| RequestError::Superseded)?;
        let current = self.current();
        if current.edits == *edits {
            return Ok(current);
        }
        let made = if *edits == Edits::default() {
            Arc::clone(&self.base)
        } else {
            let campaign = self.campaign(edits)?;
            let survey = campaign.survey();
            for (recording, source) in recordings.iter_mut().zip(&survey.tracks) {
                recording.options = source.options.clone();
            }
            let scene = self.scene_of(&campaign);
            let warnings = &mut acerra_chain::Warnings::default();
            let calibration = &survey.calibration;
            let prepared = prepare_as_stated(&recordings, scene, calibration, warnings, control)?;
            let prepared = corrected(prepared, &campaign, control)?;
            let revision = 1 + self.tried.fetch_add(1, Ordering::Relaxed);
            Arc::new(Current::new(*edits, campaign, prepared, revision))
        };
        *self.current.lock().unwrap_or_else(PoisonError::into_inner) = Arc::clone(&made);
        Ok(made)
    }

    /// The scene with a campaign's height and speed.
    fn scene_of(&self, campaign: &Campaign) -> Scene {
        let is_plane = self.scene.pixels.surface.is_none() && self.scene.pixels.volume.is_none();
        let mut scene = if is_plane {
            self.scene.on_ground(campaign.image.base_z_m())
        } else {
            self.scene.clone()
        };
        scene.light_speed_m_s = campaign.image.light_speed_m_s;
        scene
    }

    /// Makes an image.
    pub fn image(&self, order: &ImageOrder, control: &Control<'_>) -> Result<Made, RequestError> {
        // An inversion solves for all pixels together: a part of them alone would have another solution.
        let method = self.base.campaign.image.method;
        if method != Method::Adjoint {
            return Err(RequestError::Invalid {
                what: "[image] method",
                expected: "adjoint: only its images are made again here".to_owned(),
                found: method.name().to_owned(),
            });
        }
        let start = Instant::now();
        let current = self.with(&order.edits, control)?;
        let cleaning_ms = milliseconds(start);
        let start = Instant::now();
        let pixels = order.view.pixels(&current.prepared.scene)?;
        let count = current.prepared.aligned.traces.len();
        let wanted = order
            .pulses
            .map_or(Ok(0..count), |ends| range(ends, count))?;
        let pulses = wanted.len();
        let values = if order.coherence {
            let [first, second] = halves(wanted)?;
            let columns = order.view.nx;
            let first = current.image(pixels.clone(), first, control)?;
            coherence(&first, &current.image(pixels, second, control)?, columns)
        } else {
            current.image(pixels, wanted, control)?
        };
        let power = values.iter().map(Complex32::norm_sqr);
        let greatest = power.filter(|p| p.is_finite()).fold(0.0, f32::max);
        Ok(Made {
            maximum_db: (greatest > 0.0).then(|| 10.0 * f64::from(greatest).log10()),
            values,
            pulses,
            cleaning_ms,
            imaging_ms: milliseconds(start),
            revision: current.revision,
        })
    }
}

/// The data with their positions corrected, where the campaign has an autofocus.
fn corrected(
    mut prepared: Prepared,
    campaign: &Campaign,
    control: &Control<'_>,
) -> Result<Prepared, RequestError> {
    if campaign.autofocus.enabled {
        prepared.autofocus(&campaign.autofocus_options(), control)?;
    }
    Ok(prepared)
}

impl Current {
    fn new(edits: Edits, campaign: Campaign, prepared: Prepared, revision: u64) -> Self {
        let radargrams = prepared.tracks.iter().map(TrackRadargram::of).collect();
        Self {
            edits,
            campaign,
            prepared,
            radargrams,
            revision,
        }
    }

    /// The image of a part of the pulses.
    fn image(
        &self,
        pixels: Pixels,
        pulses: Range<usize>,
        control: &Control<'_>,
    ) -> Result<Vec<Complex32>, RequestError> {
        let mut request = self.campaign.image_request(pixels).of_pulses(pulses);
        request.looks = None;
        request.options.check_pixels = CHECK_PIXELS;
        let sink = &mut MemorySink::default();
        Ok(self.prepared.image(&request, sink, control)?.image)
    }
}

/// Two halves of the pulses.
fn halves(pulses: Range<usize>) -> Result<[Range<usize>; 2], RequestError> {
    let middle = pulses.start + pulses.len() / 2;
    if pulses.len() < 2 {
        return Err(RequestError::Invalid {
            what: "coherence",
            expected: "two pulses or more".to_owned(),
            found: pulses.len().to_string(),
        });
    }
    Ok([pulses.start..middle, middle..pulses.end])
}

/// The pulses from a first to a last one, of so many.
fn range([first, last]: [usize; 2], count: usize) -> Result<Range<usize>, RequestError> {
    if first <= last && last < count {
        return Ok(first..last + 1);
    }
    Err(RequestError::Invalid {
        what: "pulses",
        expected: format!("[first, last] within 0 to {}", count.saturating_sub(1)),
        found: format!("[{first}, {last}]"),
    })
}

fn milliseconds(since: Instant) -> f64 {
    1e3 * since.elapsed().as_secs_f64()
}
