//! The clock offset found from the data alone: by height and motion over all offsets at which the
//! logs overlap, then by the sharpness of images about those that agree.

use std::ops::Range;

use acerra_geo::trajectory::Trajectory;
use acerra_imaging::{Complex32, ImagingError, PlaneGrid};
use acerra_radar::align::{
    AlignError as Undecided, FlightProfile, FlightState, OffsetEstimate, OffsetLikelihood,
    OffsetOptions, offset_likelihood,
};
use acerra_radar::{Radargram, Spectrum};

use crate::align::{AlignError, AlignOptions, Aligned, Flight, align, interpolator};
use crate::choices::Select;
use crate::clean::{CleanError, CleanOptions, clean};
use crate::control::{Cancelled, Control};
use crate::echoes::quick_look;
use crate::ground::Scene;
use crate::pixels::Pixels;
use crate::warnings::Warnings;

/// A score over the offsets tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Offsets (s), rising.
    pub offset_s: Vec<f64>,
    /// Scores.
    pub score: Vec<f64>,
}

/// How an offset was found.
#[derive(Clone, Debug)]
pub struct OffsetSearch {
    /// The offset with its standard deviation, its closest rival, and the delay that comes with it.
    pub estimate: OffsetEstimate,
    /// What height and motion say of every offset.
    pub likelihood: OffsetLikelihood,
    /// Sharpness of the images that were tried.
    pub sharpness: Curve,
}

/// Longest trajectory that is searched (s).
const LONGEST_S: f64 = 1e6;
/// Spacing of the offsets at which images are tried (s): 2 cm at 2 m/s.
const SHARPNESS_STEP_S: f64 = 0.01;
/// Images that are tried at most.
const SHARPNESS_IMAGES: usize = 100;
/// Pixels of each.
const SHARPNESS_PIXELS: f64 = 60_000.0;
/// Sub-apertures whose images are scored one by one: their scatter gives the offset's own.
const SUB_APERTURES: usize = 4;
/// Traces below which an aperture is not divided.
const LEAST_TRACES: usize = 40;
/// Offsets further than this from where the traces were cleaned are cleaned anew (s).
const CLEANED_ANEW_S: f64 = 0.25;

/// Why the clock offset cannot be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OffsetError {
    /// The trajectory is too long to be searched.
    #[error(
        "[trajectory] time_offset_s = \"auto\": expected a trajectory of less than {LONGEST_S:.0} s, \
         found {found_s:.0} s"
    )]
    TooLong {
        /// Its length (s).
        found_s: f64,
    },
    /// The data do not tell the offset, or tell several.
    #[error("[trajectory] time_offset_s = \"auto\": {0}")]
    Undecided(#[from] Undecided),
    /// No trace can be placed at an offset that is tried.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The traces of the search cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// The images of the search cannot be made.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What height and motion say of every offset at which radar log and trajectory overlap.
///
/// # Errors
/// Logs that never overlap enough, a radargram in which nothing follows the flight, cancellation.
pub fn by_height_and_motion(
    radargram: &Radargram,
    trajectory: &Trajectory,
    scene: &Scene,
    max_gap_s: Option<f64>,
    control: &Control<'_>,
) -> Result<OffsetLikelihood, OffsetError> {
    let span_s = [trajectory.start_s(), trajectory.end_s()];
    let length_s = span_s[1] - span_s[0];
    if length_s.is_nan() || length_s >= LONGEST_S {
        return Err(OffsetError::TooLong { found_s: length_s });
    }
    let at = interpolator(max_gap_s, trajectory);
    let half_s = 0.05_f64.max(trajectory.sample_interval_s().unwrap_or(0.1));
    let profile = FlightProfile::sample(span_s, |t| {
        let [before, now, after] = [t - half_s, t, t + half_s].map(|t| at.at(t));
        let covered = [before, now, after].iter().all(|p| p.flag.is_covered());
        let [x, y, z] = now.position_m;
        let moved: f64 = (0..3)
            .map(|i| (after.position_m[i] - before.position_m[i]).powi(2))
            .sum();
        covered.then(|| FlightState {
            height_m: z - scene.ground.below_m(x, y),
            speed_m_s: moved.sqrt() / (2.0 * half_s),
        })
    })?;
    let options = OffsetOptions::default();
    let control = control.for_radar();
    Ok(offset_likelihood(radargram, &profile, &options, control)?)
}

/// How the traces of a track are placed and cleaned while offsets are tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// The track.
    pub flight: Flight<'a>,
    /// How its traces are placed.
    pub align: &'a AlignOptions,
    /// How they are cleaned.
    pub clean: &'a CleanOptions,
}

/// Among the offsets that height and motion leave, the one with the sharpest images.
///
/// # Errors
/// Two offsets that remain, data that cannot be imaged, cancellation.
pub fn refine(
    trial: Trial<'_>,
    likelihood: OffsetLikelihood,
    control: &Control<'_>,
) -> Result<OffsetSearch, OffsetError> {
    let grid = coarse_grid(&trial.flight.scene.pixels)?;
    control.start("align", SHARPNESS_IMAGES as u64);
    let mut sharpness = Vec::new();
    let mut cleaned: Option<CleanedAt> = None;
    let estimate = likelihood.decide_with(SHARPNESS_STEP_S, SHARPNESS_IMAGES, |offset_s| {
        control.check()?;
        if !cleaned
            .as_ref()
            .is_some_and(|c| (c.offset_s - offset_s).abs() < CLEANED_ANEW_S)
        {
            cleaned = trial.cleaned_at(offset_s)?;
        }
        let scores = match &cleaned {
            Some(cleaned) => trial.contrasts_at(cleaned, offset_s, grid)?,
            None => Vec::new(),
        };
        if !scores.is_empty() {
            let mean = scores.iter().sum::<f64>() / scores.len() as f64;
            sharpness.push((offset_s, mean));
            control.at(sharpness.len() as u64);
        }
        Ok::<_, OffsetError>(scores)
    })?;
    control.finish();
    sharpness.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (offset_s, score) = sharpness.into_iter().unzip();
    Ok(OffsetSearch {
        estimate,
        likelihood,
        sharpness: Curve { offset_s, score },
    })
}

/// Traces cleaned where an offset puts them.
struct CleanedAt {
    offset_s: f64,
    aligned: Aligned,
    spectrum: Spectrum,
}

impl Trial<'_> {
    /// The traces cleaned at an offset; none where no trace has a place or no surface is seen.
    fn cleaned_at(&self, offset_s: f64) -> Result<Option<CleanedAt>, OffsetError> {
        // Warnings are given once, at the offset finally taken.
        let unsaid = &mut Warnings::default();
        let Ok(aligned) = align(self.flight, self.align, offset_s, unsaid) else {
            return Ok(None);
        };
        let Ok(cleaned) = clean(self.flight.radar, &aligned, self.clean, unsaid) else {
            return Ok(None);
        };
        Ok(Some(CleanedAt {
            offset_s,
            aligned,
            spectrum: cleaned.spectrum,
        }))
    }

    /// Contrast of the image of each sub-aperture at an offset; none where a trace of the echoes has
    /// no place then.
    fn contrasts_at(
        &self,
        cleaned: &CleanedAt,
        offset_s: f64,
        grid: PlaneGrid,
    ) -> Result<Vec<f64>, OffsetError> {
        // The same traces at every offset: what changes is where they stand.
        let everywhere = AlignOptions {
            select: Select::All,
            ..self.align.clone()
        };
        let unsaid = &mut Warnings::default();
        let all = align(self.flight, &everywhere, offset_s, unsaid)?;
        let position_of = |trace: &usize| {
            let at = all.traces.binary_search(trace).ok()?;
            Some(all.position_m[at])
        };
        let places: Option<Vec<[f64; 3]>> =
            cleaned.aligned.traces.iter().map(position_of).collect();
        let Some(places) = places else {
            return Ok(Vec::new());
        };
        let light_speed_m_s = self.flight.scene.light_speed_m_s;
        sub_apertures(places.len())
            .map(|part| {
                let spectrum = part_of(&cleaned.spectrum, part.clone());
                let image = quick_look(&places[part], &spectrum, grid, light_speed_m_s)?;
                Ok(contrast(&image))
            })
            .collect()
    }
}

/// Consecutive parts of an aperture.
fn sub_apertures(traces: usize) -> impl Iterator<Item = Range<usize>> {
    let parts = if traces >= SUB_APERTURES * LEAST_TRACES {
        SUB_APERTURES
    } else {
        1
    };
    (0..parts).map(move |k| k * traces / parts..(k + 1) * traces / parts)
}

/// The spectra of some of the traces.
fn part_of(spectrum: &Spectrum, part: Range<usize>) -> Spectrum {
    let width = spectrum.frequency_hz.len();
    Spectrum {
        time_s: spectrum.time_s[part.clone()].to_vec(),
        frequency_hz: spectrum.frequency_hz.clone(),
        values: spectrum.values[part.start * width..part.end * width].to_vec(),
    }
}

/// The image's rectangle with few enough pixels to image it many times.
fn coarse_grid(pixels: &Pixels) -> Result<PlaneGrid, ImagingError> {
    let fine = &pixels.grid;
    let x_m = [fine.x0_m, fine.x_m(fine.nx - 1)];
    let y_m = [fine.y0_m, fine.y_m(fine.ny - 1)];
    let area_m2 = (x_m[1] - x_m[0] + fine.pixel_m) * (y_m[1] - y_m[0] + fine.pixel_m);
    let pixel_m = fine.pixel_m.max((area_m2 / SHARPNESS_PIXELS).sqrt());
    PlaneGrid::from_ranges(x_m, y_m, pixels.middle_m(), pixel_m)
}

/// The brightest pixel's modulus over the median one's; 1 for an image of zeros.
fn contrast(image: &[Complex32]) -> f64 {
    let mut power: Vec<f32> = image.iter().map(|value| value.norm_sqr()).collect();
    let middle = power.len() / 2;
    if power.is_empty() {
        return 1.0;
    }
    let (_, median, above) = power.select_nth_unstable_by(middle, f32::total_cmp);
    let brightest = above.iter().copied().fold(*median, f32::max);
    if *median > 0.0 {
        f64::from(brightest / *median).sqrt()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_is_the_peak_over_the_median() {
        let mut image = vec![Complex32::new(0.0, 2.0); 101];
        assert!((contrast(&image) - 1.0).abs() < 1e-6);
        image[3] = Complex32::new(-6.0, 8.0);
        assert!((contrast(&image) - 5.0).abs() < 1e-6);
        assert!((contrast(&[]) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn sub_apertures_cover_every_trace_once() {
        for traces in [1, 39, 160, 331] {
            let parts: Vec<_> = sub_apertures(traces).collect();
            assert_eq!(parts[0].start, 0);
            assert_eq!(parts[parts.len() - 1].end, traces);
            assert!(parts.windows(2).all(|w| w[0].end == w[1].start));
        }
    }
}
