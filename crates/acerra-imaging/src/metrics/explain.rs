//! Sidelobes and ghosts predicted from the targets found so far.

use super::candidates::Candidate;
use super::ghost::GhostWindow;
use super::history::History;
use super::image::ImageView;
use super::track::LocalTrack;
use crate::error::ImagingError;
use crate::kernel::point_spread::Received;
use crate::psf::cell::Cell;
use crate::psf::spread::PointSpread;
use crate::pulses::Pulses;
use acerra_control::Control;
use rayon::prelude::*;
use std::collections::HashMap;

/// Weight of the prediction by a target's own echoes relative to Eq. (5). The echoes predict blur in full and
/// a weaker second target by half. With the usual margin of 2, blur is therefore explained up to 1.5 times
/// its prediction, and a second target is kept.
const HISTORY_TRUST: f64 = 0.75;
/// Least number of contributions of imaging that take as long as one pulse in a point spread function.
const CONTRIBUTIONS_PER_TERM: u64 = 200;
/// Number of terms that may always be evaluated: about a second of processor time.
const LEAST_TERMS: u64 = 20_000_000;
/// Maxima that are predicted together.
const BATCH: usize = 16;

/// Whether the targets found so far explain a maximum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The maximum may be a separate target.
    Unexplained,
    /// A sidelobe of a target.
    Sidelobe,
    /// A ghost of a target.
    Ghost,
    /// The predictions have taken as much time as the image.
    OutOfTime,
}

/// A target that may explain other maxima.
struct Source {
    amplitude: f64,
    /// Range from each pulse (m), and the pulse's weight over its square.
    range_m: Vec<f64>,
    factor: Vec<f64>,
    /// Modulus of the point spread function at the target itself.
    own: f64,
    history: Option<History>,
    /// Half a resolution cell along and across the track.
    half_m: [[f64; 2]; 2],
    window: Option<GhostWindow>,
}

/// Predictions for one maximum: the sum over the first `sources` targets.
#[derive(Clone, Copy, Debug, Default)]
struct Predicted {
    amplitude: f64,
    sources: usize,
}

/// Predictions at maxima, computed on demand and only as far as needed.
pub(super) struct Explanation<'a> {
    image: &'a ImageView<'a>,
    spread: &'a PointSpread,
    pulses: Option<&'a Pulses<'a>>,
    margin: f64,
    sources: Vec<Source>,
    /// Predictions by pixel.
    predicted: HashMap<[usize; 2], Predicted>,
    /// Terms of point spread functions (one a pulse) that may still be evaluated.
    terms_left: u64,
}

impl<'a> Explanation<'a> {
    /// An explanation without targets, in which a maximum is explained up to `margin` times its prediction.
    pub fn new(
        image: &'a ImageView<'a>,
        spread: &'a PointSpread,
        pulses: Option<&'a Pulses<'a>>,
        margin: f64,
    ) -> Self {
        let contributions =
            (image.values().len() as u64).saturating_mul(spread.position_m().len() as u64);
        Self {
            image,
            spread,
            pulses,
            margin,
            sources: Vec::new(),
            predicted: HashMap::new(),
            terms_left: (contributions / CONTRIBUTIONS_PER_TERM).max(LEAST_TERMS),
        }
    }

    /// Adds a target of `amplitude` at (x, y) = `peak_m` as seen from its local track.
    pub fn add(
        &mut self,
        peak_m: [f64; 2],
        amplitude: f64,
        (track, cell): (&LocalTrack, Cell),
        window: Option<GhostWindow>,
    ) {
        let target_m = [peak_m[0], peak_m[1], self.image.z_m(peak_m[0], peak_m[1])];
        let (range_m, factor) = self.spread.received(target_m);
        self.sources.push(Source {
            amplitude,
            own: self.spread.response(target_m, target_m).norm(),
            history: self
                .pulses
                .and_then(|pulses| History::of(pulses, &range_m))
                .filter(History::is_steady),
            range_m,
            factor,
            half_m: [
                track.tangent.map(|v| 0.5 * cell.along_m * v),
                track.left().map(|v| 0.5 * cell.across_m * v),
            ],
            window,
        });
    }

    /// The verdict on the first of `candidates`. Predictions for later candidates that are not `done` are
    /// computed together with the first one's.
    ///
    /// # Errors
    /// Cancellation.
    pub fn of(
        &mut self,
        candidates: &[Candidate],
        done: &[bool],
        control: Control,
    ) -> Result<Verdict, ImagingError> {
        control.check()?;
        let first = &candidates[0];
        if !self.is_settled(first) {
            if self.terms_left == 0 {
                return Ok(Verdict::OutOfTime);
            }
            let batch: Vec<Candidate> = candidates
                .iter()
                .zip(done)
                .filter(|(candidate, done)| !**done && !self.is_settled(candidate))
                .take(BATCH)
                .map(|(candidate, _)| *candidate)
                .collect();
            let found: Vec<(Predicted, u64)> = batch
                .par_iter()
                .map(|candidate| self.predict(candidate, control))
                .collect();
            control.check()?;
            for (candidate, (predicted, terms)) in batch.iter().zip(found) {
                self.terms_left = self.terms_left.saturating_sub(terms);
                self.predicted.insert(pixel(candidate), predicted);
            }
        }
        let explained = self.explains(first, self.prediction(first).amplitude);
        let at = self.image.centre_m(first.ix, first.iy);
        let in_window = |s: &Source| s.window.is_some_and(|w| w.contains(at));
        Ok(match explained {
            false => Verdict::Unexplained,
            true if self.sources.iter().any(in_window) => Verdict::Ghost,
            true => Verdict::Sidelobe,
        })
    }

    fn prediction(&self, candidate: &Candidate) -> Predicted {
        self.predicted
            .get(&pixel(candidate))
            .copied()
            .unwrap_or_default()
    }

    fn explains(&self, candidate: &Candidate, predicted: f64) -> bool {
        candidate.amplitude <= self.margin * predicted
    }

    /// Whether further targets cannot change the verdict: predictions only grow.
    fn is_settled(&self, candidate: &Candidate) -> bool {
        let found = self.prediction(candidate);
        found.sources == self.sources.len() || self.explains(candidate, found.amplitude)
    }

    /// The prediction at a maximum, summed over targets until they explain the maximum or end, and the number
    /// of terms evaluated.
    fn predict(&self, candidate: &Candidate, control: Control) -> (Predicted, u64) {
        let mut found = self.prediction(candidate);
        let mut terms = 0;
        for source in &self.sources[found.sources..] {
            let before = found.amplitude;
            let mut largest: f64 = 0.0;
            for at_m in self.places(source, candidate) {
                if control.is_cancelled() {
                    return (found, terms);
                }
                let (level, more) = self.level(source, at_m);
                terms += more;
                largest = largest.max(level);
                found.amplitude = before + source.amplitude * largest;
                if self.explains(candidate, found.amplitude) {
                    return (found, terms);
                }
            }
            found.sources += 1;
        }
        (found, terms)
    }

    /// A maximum and four places half a cell from it: the prediction is the largest of the five, since
    /// sidelobes of a slightly blurred image do not fall on the ideal one's to the pixel.
    fn places(&self, source: &Source, candidate: &Candidate) -> [[f64; 3]; 5] {
        let at = self.image.centre_m(candidate.ix, candidate.iy);
        let [along, across] = source.half_m;
        [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(a, b)| {
            let x = at[0] + a * along[0] + b * across[0];
            let y = at[1] + a * along[1] + b * across[1];
            [x, y, self.image.z_m(x, y)]
        })
    }

    /// Amplitude at a place relative to that at the target: by Eq. (5), or by the phases of the target's own
    /// echoes where these are known and predict more. Returned with the number of terms.
    fn level(&self, source: &Source, at_m: [f64; 3]) -> (f64, u64) {
        let terms = self.spread.position_m().len() as u64;
        let phasor = source.history.as_ref().map_or(&[][..], History::phasor);
        let echoes = Received {
            range_m: &source.range_m,
            factor: &source.factor,
            phasor,
        };
        let [ideal, blurred] = self.spread.sums(echoes, at_m);
        let ideal = ideal.norm() / source.own;
        match &source.history {
            Some(history) => {
                let blurred = HISTORY_TRUST * history.level(blurred);
                (ideal.max(blurred), 2 * terms)
            }
            None => (ideal, terms),
        }
    }
}

fn pixel(candidate: &Candidate) -> [usize; 2] {
    [candidate.ix, candidate.iy]
}
