//! Where the adjustment starts: delay and clock offset at which the stack of all reflectors' echoes
//! is highest.

use super::echo::{Profiles, median};
use super::error::CalibrateError;
use super::model::predict;
use super::parameter::Values;
use super::track::{Setting, TrackEchoes};
use crate::control::Control;

/// Delays tried (s): antenna cables and the radio's own, of either sign.
const DELAY_S: [f64; 2] = [-20e-9, 20e-9];
/// Offsets tried about the campaign's (s).
const OFFSET_S: f64 = 1.0;
/// Step of the delays (s): a fifth of a pulse's envelope.
const DELAY_STEP_S: f64 = 0.12e-9;
/// Change of range that a step of the offset may make at the highest speed (m).
const OFFSET_STEP_M: f64 = 0.03;
/// Traces that are stacked.
const MOST_TRACES: usize = 100;
/// Contrast needed, in deviations of the stacks of the whole grid. The highest of 10⁵ stacks of
/// noise stands below 5.
const NEEDED: f64 = 6.0;
/// Second-best stack, as a part of the best, from which on the two cannot be told apart.
const SECOND: f64 = 0.9;

/// The highest stack of one track.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coarse {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Clock offset (s).
    pub offset_s: f64,
    /// Height above the median of all stacks, in deviations.
    pub contrast: f64,
}

/// Finds delay and offset of a track from scratch.
pub(super) fn search(
    setting: &Setting<'_>,
    track: &TrackEchoes,
    number: usize,
    start: &Values,
    control: &Control<'_>,
) -> Result<Coarse, CalibrateError> {
    let grid = Grid::new(track, start.time_offset_s[number]);
    let mut stack = Vec::with_capacity(grid.offset_s.len() * grid.delay_s.len());
    for &offset_s in &grid.offset_s {
        control.check()?;
        let delays = EchoDelays::of(setting, track, start, offset_s);
        stack.extend(
            grid.delay_s
                .iter()
                .map(|d| delays.stack(&track.profiles, *d)),
        );
    }
    grid.best(&stack, start.time_offset_s[number])
}

/// Delays and offsets tried.
struct Grid {
    delay_s: Vec<f64>,
    offset_s: Vec<f64>,
}

impl Grid {
    fn new(track: &TrackEchoes, offset_s: f64) -> Self {
        let speed_m_s = track.top_speed_m_s(offset_s);
        let step_s = (OFFSET_STEP_M / speed_m_s.max(1e-9)).clamp(0.005, 0.05);
        // At rest every offset says the same.
        let around = if track.at_rest {
            vec![0.0]
        } else {
            steps([-OFFSET_S, OFFSET_S], step_s)
        };
        Self {
            delay_s: steps(DELAY_S, DELAY_STEP_S),
            offset_s: around.into_iter().map(|d| offset_s + d).collect(),
        }
    }

    /// The highest stack, where it stands out and nothing apart from it comes near.
    fn best(&self, stack: &[f64], campaign_s: f64) -> Result<Coarse, CalibrateError> {
        let middle = median(stack.iter().copied());
        let spread = 1.4826 * median(stack.iter().map(|v| (v - middle).abs()));
        let top = highest(stack, |_| true).unwrap_or(0);
        let contrast = (stack[top] - middle) / spread.max(f64::MIN_POSITIVE);
        if contrast.is_nan() || contrast < NEEDED || spread <= 0.0 {
            return Err(CalibrateError::NoEcho {
                delay_ns: DELAY_S.map(|d| d * 1e9),
                offset_s: OFFSET_S,
                contrast: if spread > 0.0 { contrast } else { 0.0 },
                needed: NEEDED,
            });
        }
        let ridge = self.connected(stack, top, middle + 0.5 * (stack[top] - middle));
        let at = |k: usize| [self.delay(k), self.offset(k) - campaign_s];
        if let Some(second) = highest(stack, |k| !ridge[k]) {
            let share = (stack[second] - middle) / (stack[top] - middle);
            if share > SECOND {
                return Err(CalibrateError::Ambiguous {
                    best: at(top),
                    second: at(second),
                    share: 100.0 * share,
                });
            }
        }
        Ok(Coarse {
            delay_s: self.delay(top),
            offset_s: self.offset(top),
            contrast,
        })
    }

    fn delay(&self, cell: usize) -> f64 {
        self.delay_s[cell % self.delay_s.len()]
    }

    fn offset(&self, cell: usize) -> f64 {
        self.offset_s[cell / self.delay_s.len()]
    }

    /// The cells above `level` that hang together with `top`: its hill and the ridge along which
    /// delay and offset stand in for each other.
    fn connected(&self, stack: &[f64], top: usize, level: f64) -> Vec<bool> {
        let columns = self.delay_s.len();
        let rows = self.offset_s.len();
        let mut inside = vec![false; stack.len()];
        inside[top] = true;
        let mut edge = vec![top];
        while let Some(cell) = edge.pop() {
            let (row, column) = (cell / columns, cell % columns);
            for r in row.saturating_sub(2)..(row + 3).min(rows) {
                for c in column.saturating_sub(2)..(column + 3).min(columns) {
                    let next = r * columns + c;
                    if !inside[next] && stack[next] > level {
                        inside[next] = true;
                        edge.push(next);
                    }
                }
            }
        }
        inside
    }
}

/// Two-way delays of the reflectors at one offset, without the delay at range zero.
struct EchoDelays {
    /// Trace and fast time (s).
    echo: Vec<(usize, f64)>,
}

impl EchoDelays {
    fn of(setting: &Setting<'_>, track: &TrackEchoes, start: &Values, offset_s: f64) -> Self {
        let sampler = track.path.sampler();
        let values = Values {
            delay_s: 0.0,
            ..start.clone()
        };
        let time_s = &track.profiles.time_s;
        let stride = time_s.len().div_ceil(MOST_TRACES).max(1);
        let mut echo = Vec::new();
        for trace in (0..time_s.len()).step_by(stride) {
            let Some(pose) = sampler.at(time_s[trace], offset_s) else {
                continue;
            };
            for reflector in setting.reflector_m {
                let c = setting.light_speed_m_s;
                let range_m = predict(&values, &pose, *reflector, c).range_m;
                echo.push((trace, 2.0 * range_m / c + track.known_delay_s));
            }
        }
        Self { echo }
    }

    /// Mean of ln(1 + (envelope/floor)²): strong clutter in some traces does not outweigh an echo in
    /// all of them. Echoes outside the record count as floor.
    fn stack(&self, profiles: &Profiles, delay_s: f64) -> f64 {
        if self.echo.is_empty() {
            return 0.0;
        }
        let sum: f64 = self
            .echo
            .iter()
            .map(|(trace, time_s)| {
                let contrast = profiles.contrast_at(*trace, time_s + delay_s);
                contrast.unwrap_or(1.0).powi(2).ln_1p()
            })
            .sum();
        sum / self.echo.len() as f64
    }
}

fn steps([from, to]: [f64; 2], step: f64) -> Vec<f64> {
    let count = ((to - from) / step).round() as usize;
    (0..=count).map(|k| from + k as f64 * step).collect()
}

fn highest(stack: &[f64], admitted: impl Fn(usize) -> bool) -> Option<usize> {
    (0..stack.len())
        .filter(|k| admitted(*k))
        .max_by(|a, b| stack[*a].total_cmp(&stack[*b]))
}
