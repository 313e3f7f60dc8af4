//! List of the targets of an image.

use super::candidates::{Candidate, local_maxima};
use super::crest::climb_crest;
use super::explain::{Explanation, Verdict};
use super::field::Field;
use super::ghost::{GhostWindow, find_ghost};
use super::image::{ImageView, InterpolatedImage};
use super::options::MeasureOptions;
use super::shape::measure_shape;
use super::statistics::ImageStatistics;
use super::surroundings::{Surroundings, highest_by_chance};
use super::target::Target;
use super::track::LocalTrack;
use crate::error::ImagingError;
use crate::psf::cell::Cell;
use crate::psf::spread::PointSpread;
use crate::pulses::Pulses;
use acerra_control::Control;

/// Targets and levels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Targets, strongest first.
    pub targets: Vec<Target>,
    /// Levels of the image as a whole.
    pub statistics: ImageStatistics,
    /// Local maxima above the threshold.
    pub maxima: usize,
    /// Number of maxima at the level of the clutter about them.
    pub clutter: usize,
    /// Number of maxima explained as sidelobes of a target.
    pub sidelobes: usize,
    /// Number of maxima explained as ghosts.
    pub ghosts: usize,
    /// Number of maxima that were not examined: beyond [`MeasureOptions::max_targets`], beyond the 1024
    /// strongest, or beyond the time that the image itself takes.
    pub skipped: usize,
}

/// Local maxima beyond this many, strongest first, are not examined.
const MAX_CANDIDATES: usize = 1024;
/// Two partners whose amplitudes differ by less than this cannot be separated.
const AMBIGUOUS: f64 = 0.01;

/// Finds the targets of an image and measures each: place, level, resolution, sidelobes, ghost.
///
/// Maxima no higher than the highest expected maximum of the surrounding clutter are neither targets nor
/// sidelobes nor ghosts; levels count from the strongest of the other maxima.
///
/// Local maxima are taken strongest first, as in CLEAN. Each one that becomes a target is given the response
/// that Eq. (5) predicts for this flight and band (`spread`); later maxima that do not exceed the prediction
/// by [`MeasureOptions::sidelobe_margin`] are its sidelobes, or its ghost where they are across the local
/// track. Of two partners mirrored at the track the weaker is therefore the ghost; where they are equal
/// within 1 %, as for a straight track, the ghost is the one to the right of the flight.
///
/// The time is limited to about the time of imaging the pixels: once the predictions have taken as long, the
/// remaining maxima are counted as [`Measurement::skipped`].
///
/// A ghost's level is the strongest pixel value about the mirrored place, including any other target at that
/// place.
///
/// # Errors
/// [`ImagingError::OutOfRange`] for options out of range; cancellation.
///
/// ```
/// use acerra_imaging::metrics::{ImageView, MeasureOptions, measure_targets};
/// use acerra_imaging::{Control, PlaneGrid, psf::PointSpread};
/// use num_complex::Complex32;
/// let track: Vec<[f64; 3]> = (0..121).map(|m| [-0.6 + 0.01 * m as f64, 0.0, 2.0]).collect();
/// let frequency_hz: Vec<f64> = (0..69).map(|n| 3.1e9 + 25e6 * n as f64).collect();
/// let spread = PointSpread::new(track, None, frequency_hz, 3e8)?;
/// let image: Vec<Complex32> = (0..81 * 81)
///     .map(|k| {
///         let at = [-0.4 + 0.01 * (k % 81) as f64, 0.6 + 0.01 * (k / 81) as f64, 0.0];
///         let v = spread.response([0.012, 1.0, 0.0], at);
///         Complex32::new(v.re as f32, v.im as f32)
///     })
///     .collect();
/// let grid = PlaneGrid::new([-0.4, 0.6, 0.0], 0.01, [81, 81])?;
/// let view = ImageView::new(&image, grid)?;
/// let found = measure_targets(&view, &spread, &MeasureOptions::default(), Control::default())?;
/// assert_eq!(found.targets.len(), 1);
/// assert!((found.targets[0].x_m - 0.012).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure_targets(
    image: &ImageView<'_>,
    spread: &PointSpread,
    options: &MeasureOptions,
    control: Control,
) -> Result<Measurement, ImagingError> {
    measure(image, spread, None, (options, control))
}

/// As [`measure_targets`] for an image of `pulses`, whose echoes show how far positioning errors have blurred
/// each target: maxima that the phases of the echoes at a target's range predict are no separate targets.
/// Predictions by echoes are not used where the echoes vary in amplitude, as the echoes of several targets in
/// one range cell do.
///
/// # Errors
/// As [`measure_targets`].
pub fn measure_targets_in(
    image: &ImageView<'_>,
    pulses: &Pulses<'_>,
    options: &MeasureOptions,
    control: Control,
) -> Result<Measurement, ImagingError> {
    let spread = PointSpread::of(pulses);
    measure(image, &spread, Some(pulses), (options, control))
}

fn measure(
    image: &ImageView<'_>,
    spread: &PointSpread,
    pulses: Option<&Pulses<'_>>,
    (options, control): (&MeasureOptions, Control),
) -> Result<Measurement, ImagingError> {
    options.check()?;
    let statistics = ImageStatistics::of(image);
    let (mut candidates, clutter) = maxima_above_clutter(image, spread, options, &statistics);
    let maxima = candidates.len() + clutter;
    candidates.truncate(MAX_CANDIDATES);
    let mut found = Measurement {
        targets: vec![],
        statistics,
        maxima,
        clutter,
        sidelobes: 0,
        ghosts: 0,
        skipped: 0,
    };

    let mut search = Search {
        image,
        spread,
        explanation: Explanation::new(image, spread, pulses, options.sidelobe_margin),
        done: vec![false; candidates.len()],
        candidates,
    };
    while let Some(next) = search.next_unexplained(&mut found, control)? {
        if found.targets.len() == options.max_targets {
            break;
        }
        let chosen = search.left_of_equal_partners(next);
        match search.accept(chosen) {
            Some(target) if search.is_listed(&found.targets, &target) => found.sidelobes += 1,
            Some(target) => found.targets.push(target),
            None => {}
        }
    }
    found.skipped = maxima - clutter - found.targets.len() - found.sidelobes - found.ghosts;
    let strongest = found
        .targets
        .iter()
        .map(|t| t.level_db)
        .fold(f64::NEG_INFINITY, f64::max);
    for target in &mut found.targets {
        target.level_db -= strongest;
    }
    found
        .targets
        .sort_by(|a, b| b.level_db.total_cmp(&a.level_db));
    Ok(found)
}

/// The local maxima above the clutter of their surroundings, strongest first, down to the threshold below the
/// strongest; and the number of maxima above the threshold that do not exceed their clutter.
fn maxima_above_clutter(
    image: &ImageView<'_>,
    spread: &PointSpread,
    options: &MeasureOptions,
    statistics: &ImageStatistics,
) -> (Vec<Candidate>, usize) {
    let ratio = 10f64.powf(options.threshold_db / 20.0);
    // The median of the image is no target, however weak the targets are.
    let all = local_maxima(image, statistics.median.max(1e-6 * statistics.maximum));
    let Some(cell) = cell_in_the_middle(image, spread) else {
        return (all, 0);
    };
    let cell_m = [cell.along_m, cell.across_m];
    let surroundings = Surroundings::of(image, cell_m, spread.position_m());
    let stands_out = |c: &Candidate| options.clutter || surroundings.is_exceeded([c.ix, c.iy]);
    if statistics.maximum <= highest_by_chance(image, cell_m) {
        return (Vec::new(), all.len());
    }
    let strongest = all.iter().find(|c| stands_out(c)).map(|c| c.amplitude);
    let Some(strongest) = strongest else {
        return (Vec::new(), 0);
    };
    let above: Vec<Candidate> = all
        .into_iter()
        .take_while(|c| c.amplitude >= ratio * strongest)
        .collect();
    let count = above.len();
    let kept: Vec<Candidate> = above.into_iter().filter(stands_out).collect();
    let clutter = count - kept.len();
    (kept, clutter)
}

/// The resolution cell in the middle of an image.
fn cell_in_the_middle(image: &ImageView<'_>, spread: &PointSpread) -> Option<Cell> {
    let grid = image.grid();
    let [x_m, y_m] = image.centre_m(grid.nx / 2, grid.ny / 2);
    let point = [x_m, y_m, image.z_m(x_m, y_m)];
    let track = LocalTrack::at(spread.position_m(), point)?;
    Some(Cell::expected(spread, &track, point))
}

/// The maxima not yet explained.
struct Search<'a> {
    image: &'a ImageView<'a>,
    spread: &'a PointSpread,
    explanation: Explanation<'a>,
    candidates: Vec<Candidate>,
    done: Vec<bool>,
}

impl Search<'_> {
    /// The strongest maximum that the targets found so far do not explain; `None` without one, or once the
    /// time is used up.
    fn next_unexplained(
        &mut self,
        found: &mut Measurement,
        control: Control,
    ) -> Result<Option<usize>, ImagingError> {
        for k in 0..self.candidates.len() {
            if self.done[k] {
                continue;
            }
            let verdict = self
                .explanation
                .of(&self.candidates[k..], &self.done[k..], control)?;
            match verdict {
                Verdict::Unexplained => return Ok(Some(k)),
                Verdict::OutOfTime => return Ok(None),
                Verdict::Ghost => found.ghosts += 1,
                Verdict::Sidelobe => found.sidelobes += 1,
            }
            self.done[k] = true;
        }
        Ok(None)
    }

    fn place_m(&self, k: usize) -> [f64; 2] {
        self.image
            .centre_m(self.candidates[k].ix, self.candidates[k].iy)
    }

    fn surroundings(&self, at_m: [f64; 2]) -> Option<(LocalTrack, Cell)> {
        let point = [at_m[0], at_m[1], self.image.z_m(at_m[0], at_m[1])];
        let track = LocalTrack::at(self.spread.position_m(), point)?;
        Some((track, Cell::expected(self.spread, &track, point)))
    }

    fn left_of_equal_partners(&self, k: usize) -> usize {
        let here = self.place_m(k);
        let Some((track, cell)) = self.surroundings(here) else {
            return k;
        };
        if track.offset_m >= 0.0 {
            return k;
        }
        let Some(window) = GhostWindow::of(&track, here, cell) else {
            return k;
        };
        let enough = (1.0 - AMBIGUOUS) * self.candidates[k].amplitude;
        (k + 1..self.candidates.len())
            .take_while(|j| self.candidates[*j].amplitude >= enough)
            .find(|j| !self.done[*j] && window.contains(self.place_m(*j)))
            .unwrap_or(k)
    }

    /// Whether a target was found already: the same peak within half a cell.
    fn is_listed(&self, targets: &[Target], new: &Target) -> bool {
        let Some((track, cell)) = self.surroundings([new.x_m, new.y_m]) else {
            return false;
        };
        targets.iter().any(|old| {
            let off = [new.x_m - old.x_m, new.y_m - old.y_m];
            let on = |axis: [f64; 2]| (off[0] * axis[0] + off[1] * axis[1]).abs();
            on([track.tangent[0], track.tangent[1]]) < 0.5 * cell.along_m
                && on(track.left()) < 0.5 * cell.across_m
        })
    }

    fn accept(&mut self, k: usize) -> Option<Target> {
        self.done[k] = true;
        let start = self.place_m(k);
        let field = InterpolatedImage::about(*self.image, start);
        let (track, cell) = self.surroundings(start)?;
        let step_m = self.image.grid().pixel_m;
        let (peak_m, amplitude) = climb_crest(&field, start, step_m, track.tangent, cell)?;
        let (track, cell) = self.surroundings(peak_m)?;
        let shape = measure_shape(&field, &track, peak_m, cell)?;
        let window = GhostWindow::of(&track, peak_m, cell);
        let ghost = window.and_then(|w| {
            let across = InterpolatedImage::about(*self.image, w.centre_m());
            find_ghost(&across as &dyn Field, &track, peak_m, amplitude, cell)
        });
        self.explanation
            .add(peak_m, amplitude, (&track, cell), window);
        Some(Target {
            x_m: peak_m[0],
            y_m: peak_m[1],
            z_m: self.image.z_m(peak_m[0], peak_m[1]),
            level_db: 20.0 * amplitude.log10(),
            along: shape.along,
            across: shape.across,
            pslr_db: shape.pslr_db,
            islr_db: shape.islr_db,
            ghost,
        })
    }
}
