//! From an image to the list of its targets.

use rayon::prelude::*;

use super::candidates::{Candidate, local_maxima};
use super::ghost::{GhostWindow, find_ghost};
use super::history::History;
use super::{
    Field, ImageStatistics, ImageView, InterpolatedImage, LocalTrack, Target, climb_to_peak,
    measure_shape,
};
use crate::psf::{Cell, PointSpread};
use crate::{ImagingError, Pulses};

/// What counts as a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureOptions {
    /// Lowest level relative to the image's maximum, dB (negative).
    pub threshold_db: f64,
    /// A local maximum is a target of its own only above this multiple of what the targets already
    /// found put there by Eq. (5), sidelobes and ghosts alike.
    pub sidelobe_margin: f64,
    /// No more targets than this.
    pub max_targets: usize,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            threshold_db: -15.0,
            sidelobe_margin: 2.0,
            max_targets: 32,
        }
    }
}

/// What an image shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Targets, strongest first.
    pub targets: Vec<Target>,
    /// Levels of the image as a whole.
    pub statistics: ImageStatistics,
    /// Local maxima above the threshold.
    pub maxima: usize,
    /// Those of them that were taken for sidelobes of a target.
    pub sidelobes: usize,
    /// Those that were taken for ghosts.
    pub ghosts: usize,
    /// Those that were not looked at: beyond [`MeasureOptions::max_targets`] or the 1024 strongest.
    pub skipped: usize,
}

/// Local maxima beyond this many, strongest first, are not examined.
const MAX_CANDIDATES: usize = 1024;
/// Weight of what a target's own echoes predict against what Eq. (5) does. The echoes predict blur
/// in full and a weaker second target by half, so that with the usual margin of 2 blur is taken
/// for what it is up to 1.5 times its prediction, and a second target is kept.
const HISTORY_TRUST: f64 = 0.75;
/// Two partners whose amplitudes differ by less than this cannot be told apart.
const AMBIGUOUS: f64 = 0.01;

/// Finds the targets of an image and measures each: place, level, resolution, sidelobes, ghost.
///
/// Local maxima are taken strongest first, as in CLEAN. Each one that becomes a target is given
/// the response that Eq. (5) predicts for this flight and band (`spread`); later maxima that do not
/// exceed the prediction by [`MeasureOptions::sidelobe_margin`] are its sidelobes, or its ghost
/// where they stand across the local track. Of two partners mirrored at the track the weaker is
/// therefore the ghost; where they are equal within 1 %, as behind a straight track, the one to the
/// right of the flight is.
///
/// A ghost's level is the strongest pixel value about the mirrored place, so it contains whatever
/// else stands there.
///
/// # Errors
/// [`ImagingError::OutOfRange`] for options out of range.
///
/// ```
/// use acerra_imaging::metrics::{ImageView, MeasureOptions, measure_targets};
/// use acerra_imaging::{PlaneGrid, psf::PointSpread};
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
/// let grid = PlaneGrid::new(-0.4, 0.6, 0.0, 0.01, 81, 81)?;
/// let view = ImageView::new(&image, grid)?;
/// let found = measure_targets(&view, &spread, &MeasureOptions::default())?;
/// assert_eq!(found.targets.len(), 1);
/// assert!((found.targets[0].x_m - 0.012).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure_targets(
    image: &ImageView<'_>,
    spread: &PointSpread,
    options: &MeasureOptions,
) -> Result<Measurement, ImagingError> {
    measure(image, spread, None, options)
}

/// The same for an image of `pulses`, whose echoes tell how far positioning errors have blurred
/// each target: what the echoes at a target's range, by their phases alone, put elsewhere is no
/// target of its own. Where the echoes vary in strength, as those of several targets in one range
/// cell do, this is not relied on.
///
/// # Errors
/// As [`measure_targets`].
pub fn measure_targets_in(
    image: &ImageView<'_>,
    pulses: &Pulses<'_>,
    options: &MeasureOptions,
) -> Result<Measurement, ImagingError> {
    measure(image, &PointSpread::of(pulses), Some(pulses), options)
}

fn measure(
    image: &ImageView<'_>,
    spread: &PointSpread,
    pulses: Option<&Pulses<'_>>,
    options: &MeasureOptions,
) -> Result<Measurement, ImagingError> {
    check(options)?;
    let statistics = ImageStatistics::of(image);
    let floor = statistics.maximum * 10f64.powf(options.threshold_db / 20.0);
    let mut candidates = local_maxima(image, floor);
    let maxima = candidates.len();
    candidates.truncate(MAX_CANDIDATES);
    let mut found = Measurement {
        targets: vec![],
        statistics,
        maxima,
        sidelobes: 0,
        ghosts: 0,
        skipped: 0,
    };

    let mut search = Search::new(image, spread, pulses, candidates);
    while let Some(next) = search.next_unexplained(options.sidelobe_margin, &mut found) {
        if found.targets.len() == options.max_targets {
            break;
        }
        let chosen = search.left_of_equal_partners(next);
        if let Some(target) = search.accept(chosen) {
            found.targets.push(target);
        }
    }
    found.skipped = maxima - found.targets.len() - found.sidelobes - found.ghosts;
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

fn check(options: &MeasureOptions) -> Result<(), ImagingError> {
    if !(options.threshold_db < 0.0 && options.threshold_db.is_finite()) {
        return Err(ImagingError::OutOfRange {
            what: "threshold_db",
            expected: "negative (dB relative to the maximum)",
            found: options.threshold_db,
        });
    }
    if !(options.sidelobe_margin >= 1.0 && options.sidelobe_margin.is_finite()) {
        return Err(ImagingError::OutOfRange {
            what: "sidelobe_margin",
            expected: "at least 1",
            found: options.sidelobe_margin,
        });
    }
    Ok(())
}

/// The maxima not yet accounted for, and what the accepted targets predict at each.
struct Search<'a> {
    image: &'a ImageView<'a>,
    spread: &'a PointSpread,
    pulses: Option<&'a Pulses<'a>>,
    candidates: Vec<Candidate>,
    predicted: Vec<f64>,
    in_ghost: Vec<bool>,
    done: Vec<bool>,
}

impl<'a> Search<'a> {
    fn new(
        image: &'a ImageView<'a>,
        spread: &'a PointSpread,
        pulses: Option<&'a Pulses<'a>>,
        candidates: Vec<Candidate>,
    ) -> Self {
        let n = candidates.len();
        let (predicted, in_ghost, done) = (vec![0.0; n], vec![false; n], vec![false; n]);
        Self {
            image,
            spread,
            pulses,
            candidates,
            predicted,
            in_ghost,
            done,
        }
    }

    fn next_unexplained(&mut self, margin: f64, found: &mut Measurement) -> Option<usize> {
        for k in 0..self.candidates.len() {
            if self.done[k] {
                continue;
            }
            if self.candidates[k].amplitude > margin * self.predicted[k] {
                return Some(k);
            }
            self.done[k] = true;
            if self.in_ghost[k] {
                found.ghosts += 1;
            } else {
                found.sidelobes += 1;
            }
        }
        None
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

    fn accept(&mut self, k: usize) -> Option<Target> {
        self.done[k] = true;
        let start = self.place_m(k);
        let field = InterpolatedImage::about(*self.image, start);
        let (peak_m, amplitude) = climb_to_peak(&field, start, self.image.grid().pixel_m)?;
        let (track, cell) = self.surroundings(peak_m)?;
        let shape = measure_shape(&field, &track, peak_m, cell)?;
        let window = GhostWindow::of(&track, peak_m, cell);
        let ghost = window.and_then(|w| {
            let across = InterpolatedImage::about(*self.image, w.centre_m());
            find_ghost(&across as &dyn Field, &track, peak_m, amplitude, cell)
        });
        self.predict(peak_m, amplitude, &track, cell, window);
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

    /// Adds to every remaining maximum what a target at `peak_m` puts there: by Eq. (5), or by the
    /// phases of its own echoes where these are known and put more there. Each is the largest of
    /// five values half a cell apart, since sidelobes of a slightly blurred image do not fall on
    /// the ideal one's to the pixel.
    fn predict(
        &mut self,
        peak_m: [f64; 2],
        amplitude: f64,
        track: &LocalTrack,
        cell: Cell,
        window: Option<GhostWindow>,
    ) {
        let target = [peak_m[0], peak_m[1], self.image.z_m(peak_m[0], peak_m[1])];
        let own = self.spread.response(target, target).norm();
        let history = self
            .pulses
            .and_then(|pulses| History::of(pulses, target))
            .filter(History::is_steady);
        let (ahead, left) = (track.tangent, track.left());
        let half = [0.5 * cell.along_m, 0.5 * cell.across_m];
        let (spread, image, candidates) = (self.spread, self.image, &self.candidates);
        self.predicted
            .par_iter_mut()
            .zip(self.in_ghost.par_iter_mut())
            .zip(self.done.par_iter())
            .enumerate()
            .filter(|(_, (_, done))| !**done)
            .for_each(|(k, ((predicted, in_ghost), _))| {
                let at = image.centre_m(candidates[k].ix, candidates[k].iy);
                let places =
                    [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(a, b)| {
                        let (a, b) = (a * half[0], b * half[1]);
                        let x = at[0] + a * ahead[0] + b * left[0];
                        let y = at[1] + a * ahead[1] + b * left[1];
                        [x, y, image.z_m(x, y)]
                    });
                let ideal = |at: &[f64; 3]| spread.response(target, *at).norm() / own;
                let blurred = |at: &[f64; 3]| {
                    let level = history.as_ref().map_or(0.0, |h| h.level(spread, *at));
                    HISTORY_TRUST * level
                };
                let largest = places
                    .iter()
                    .map(|at| ideal(at).max(blurred(at)))
                    .fold(0.0, f64::max);
                *predicted += amplitude * largest;
                *in_ghost |= window.is_some_and(|w| w.contains(at));
            });
    }
}
