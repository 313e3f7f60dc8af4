//! Focus of the surveyed reflectors: their echoes summed coherently over stretches of the track that see
//! them from one side, on a patch about each surveyed place.
//!
//! Survey, lever arm and positions may be off by decimetres. The echo still comes into focus, but next to the
//! surveyed place: the score is the level of the patch, less a penalty for the distance. The line of sight
//! turns by [`TURN_RAD`] at most within a stretch, so that errors which differ along the track move the focus
//! of each stretch separately.

use acerra_imaging::delay_sums::{DelaySums, EchoCurve, SumScratch};

use super::coupling::free_from_s;
use super::parameter::Values;
use super::track::{Setting, TrackEchoes};

/// Turn of the line of sight within a stretch (rad): the focus is then λ / (4 sin(turn / 2)) wide, 9 cm.
const TURN_RAD: f64 = 0.44;
/// Traces of a stretch that are summed where a grid of settings is tried.
const TRACES_A_STRETCH: usize = 48;
/// Fewest traces of a stretch.
const FEWEST_TRACES: usize = 4;
/// Radius of the patch, and the spacing of its points (m).
const PATCH_M: f64 = 0.36;
const PATCH_STEP_M: f64 = 0.04;
/// Combined error of survey, lever arm and positions (m), and the penalty for such a distance (a power
/// ratio's logarithm).
const PLACE_SIGMA_M: f64 = 0.15;
const PLACE_COST: f64 = 0.25;

/// Levels down to this are of echoes outside the record.
pub(super) const SILENT: f64 = -500.0;

/// Traces that see a reflector from one side.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// Number of the reflector.
    pub reflector: usize,
    /// Traces.
    pub traces: Vec<usize>,
    /// Weight of each: the path that it covers (m).
    pub weight: Vec<f64>,
}

/// Delay and clock offset at which a stretch is in focus.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Focus {
    /// Logarithm of the power of the mean echo, less the penalty for the distance from the surveyed place.
    pub level: f64,
    /// East and north from the surveyed place (m).
    pub off_m: [f64; 2],
}

/// The stretches in which a track sees each reflector, at the offset of the campaign.
pub(super) fn stretches(
    setting: &Setting<'_>,
    track: &TrackEchoes,
    values: &Values,
    offset_s: f64,
) -> Vec<Stretch> {
    let sampler = track.path.sampler();
    let time_s = &track.profiles.time_s;
    let centre = |t: &f64| Some(sampler.at(*t, offset_s)?.phase_centre_m(values.lever_arm_m));
    let centre_m: Vec<Option<[f64; 3]>> = time_s.iter().map(centre).collect();
    let mut all = Vec::new();
    for (reflector, place_m) in setting.reflector_m.iter().enumerate() {
        let mut first: Option<[f64; 3]> = None;
        let mut own: Vec<usize> = Vec::new();
        let mut finish = |own: &mut Vec<usize>| {
            let traces = std::mem::take(own);
            if traces.len() >= FEWEST_TRACES {
                let weight = path_m(&centre_m, &traces, track.at_rest);
                all.push(Stretch {
                    reflector,
                    traces,
                    weight,
                });
            }
        };
        for (trace, centre_m) in centre_m.iter().enumerate() {
            let Some(centre_m) = centre_m else { continue };
            let sight = direction(centre_m, place_m);
            let turned = first.is_some_and(|first| angle_rad(first, sight) > TURN_RAD);
            if first.is_none() || turned {
                finish(&mut own);
                first = Some(sight);
            }
            own.push(trace);
        }
        finish(&mut own);
    }
    all
}

/// The path that each trace covers, half the way to each neighbour (m); equal for all traces of a platform at
/// rest.
fn path_m(centre_m: &[Option<[f64; 3]>], traces: &[usize], at_rest: bool) -> Vec<f64> {
    if at_rest {
        return vec![1.0; traces.len()];
    }
    let step = |a: usize, b: usize| match (centre_m[traces[a]], centre_m[traces[b]]) {
        (Some(a), Some(b)) => distance(&a, &b),
        _ => 0.0,
    };
    let last = traces.len() - 1;
    (0..traces.len())
        .map(|k| 0.5 * step(k.saturating_sub(1), (k + 1).min(last)) + 1e-9)
        .collect()
}

/// A stretch as it is summed at one clock offset: where each of its traces was taken from.
#[derive(Debug)]
pub(super) struct Placed<'a> {
    stretch: &'a Stretch,
    /// Trace, its weight, and the phase centre (m).
    traces: Vec<(usize, f64, [f64; 3])>,
    known_delay_s: f64,
    /// Fast time from which echoes are free of the direct coupling (s).
    free_from_s: f64,
    /// Propagation speed over the apparent one.
    light_speed_m_s: f64,
    range_scale: f64,
}

impl<'a> Placed<'a> {
    /// Places the traces of a stretch at an offset: evenly spread ones where there are many, unless `all` are requested.
    pub fn at(
        stretch: &'a Stretch,
        setting: &Setting<'_>,
        track: &TrackEchoes,
        values: &Values,
        offset_s: f64,
        all: bool,
    ) -> Self {
        let sampler = track.path.sampler();
        let stride = if all {
            1
        } else {
            stretch.traces.len().div_ceil(TRACES_A_STRETCH)
        };
        let place = |k: usize| {
            let trace = stretch.traces[k];
            let pose = sampler.at(track.profiles.time_s[trace], offset_s)?;
            let centre_m = pose.phase_centre_m(values.lever_arm_m);
            Some((trace, stretch.weight[k], centre_m))
        };
        let picked = (0..stretch.traces.len()).step_by(stride);
        Self {
            stretch,
            traces: picked.filter_map(place).collect(),
            known_delay_s: track.known_delay_s,
            free_from_s: free_from_s(track.coupling),
            light_speed_m_s: setting.light_speed_m_s,
            range_scale: values.range_scale,
        }
    }

    /// Fast times of an echo from a place, without the delay (s).
    fn times_s(&self, place_m: [f64; 3]) -> Vec<f64> {
        let scale = 2.0 * (1.0 + self.range_scale) / self.light_speed_m_s;
        let time = |(_, _, centre_m): &(usize, f64, [f64; 3])| {
            scale * distance(centre_m, &place_m) + self.known_delay_s
        };
        self.traces.iter().map(time).collect()
    }

    /// Place at which the stretch is in focus at each of the sums' delays; [`SILENT`] where the echo would lie within the
    /// direct coupling. A platform at rest resolves no place.
    pub fn focus(
        &self,
        setting: &Setting<'_>,
        (sums, delay_s): (&DelaySums, &[f64]),
        at_rest: bool,
    ) -> Vec<Focus> {
        let place_m = setting.reflector_m[self.stretch.reflector];
        let trace: Vec<usize> = self.traces.iter().map(|(trace, _, _)| *trace).collect();
        let weight: Vec<f64> = self.traces.iter().map(|(_, weight, _)| *weight).collect();
        let total: f64 = weight.iter().sum();
        let scratch = &mut SumScratch::default();
        // Best power so far, less the penalty, and its place.
        let mut best = vec![(0.0, [0.0; 2]); delay_s.len()];
        for off_m in patch(at_rest) {
            let at_m = [place_m[0] + off_m[0], place_m[1] + off_m[1], place_m[2]];
            let curve = EchoCurve {
                trace: &trace,
                weight: &weight,
                time_s: &self.times_s(at_m),
            };
            let cost = PLACE_COST * squared(off_m) / PLACE_SIGMA_M.powi(2);
            let penalty = (-cost).exp();
            for (best, power) in best.iter_mut().zip(sums.powers(curve, scratch)) {
                if penalty * power > best.0 {
                    *best = (penalty * power, off_m);
                }
            }
        }
        let relative = |power: f64| power / (total * total).max(f64::MIN_POSITIVE);
        let level = |power: f64| relative(power).max(f64::MIN_POSITIVE).ln();
        let earliest_s = (self.times_s(place_m).into_iter()).fold(f64::INFINITY, f64::min);
        let found = |((power, off_m), delay_s): ((f64, [f64; 2]), &f64)| Focus {
            level: if earliest_s + delay_s < self.free_from_s {
                SILENT
            } else {
                level(power)
            },
            off_m,
        };
        best.into_iter().zip(delay_s).map(found).collect()
    }
}

/// Places about a surveyed one, east and north of it (m); that one alone for a platform at rest.
fn patch(at_rest: bool) -> impl Iterator<Item = [f64; 2]> {
    let steps = if at_rest {
        0
    } else {
        (PATCH_M / PATCH_STEP_M).round() as i32
    };
    let places = (-steps..=steps).flat_map(move |y| (-steps..=steps).map(move |x| [x, y]));
    places
        .map(|place| place.map(|i| f64::from(i) * PATCH_STEP_M))
        .filter(|off_m| squared(*off_m) <= PATCH_M * PATCH_M)
}

fn squared([x_m, y_m]: [f64; 2]) -> f64 {
    x_m * x_m + y_m * y_m
}

/// Fast times of the echo of a point in a stretch (s), by which its traces add up.
pub(super) fn curve_s(
    placed: &Placed<'_>,
    setting: &Setting<'_>,
    focus: Focus,
    delay_s: f64,
) -> Vec<(usize, f64, f64)> {
    let place_m = setting.reflector_m[placed.stretch.reflector];
    let at_m = [
        place_m[0] + focus.off_m[0],
        place_m[1] + focus.off_m[1],
        place_m[2],
    ];
    let times_s = placed.times_s(at_m);
    let with_time =
        |((trace, weight, _), t): (&(usize, f64, [f64; 3]), f64)| (*trace, *weight, t + delay_s);
    placed.traces.iter().zip(times_s).map(with_time).collect()
}

fn direction(from_m: &[f64; 3], to_m: &[f64; 3]) -> [f64; 3] {
    let length = distance(from_m, to_m).max(1e-9);
    [0, 1, 2].map(|i| (to_m[i] - from_m[i]) / length)
}

fn angle_rad(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cosine: f64 = (0..3).map(|i| a[i] * b[i]).sum();
    cosine.clamp(-1.0, 1.0).acos()
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
