//! Start of the adjustment: delay and clock offset at which the surveyed reflectors are in focus.

use acerra_imaging::delay_sums::Delays;
use rayon::prelude::*;

use super::echo::median;
use super::error::{CalibrateError, Solution};
use super::focus::{Focus, Placed, SILENT, Stretch, stretches};
use super::parameter::Values;
use super::track::{Setting, TrackEchoes};
use crate::control::Control;

/// Delays tried (s), of either sign: the impossible ones show what clutter alone reaches.
const DELAY_S: [f64; 2] = [-20e-9, 20e-9];
/// Longest stretch of offsets over which the traces that see a reflector from one side count as the same (s).
const WINDOW_S: f64 = 2.0;
/// Path of a trace below which the platform is at rest (m).
const LEAST_PATH_M: f64 = 2e-3;
/// Spacing of the delays (s), as the patch about a reflector covers 2.4 ns to either side; of a platform at
/// rest, which resolves no place, a fifth of a pulse's envelope.
const DELAY_STEP_S: f64 = 0.45e-9;
const DELAY_STEP_AT_REST_S: f64 = 0.12e-9;
/// Change of range that a step of the offset may make at the highest speed (m).
const OFFSET_STEP_M: f64 = 0.05;
/// Level of the best over the median of all settings that it needs (dB): of 10⁵ patches of noise the greatest
/// is 5 dB above their median.
const NEEDED_DB: f64 = 7.0;
/// Least level difference between the best and the second solution (dB).
const APART_DB: f64 = 3.0;
/// Settings connected with the best down to this level are the same solution (dB).
const HILL_DB: f64 = 6.0;
/// Solutions named at most.
const MOST_SOLUTIONS: usize = 4;

/// The setting of one track at which the track's reflectors are in focus.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Clock offset (s).
    pub offset_s: f64,
    /// Height above the median of all settings (dB).
    pub contrast_db: f64,
    /// Stretches of the track, and where each is in focus.
    pub stretches: Vec<(Stretch, Focus)>,
}

/// Finds delay and offset of a track from scratch.
pub(super) fn search(
    setting: &Setting<'_>,
    track: &TrackEchoes,
    start: &Values,
    control: &Control<'_>,
) -> Result<Start, CalibrateError> {
    let delay_step_s = if track.at_rest {
        DELAY_STEP_AT_REST_S
    } else {
        DELAY_STEP_S
    };
    let mut grid = Grid {
        delay_s: steps(DELAY_S, delay_step_s),
        offset_s: Vec::new(),
    };
    let sums = track.profiles.sums_at(Delays {
        start_s: DELAY_S[0],
        step_s: delay_step_s,
        count: grid.delay_s.len(),
    });
    let mut level_db = Vec::new();
    let windows = windows(setting, track, start);
    let most_traces = windows.iter().map(Window::moving_traces).max();
    for window in windows {
        let rows = (window.offset_s.par_iter())
            .map(|offset_s| {
                control.check()?;
                let of_stretch = |stretch: &Stretch| {
                    let placed = Placed::at(stretch, setting, track, start, *offset_s, false);
                    placed.focus(setting, (&sums, &grid.delay_s), track.at_rest)
                };
                Ok(window.stretches.iter().map(of_stretch).collect::<Vec<_>>())
            })
            .collect::<Result<Vec<_>, CalibrateError>>()?;
        // Traces that an offset leaves without a place, or at rest, are no evidence for it.
        let share = window.moving_traces() as f64 / most_traces.unwrap_or(0).max(1) as f64;
        let levels_db = grid.levels_db(&rows, &window.stretches);
        level_db.extend(levels_db.into_iter().map(|level_db| share * level_db));
        grid.offset_s.extend(window.offset_s);
    }
    let top = grid.best(&level_db, track)?;
    let (delay_s, offset_s) = (grid.delay(top), grid.offset(top));
    let in_focus = |stretch: Stretch| {
        let placed = Placed::at(&stretch, setting, track, start, offset_s, false);
        let at_delays = placed.focus(setting, (&sums, &grid.delay_s), track.at_rest);
        (stretch, at_delays[top % grid.delay_s.len()])
    };
    let stretches = stretches(setting, track, start, offset_s);
    Ok(Start {
        delay_s,
        offset_s,
        contrast_db: level_db[top],
        stretches: stretches.into_iter().map(in_focus).collect(),
    })
}

/// Clock offsets at which the same traces see each reflector from about the same side.
struct Window {
    offset_s: Vec<f64>,
    stretches: Vec<Stretch>,
}

impl Window {
    /// Offsets from `from_s` to `to_s`; one where the platform is at rest, as every offset is then as good.
    fn new(
        setting: &Setting<'_>,
        track: &TrackEchoes,
        values: &Values,
        [from_s, to_s]: [f64; 2],
    ) -> Self {
        let middle_s = 0.5 * (from_s + to_s);
        let speed_m_s = track.top_speed_m_s(middle_s);
        let step_s = (OFFSET_STEP_M / speed_m_s.max(1e-9)).clamp(0.01, 0.1);
        Self {
            offset_s: if track.at_rest {
                vec![middle_s]
            } else {
                steps([from_s, to_s], step_s)
            },
            stretches: stretches(setting, track, values, middle_s),
        }
    }

    /// Traces, of all reflectors, that cover [`LEAST_PATH_M`] or more; all of a platform at rest.
    fn moving_traces(&self) -> usize {
        let weights = self.stretches.iter().flat_map(|stretch| &stretch.weight);
        weights.filter(|path_m| **path_m >= LEAST_PATH_M).count()
    }
}

/// The windows of the offsets that a track leaves open.
fn windows(setting: &Setting<'_>, track: &TrackEchoes, values: &Values) -> Vec<Window> {
    let pieces = (track.open_offsets_s.iter()).flat_map(|ends_s| pieces(*ends_s, WINDOW_S));
    let window = |ends_s: [f64; 2]| Window::new(setting, track, values, ends_s);
    pieces.map(window).collect()
}

/// A stretch in equal pieces of `longest_s` at most.
fn pieces([from_s, to_s]: [f64; 2], longest_s: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = ((to_s - from_s) / longest_s).ceil().max(1.0);
    let end_s = move |k: usize| from_s + (to_s - from_s) * k as f64 / count;
    (0..count as usize).map(move |k| [end_s(k), end_s(k + 1)])
}

/// Delays and offsets tried.
struct Grid {
    delay_s: Vec<f64>,
    offset_s: Vec<f64>,
}

impl Grid {
    /// Level of each setting above the median of all (dB): the level that more than half of the reflectors reach, each
    /// by the mean over its stretches by their paths. The level of each stretch is relative to the median of that
    /// stretch, so that one bright echo does not outweigh a reflector seen from all sides.
    fn levels_db(&self, rows: &[Vec<Vec<Focus>>], stretches: &[Stretch]) -> Vec<f64> {
        let cells = rows.len() * self.delay_s.len();
        let mut reflectors: Vec<usize> = stretches.iter().map(|s| s.reflector).collect();
        reflectors.dedup();
        let of_reflector = |reflector: &usize| {
            let mut level = vec![0.0; cells];
            let mut total = 0.0;
            for (k, stretch) in stretches.iter().enumerate() {
                if stretch.reflector != *reflector {
                    continue;
                }
                let own = |cell: usize| {
                    rows[cell / self.delay_s.len()][k][cell % self.delay_s.len()].level
                };
                let heard = (0..cells).map(own).filter(|l| *l > SILENT);
                let middle = median(heard);
                let weight = stretch.weight.iter().sum::<f64>();
                total += weight;
                for (cell, level) in level.iter_mut().enumerate() {
                    // Echoes outside the record are no better than the median.
                    if own(cell) > SILENT {
                        *level += weight * (own(cell) - middle);
                    }
                }
            }
            let per_db = 10.0 / std::f64::consts::LN_10;
            let scale = per_db / f64::max(total, 1e-12);
            level.iter_mut().for_each(|l| *l *= scale);
            level
        };
        let each: Vec<Vec<f64>> = reflectors.iter().map(of_reflector).collect();
        let of_most = |cell: usize| {
            let mut levels: Vec<f64> = each.iter().map(|level| level[cell]).collect();
            levels.sort_by(f64::total_cmp);
            let lower_middle = levels.len().saturating_sub(1) / 2;
            levels.get(lower_middle).copied().unwrap_or(0.0)
        };
        let level: Vec<f64> = (0..cells).map(of_most).collect();
        let middle = median(level.iter().copied());
        level.iter().map(|l| l - middle).collect()
    }

    /// The best setting, where it is clearly above the median, no other setting is near its level, and range zero is
    /// possible there.
    ///
    /// Where the record shows the direct coupling, range zero is known to some nanoseconds: the delays elsewhere show
    /// what clutter alone reaches, and a setting that clutter nearly reaches is none.
    fn best(&self, level_db: &[f64], track: &TrackEchoes) -> Result<usize, CalibrateError> {
        let mut solutions = self.solutions(level_db);
        let possible_s = track.possible_delays_s();
        let is_possible = |k: &usize| is_within(self.delay(*k), possible_s);
        // A level that rises to the end of the delays tried is no maximum.
        let last = self.delay_s.len() - 1;
        solutions.retain(|k| is_possible(k) || (1..last).contains(&(k % self.delay_s.len())));
        let contrast_db = solutions.first().map_or(0.0, |k| level_db[*k]);
        if contrast_db < NEEDED_DB {
            return Err(CalibrateError::NoEcho {
                delay_ns: DELAY_S.map(|d| d * 1e9),
                offset_s: self.ends_s(),
                contrast_db,
                needed_db: NEEDED_DB,
            });
        }
        if track.coupling.is_none() && solutions.iter().any(is_possible) {
            solutions.retain(is_possible);
        }
        let all_possible = solutions.iter().all(is_possible);
        if let ([only], true) = (solutions.as_slice(), all_possible) {
            return Ok(*only);
        }
        let solution = |k: &usize| Solution {
            delay_ns: self.delay(*k) * 1e9,
            offset_s: self.offset(*k),
            below_db: contrast_db - level_db[*k],
        };
        let solutions = solutions.iter().map(solution).collect();
        Err(if all_possible {
            CalibrateError::Ambiguous { solutions }
        } else {
            CalibrateError::Impossible {
                solutions,
                possible_ns: possible_s.map(|d| d * 1e9),
            }
        })
    }

    /// The best setting and those near its level that do not hang together with a better one, best first.
    fn solutions(&self, level_db: &[f64]) -> Vec<usize> {
        let mut solutions: Vec<usize> = Vec::new();
        let mut taken = vec![false; level_db.len()];
        while solutions.len() < MOST_SOLUTIONS {
            let Some(top) = highest(level_db, |k| !taken[k]) else {
                break;
            };
            let first_db = solutions.first().map_or(level_db[top], |k| level_db[*k]);
            if level_db[top] < first_db - APART_DB || level_db[top].is_nan() {
                break;
            }
            for (cell, inside) in self.connected(level_db, top).into_iter().enumerate() {
                taken[cell] |= inside;
            }
            solutions.push(top);
        }
        solutions
    }

    fn ends_s(&self) -> [f64; 2] {
        let of = |offset_s: Option<&f64>| offset_s.copied().unwrap_or_default();
        [of(self.offset_s.first()), of(self.offset_s.last())]
    }

    fn delay(&self, cell: usize) -> f64 {
        self.delay_s[cell % self.delay_s.len()]
    }

    fn offset(&self, cell: usize) -> f64 {
        self.offset_s[cell / self.delay_s.len()]
    }

    /// The cells that hang together with `top`: its hill, and the ridge along which delay and offset are in
    /// for each other.
    fn connected(&self, level_db: &[f64], top: usize) -> Vec<bool> {
        let least_db = level_db[top] - HILL_DB.min(0.5 * level_db[top].max(0.0));
        let columns = self.delay_s.len();
        let rows = self.offset_s.len();
        let mut inside = vec![false; level_db.len()];
        inside[top] = true;
        let mut edge = vec![top];
        while let Some(cell) = edge.pop() {
            let (row, column) = (cell / columns, cell % columns);
            for r in row.saturating_sub(2)..(row + 3).min(rows) {
                for c in column.saturating_sub(2)..(column + 3).min(columns) {
                    let next = r * columns + c;
                    if !inside[next] && level_db[next] > least_db {
                        inside[next] = true;
                        edge.push(next);
                    }
                }
            }
        }
        inside
    }
}

/// Whether a delay is possible, but for the spacing of the delays tried.
fn is_within(delay_s: f64, [from_s, to_s]: [f64; 2]) -> bool {
    (from_s - DELAY_STEP_S..=to_s + DELAY_STEP_S).contains(&delay_s)
}

fn steps([from, to]: [f64; 2], step: f64) -> Vec<f64> {
    let count = ((to - from) / step).round() as usize;
    (0..=count).map(|k| from + k as f64 * step).collect()
}

fn highest(level_db: &[f64], admitted: impl Fn(usize) -> bool) -> Option<usize> {
    (0..level_db.len())
        .filter(|k| admitted(*k))
        .max_by(|a, b| level_db[*a].total_cmp(&level_db[*b]))
}
