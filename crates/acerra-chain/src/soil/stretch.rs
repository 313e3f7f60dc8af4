//! Spacing of the traces along a line, by the shape of an echo.

use acerra_imaging::ImagingError;
use acerra_imaging::refraction::{Ground, Ray};
use nalgebra::Vector4;
use rayon::prelude::*;

use super::echo::{Bench, Best, FALSE_ALARM, Seen, Stretch, vertex};
use super::leg::vertical;
use super::phases::{Phase, regress};

/// Ratio of one trial of the spacing to the one before, and trials to either side: up to a factor of four.
const RATIO: f64 = 1.1;
const TRIALS: i32 = 14;
/// Relative step over which paths are compared with the factor.
const STEP: f64 = 0.05;
/// Times that place and delay of an echo are improved by its best trial.
const ROUNDS: usize = 2;
/// Traces from which an echo has a shape.
const LEAST_TRACES: usize = 8;
/// Largest relative deviation of a factor across the lines that counts as known.
const MOST_ACROSS_SIGMA: f64 = 0.2;
/// Axes of a line.
const ALONG: usize = 0;
const ACROSS: usize = 1;

/// An echo whose shape gives the spacing of the traces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StretchedEcho {
    /// Positions over true distances along the lines, by the permittivities in force.
    pub along: Factor,
    /// The same across the lines; none where too few lines see the echo, or where its object has no end across the lines.
    pub across: Option<Factor>,
    /// Delay below the surface straight under the antenna, as one-way optical length Σ n t (m).
    pub delay_m: f64,
    /// Height of the antenna above the surface (m).
    pub height_m: f64,
}

/// A factor between positions and the distances that an echo's shape shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factor {
    /// The factor.
    pub value: f64,
    /// Its standard deviation, by the phases along the hyperbola.
    pub sigma: f64,
}

impl Bench<'_> {
    /// The factor of the spacing at which the traces of a track add up to the greatest power of the echo about a place;
    /// none where no echo exceeds the clutter, or where no factor from a quarter to four maximises the power.
    pub fn stretched(
        &self,
        place_m: [f64; 3],
        stretch: Stretch<'_>,
    ) -> Result<Option<StretchedEcho>, ImagingError> {
        let ground = self.ground(1.0)?;
        let surface_m = ground.surface().height_m([place_m[0], place_m[1]]);
        let leg = vertical(&ground, surface_m - place_m[2]);
        let mut about = About {
            place_m,
            delay_m: leg.delay_m - 0.5 * self.excess_path_m,
        };
        let mut along = None;
        for _ in 0..ROUNDS {
            along = self.scan(&ground, about, stretch, ALONG);
            let Some(scan) = &along else {
                return Ok(None);
            };
            about = About {
                place_m: scan.best.place_m,
                delay_m: about.delay_m + scan.best.later_m,
            };
        }
        let Some(scan) = along else {
            return Ok(None);
        };
        let bench = scan.bench;
        let floor = bench.clutter(&ground, &scan.seen, about.place_m, about.delay_m);
        let tried = self.places as f64 * f64::from(2 * TRIALS + 1);
        let is_distinct = floor > 0.0 && scan.best.power >= (tried / FALSE_ALARM).ln() * floor;
        if !is_distinct || scan.seen.traces.len() < LEAST_TRACES {
            return Ok(None);
        }
        let clutter = floor / scan.best.power;
        let Some(along) = scan.factor(&ground, clutter) else {
            return Ok(None);
        };
        let across = (bench.stretch)
            .and_then(|stretch| self.scan(&ground, about, stretch, ACROSS))
            .and_then(|scan| scan.factor(&ground, clutter))
            .filter(|found| found.sigma <= MOST_ACROSS_SIGMA * found.value);
        Ok(Some(StretchedEcho {
            along,
            across,
            delay_m: about.delay_m,
            height_m: self.height_above(&ground, about.place_m),
        }))
    }

    /// The factor along an axis at which an echo is strongest, where it is neither the first nor the last tried.
    fn scan<'a>(
        &'a self,
        ground: &Ground,
        about: About,
        stretch: Stretch<'a>,
        axis: usize,
    ) -> Option<Scan<'a>> {
        if about.delay_m <= 0.0 {
            return None;
        }
        let scan_at = |k: i32| {
            let mut factors = stretch.factors;
            factors[axis] = RATIO.powi(k);
            let bench = Bench {
                stretch: Some(Stretch { factors, ..stretch }),
                ..*self
            };
            let seen = bench.seen(ground, about.place_m);
            let best = bench.best_near(ground, &seen, about.place_m, about.delay_m);
            Scan {
                axis,
                at: factors[axis],
                refined: None,
                bench,
                seen,
                best,
            }
        };
        let trials: Vec<Scan<'a>> = (-TRIALS..=TRIALS).into_par_iter().map(scan_at).collect();
        let curve: Vec<[f64; 2]> = (trials.iter())
            .map(|trial| [trial.at, trial.explained()])
            .collect();
        let top = (0..curve.len()).max_by(|a, b| curve[*a][1].total_cmp(&curve[*b][1]))?;
        let is_inner = top > 0 && top + 1 < curve.len();
        let trial = trials.into_iter().nth(top).filter(|_| is_inner)?;
        Some(Scan {
            refined: vertex(&curve, top),
            ..trial
        })
    }

    /// Height of the trace nearest to a place above the surface below the trace (m).
    fn height_above(&self, ground: &Ground, place_m: [f64; 3]) -> f64 {
        let away_m = |p: &[f64; 3]| (p[0] - place_m[0]).hypot(p[1] - place_m[1]);
        let traces = self.echoes.aligned.position_m.iter();
        let nearest = traces.min_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        nearest.map_or(0.0, |p| p[2] - ground.surface().height_m([p[0], p[1]]))
    }
}

/// Where an echo is looked for.
#[derive(Clone, Copy)]
struct About {
    place_m: [f64; 3],
    /// Delay below the surface, as one-way optical length (m).
    delay_m: f64,
}

/// An echo with positions scaled along an axis by one factor.
struct Scan<'a> {
    axis: usize,
    /// The factor.
    at: f64,
    /// The factor of the greatest power, between those tried.
    refined: Option<f64>,
    bench: Bench<'a>,
    /// The traces that see the echo by this factor.
    seen: Seen,
    best: Best,
}

impl Scan<'_> {
    /// Power that echoes of equal amplitude in the traces seen, and none in others, explain.
    fn explained(&self) -> f64 {
        let summed = self.seen.traces.len().max(1) as f64;
        self.best.power * self.seen.of as f64 / (summed * summed)
    }

    /// The factor, with its deviation by the phases of the traces. `clutter` is the share of clutter in the power.
    fn factor(&self, ground: &Ground, clutter: f64) -> Option<Factor> {
        let stretch = self.bench.stretch?;
        let step = self.at * STEP;
        let mut factors = stretch.factors;
        factors[self.axis] += step;
        let other = Bench {
            stretch: Some(Stretch { factors, ..stretch }),
            ..self.bench
        };
        let place_m = self.best.place_m;
        let path_m = |rays: [Ray; 2]| rays[0].optical_m + rays[1].optical_m;
        let traces: Vec<Phase> = (self.seen.traces.par_iter())
            .map(|trace| {
                let rays = self.bench.rays(ground, *trace, place_m);
                let by_axis = |axis: usize| rays[0].gradient[axis] + rays[1].gradient[axis];
                let by_factor = (path_m(other.rays(ground, *trace, place_m)) - path_m(rays)) / step;
                Phase {
                    by: Vector4::new(1.0, by_axis(0), by_axis(1), by_factor),
                    value: (self.bench).sum_at(ground, *trace, place_m, self.best.later_m),
                }
            })
            .collect();
        let [off, sigma] = regress(&traces, self.best.wavelength_m, clutter)?;
        Some(Factor {
            value: self.refined.unwrap_or(self.at + off),
            sigma,
        })
    }
}
