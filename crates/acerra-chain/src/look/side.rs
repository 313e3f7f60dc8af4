//! Focus of the echoes of a side-looking radar: delay, height of the plane, and place of the strongest echo.
//!
//! A point's echoes are in phase where its ranges are right. Delay and height of the plane are searched in turn, each
//! at the other's best, and the height's own curve is the best over the delays at every height.

use acerra_geo::trajectory::Trajectory;
use acerra_imaging::{ImagingError, PlaneGrid, SPEED_OF_LIGHT_M_S};
use acerra_radar::Radargram;
use rayon::prelude::*;

use super::error::LookError;
use crate::align::delay::{DelayTrial, Focus};
use crate::align::{AlignOptions, Flight, align, plane};
use crate::choices::{Gate, TimeOffset};
use crate::clean::CleanOptions;
use crate::control::Control;
use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::read::RadarContent;
use crate::scene::{Scene, SceneHeights, SceneOptions};

/// Delays of an instrument without a calibration (s), their spacing, and half the range tried about the best
/// at each height.
const DELAY_S: [f64; 2] = [0.0, 20e-9];
const DELAY_STEP_S: f64 = 0.4e-9;
const BESIDE_S: f64 = 1.2e-9;
/// Heights tried (m): least depth below the lowest position, up to the height of the flight, with spacing and
/// largest number. Above the flight the echoes of a level track are those of the mirror image below it.
const BELOW_M: f64 = 2.0;
const HEIGHT_STEP_M: f64 = 0.15;
const MOST_HEIGHTS: usize = 60;
/// Turns of the search.
const TURNS: usize = 2;
/// Log-likelihood by which a height or delay must be surpassed to be excluded (odds of 400 to 1).
const MARGIN: f64 = 6.0;
/// Two-way time after 2h/c up to which the default image reaches (s).
const KEPT_S: f64 = 24e-9;
/// Pixels of the image of everything in range, and least distance of an echo from the default image (m).
const WIDE_PIXELS: f64 = 300_000.0;

/// A quantity by the coherence of the most coherent echoes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Determined {
    /// The best value.
    pub best: f64,
    /// First and last value that the echoes do not exclude.
    pub within: [f64; 2],
    /// Whether the echoes exclude both ends of the range tried.
    pub is_bounded: bool,
}

/// Focus of the echoes of a side-looking radar.
#[derive(Clone, Debug)]
pub struct SideLook {
    /// Fast time at which range is zero (s).
    pub delay_s: Determined,
    /// Height of the most coherent echoes (m).
    pub height_m: Determined,
    /// Largest movement of the most coherent echo over the plane within the heights that are not excluded
    /// (m).
    pub moved_m: f64,
    /// Place of the most coherent echo (x, y), m.
    pub place_m: Option<[f64; 2]>,
    /// The strongest echo of everything in range (x, y), m, and its level above the strongest in the default
    /// image (dB), where it lies outside and is stronger.
    pub beyond: Option<([f64; 2], f64)>,
    /// Farthest range of the record at that delay (m).
    pub reach_m: f64,
    /// First and last position of the traces along x and y (m).
    pub path_m: [[f64; 2]; 2],
    /// The default image along x and y (m).
    pub around_m: [[f64; 2]; 2],
}

/// The flight's default surroundings on a plane.
pub(super) fn scene(trajectory: &Trajectory, z_m: f64) -> Result<Scene, LookError> {
    let options = SceneOptions {
        x_m: None,
        y_m: None,
        kept_s: Some(KEPT_S),
        pixel_m: 0.01,
        heights: SceneHeights::Plane(z_m),
        surface_z_m: None,
        has_radar_surface: false,
        terrain: None,
        origin: None,
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    };
    let positions = Positions::from(trajectory.clone());
    Ok(Scene::find(
        &options,
        &[&positions],
        &mut Warnings::default(),
    )?)
}

pub(super) fn look(
    radargram: &Radargram,
    trajectory: &Trajectory,
    scene: &Scene,
    offset_s: f64,
    control: &Control<'_>,
) -> Result<SideLook, LookError> {
    let radar = RadarContent::Radargram(radargram.clone());
    let positions = Positions::from(trajectory.clone());
    let flight = Flight {
        radar: &radar,
        positions: &positions,
        scene,
    };
    let options = AlignOptions {
        time_offset: Some(TimeOffset::Seconds(offset_s)),
        ..AlignOptions::default()
    };
    let aligned = align(flight, &options, offset_s, &mut Warnings::default())?;
    let clean = CleanOptions {
        gate_ns: Gate::None,
        ..CleanOptions::default()
    };
    let trial = DelayTrial {
        radar: &radar,
        aligned: &aligned,
        scene,
        clean: &clean,
        surface: None,
        coupling: None,
    };
    let middle_s = 0.5 * (DELAY_S[0] + DELAY_S[1]);
    let search = Search {
        focus: trial.focus_about(middle_s)?,
        control,
    };
    let mut sorted_m: Vec<f64> = aligned.position_m.iter().map(|p| p[2]).collect();
    sorted_m.sort_by(f64::total_cmp);
    let flown_m = sorted_m[sorted_m.len() / 2];
    let lowest_m = plane::lowest_m(trajectory).min(flown_m);
    let heights_m = [lowest_m - BELOW_M, flown_m];
    let mut found = search.run(trial.whole()?, heights_m)?;
    let path_m = [0, 1].map(|axis| {
        let along = aligned.position_m.iter().map(|p| p[axis]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        [low, along.fold(f64::NEG_INFINITY, f64::max)]
    });
    found.path_m = path_m;
    if let Some(place_m) = found.place_m {
        let nearest = aligned.position_m.iter().map(|p| {
            let across_m = (p[0] - place_m[0]).hypot(p[1] - place_m[1]);
            (across_m, p[2] - found.height_m.best)
        });
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
        let (across_m, above_m) = nearest.unwrap_or((1.0, 0.0));
        let [low_m, high_m] = found.height_m.within;
        found.moved_m = 0.5 * (high_m - low_m) * (above_m / across_m.max(0.1)).abs();
    }
    let half_c = 0.5 * scene.light_speed_m_s;
    let end_s = radargram.fast_time_end_s();
    found.reach_m = half_c * (end_s - found.delay_s.best).max(0.0);
    found.beyond = search.beyond(&found, trial.whole()?)?;
    Ok(found)
}

struct Search<'a> {
    focus: Focus<'a>,
    control: &'a Control<'a>,
}

/// Coherence of the most coherent echoes as a log-likelihood, and the place of the first (x, y), m.
type Scored = (f64, Option<[f64; 2]>);

impl Search<'_> {
    fn run(&self, whole: PlaneGrid, heights_m: [f64; 2]) -> Result<SideLook, LookError> {
        let delays_s = steps(DELAY_S, DELAY_STEP_S, usize::MAX);
        let tried_m = steps(heights_m, HEIGHT_STEP_M, MOST_HEIGHTS);
        // The middle between the lowest position and the deepest height tried.
        let mut z_m = whole.z_m;
        let mut delay_s = 0.0;
        let mut by_delay = Vec::new();
        let mut window = self.focus.window(PlaneGrid { z_m, ..whole }, &delays_s)?;
        for turn in 0..TURNS {
            by_delay = self.each(&delays_s, |d| {
                self.focus.most_coherent(*d, PlaneGrid { z_m, ..window })
            })?;
            delay_s = delays_s[best_of(&by_delay)];
            if turn + 1 < TURNS {
                let by_height = self.each(&tried_m, |z| {
                    self.focus
                        .most_coherent(delay_s, PlaneGrid { z_m: *z, ..window })
                })?;
                z_m = tried_m[best_of(&by_height)];
                window = self.focus.window(PlaneGrid { z_m, ..whole }, &[delay_s])?;
            }
        }
        let beside_s: Vec<f64> = delays_s
            .iter()
            .copied()
            .filter(|d| (d - delay_s).abs() <= BESIDE_S + 1e-12)
            .collect();
        let by_height = self.each(&tried_m, |z| {
            let each = beside_s
                .iter()
                .map(|d| {
                    self.focus
                        .most_coherent(*d, PlaneGrid { z_m: *z, ..window })
                })
                .collect::<Result<Vec<Scored>, ImagingError>>()?;
            Ok(each[best_of(&each)])
        })?;
        let best = best_of(&by_height);
        Ok(SideLook {
            delay_s: determined(&delays_s, &by_delay),
            height_m: determined(&tried_m, &by_height),
            moved_m: 0.0,
            place_m: by_height[best].1,
            beyond: None,
            reach_m: 0.0,
            path_m: [[0.0; 2]; 2],
            around_m: [
                [whole.x0_m, whole.x_m(whole.nx - 1)],
                [whole.y0_m, whole.y_m(whole.ny - 1)],
            ],
        })
    }

    fn each(
        &self,
        values: &[f64],
        score: impl Fn(&f64) -> Result<Scored, ImagingError> + Sync,
    ) -> Result<Vec<Scored>, LookError> {
        let one = |value: &f64| {
            self.control.check()?;
            Ok(score(value)?)
        };
        values.par_iter().map(one).collect()
    }

    /// The strongest echo in range, where it lies outside the default image and is stronger.
    fn beyond(
        &self,
        found: &SideLook,
        whole: PlaneGrid,
    ) -> Result<Option<([f64; 2], f64)>, LookError> {
        let side = |axis: usize| {
            let [low, high] = found.path_m[axis];
            [low - found.reach_m, high + found.reach_m]
        };
        let z_m = found.height_m.best;
        let wide = PlaneGrid::from_ranges(side(0), side(1), z_m, 0.02)?;
        let wide = crate::echoes::sharpen::coarse(wide, WIDE_PIXELS)?;
        let (wide_db, place_m) = self.focus.strongest(found.delay_s.best, wide)?;
        let same = crate::echoes::sharpen::coarse(PlaneGrid { z_m, ..whole }, WIDE_PIXELS)?;
        let (own_db, _) = self.focus.strongest(found.delay_s.best, same)?;
        let is_inside = |place_m: [f64; 2]| {
            let mut sides = found.around_m.iter().zip(place_m);
            sides.all(|([from, to], v)| (*from..=*to).contains(&v))
        };
        let above_db = wide_db - own_db;
        Ok(place_m
            .filter(|place_m| !is_inside(*place_m) && above_db > 0.0)
            .map(|place_m| (place_m, above_db)))
    }
}

fn best_of(scored: &[Scored]) -> usize {
    (0..scored.len())
        .max_by(|a, b| scored[*a].0.total_cmp(&scored[*b].0))
        .unwrap_or_default()
}

/// The best of the values tried, and all values within the margin, connected or not.
fn determined(values: &[f64], scored: &[Scored]) -> Determined {
    let best = best_of(scored);
    let least = scored[best].0 - MARGIN;
    let is_left = |k: &usize| scored[*k].0 >= least;
    let first = (0..values.len()).find(is_left).unwrap_or(best);
    let last = (0..values.len()).rev().find(is_left).unwrap_or(best);
    Determined {
        best: values[best],
        within: [values[first], values[last]],
        is_bounded: first > 0 && last + 1 < values.len(),
    }
}

fn steps([from, to]: [f64; 2], step: f64, most: usize) -> Vec<f64> {
    let count = (((to - from) / step).ceil().max(1.0) as usize).min(most.saturating_sub(1));
    (0..=count)
        .map(|k| from + (to - from) * k as f64 / count as f64)
        .collect()
}
