//! Stage `align`: a position for every trace, and the selection of the traces that enter the image.

mod antennas;
pub mod calibration;
pub mod clock;
pub(crate) mod correction;
pub mod delay;
pub mod gate;
pub(crate) mod geometry;
pub mod offset;
pub mod overlap;
pub mod plane;
pub(crate) mod quantity;
pub mod radar_height;
pub mod radar_surface;
pub mod recording;
pub mod select;
pub(crate) mod uncovered;

use acerra_geo::interpolate::{Flag, Interpolated, InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::HeadingOptions;
use acerra_geo::trajectory::{Attitude, SolutionStatus, Trajectory};
use acerra_radar::RadargramError;

use crate::align::radar_height::{PoorHeights, RadarHeightError, radar_heights};
use crate::align::select::{SelectError, Selection};
use crate::choices::{HeightSource, Select, TimeOffset, Unfixed};
use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::position::aligned::{Aligned, HeightsReplaced};
use crate::position::boresight::{Boresights, DOWN, FORWARD};
use crate::position::informative::{is_informative, largest_informative_m};
use crate::read::RadarContent;
use crate::read::trace_positions::TracePositions;
use crate::scene::Scene;

/// Parameters of the stage `align`.
#[derive(Clone, Debug, Default)]
pub struct AlignOptions {
    /// Trajectory time minus radar time. By default the offset of the clock recorded with the radar log,
    /// where such a clock exists and the positions are on GPS time; otherwise 0.
    pub time_offset: Option<TimeOffset>,
    /// The traces that enter background and image.
    pub select: Select,
    /// Longest gap between positions that is interpolated over (s); by default a few sampling
    /// intervals.
    pub max_gap_s: Option<f64>,
    /// Treatment of traces at unfixed positions.
    pub unfixed: Unfixed,
    /// Source of the heights.
    pub height: HeightSource,
    /// Stated fast time of zero range (ns), for heights by the radar.
    pub delay_ns: Option<f64>,
    /// Lever arm that the positions contain: forward, left, up (m). The horizontal part of the lever arm
    /// turns with the heading, which hovering does not determine.
    pub lever_arm_m: [f64; 3],
    /// Vector from the receiver to a separate transmitter: forward, left, up (m).
    pub antenna_offset_m: Option<[f64; 3]>,
}

impl AlignOptions {
    /// The selection in force; all spectra are selected.
    fn select_of(&self, radar: &RadarContent) -> Select {
        match (self.select, radar) {
            (Select::Auto, RadarContent::Spectrum(_)) => Select::All,
            (select, _) => select,
        }
    }
}

/// Data of a track, their positions, and the ground below.
#[derive(Clone, Copy, Debug)]
pub struct Flight<'a> {
    /// The radar log.
    pub radar: &'a RadarContent,
    /// Positions of the radar.
    pub positions: &'a Positions,
    /// The scene below the flight.
    pub scene: &'a Scene,
}

/// Reason for which no trace can enter the image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlignError {
    /// Radar log and trajectory do not overlap in time.
    #[error(
        "radar log and trajectory do not overlap: with time_offset_s = {time_offset_s} the traces \
         fall on {:.3} to {:.3} s, the trajectory covers {:.3} to {:.3} s",
        traces_s[0], traces_s[1], trajectory_s[0], trajectory_s[1]
    )]
    NoOverlap {
        /// The offset in force (s).
        time_offset_s: f64,
        /// Trajectory time of the first and last trace (s).
        traces_s: [f64; 2],
        /// Start and end of the trajectory (s).
        trajectory_s: [f64; 2],
    },
    /// Traces have positions, but none of them is selected.
    #[error("no trace is left: {placed} have a position, none of them is selected")]
    NoneLeft {
        /// Number of traces with a position.
        placed: usize,
    },
    /// An invalid selection.
    #[error(transparent)]
    Select(#[from] SelectError),
    /// Heights by the radar cannot be found.
    #[error(transparent)]
    Height(#[from] RadarHeightError),
    /// Traces that the log does not contain.
    #[error(transparent)]
    Traces(#[from] RadargramError),
    /// The orientation of separate antennas is not known.
    #[error(
        "[radar] antenna_offset_m: expected attitudes, or traces that move along their line, found neither; state \
         transmitter_m and receiver_m in the file"
    )]
    NoHeading,
    /// A number of positions that differs from the number of traces.
    #[error("expected one position for each of the {traces} traces, found {positions}")]
    Positions {
        /// Traces in the log.
        traces: usize,
        /// Positions given.
        positions: usize,
    },
}

/// Assigns a position to every trace at a known offset, and selects the traces that enter the image.
///
/// # Errors
/// No overlap of radar log and trajectory, or no trace left.
pub fn align(
    flight: Flight<'_>,
    options: &AlignOptions,
    time_offset_s: f64,
    warnings: &mut Warnings,
) -> Result<Aligned, AlignError> {
    let radar_time_s = flight.radar.time_s();
    let (all, covered) = match flight.positions {
        Positions::PerTrace(places) => per_trace(radar_time_s, places)?,
        Positions::Trajectory(trajectory) => {
            let times_s: Vec<f64> = radar_time_s.iter().map(|t| t + time_offset_s).collect();
            let clock = OnTrajectory {
                times_s: &times_s,
                trajectory,
                time_offset_s,
            };
            clock.placed(options, warnings)?
        }
    };
    let mut speed_m_s = vec![None; radar_time_s.len()];
    for placed in &covered {
        speed_m_s[placed.trace] = placed.speed_m_s;
    }
    let selection = Selection::of(options.select_of(flight.radar), &speed_m_s)?;
    let kept: Vec<&Placed> = covered
        .iter()
        .filter(|p| selection.selected[p.trace])
        .collect();
    if kept.is_empty() {
        return Err(AlignError::NoneLeft {
            placed: covered.len(),
        });
    }
    warnings.count(
        kept.iter().filter(|p| is_held(options, p)).count(),
        "traces hover and have no attitude: the lever arm keeps its last direction there",
    );
    let position_m: Vec<[f64; 3]> = kept.iter().map(|p| p.place.position_m).collect();
    let sigma_m: Option<Vec<[f64; 3]>> = kept
        .iter()
        .map(|p| {
            p.place
                .covariance_m2
                .map(|c| [0, 1, 2].map(|i| c[i][i].max(0.0).sqrt()))
        })
        .collect();
    let attitudes: Vec<Option<Attitude>> = kept.iter().map(|p| p.place.attitude).collect();
    let gimbals: Vec<Option<Attitude>> = kept.iter().map(|p| p.place.gimbal).collect();
    let antennas_from_place_m = match flight.positions {
        Positions::PerTrace(places) => {
            let all = antennas::in_file(places, kept.iter().map(|p| p.trace));
            all.ok_or_else(|| AlignError::Positions {
                traces: places.position_m.len(),
                positions: places
                    .antennas_m
                    .iter()
                    .flatten()
                    .map(Vec::len)
                    .min()
                    .unwrap_or(0),
            })?
        }
        Positions::Trajectory(_) => Vec::new(),
    };
    let mut aligned = Aligned {
        antennas_from_place_m,
        line_starts: line_starts(flight.positions, &kept),
        traces: kept.iter().map(|p| p.trace).collect(),
        time_s: kept.iter().map(|p| radar_time_s[p.trace]).collect(),
        height_m: position_m
            .iter()
            .map(|p| p[2] - flight.scene.ground.below_m(p[0], p[1]))
            .collect(),
        path_m: Vec::new(),
        boresight: Boresights::of(&attitudes, DOWN),
        gimbal_down: Boresights::of(&gimbals, DOWN),
        gimbal_forward: Boresights::of(&gimbals, FORWARD),
        position_m,
        sigma_m: sigma_m.unwrap_or_default(),
        status: kept.iter().map(|p| p.place.status).collect(),
        all,
        is_often_at_rest: selection.is_often_at_rest,
        radar_height: None,
    };
    aligned.path_m = aligned.path_along_lines_m(&aligned.position_m);
    if let Some(offset_m) = options.antenna_offset_m {
        let (position_m, lines) = (&aligned.position_m, aligned.lines(0..kept.len()));
        aligned.antennas_from_place_m =
            antennas::by_offset(offset_m, position_m, &attitudes, &lines)
                .ok_or(AlignError::NoHeading)?;
    }
    match options.height {
        HeightSource::Positions => Ok(aligned),
        HeightSource::Radar => with_heights_by_radar(aligned, flight, options),
    }
}

/// Entries of `kept` at which a line begins: the entry before belongs to another line.
fn line_starts(positions: &Positions, kept: &[&Placed]) -> Vec<usize> {
    let Positions::PerTrace(places) = positions else {
        return Vec::new();
    };
    let line_of = |k: usize| line_of(&places.line_starts, kept[k].trace);
    (1..kept.len())
        .filter(|k| line_of(*k) != line_of(k - 1))
        .collect()
}

/// Number of the line of a trace.
fn line_of(line_starts: &[usize], trace: usize) -> usize {
    line_starts.partition_point(|start| *start <= trace)
}

/// Whether the lever arm of a trace uses an earlier heading.
fn is_held(options: &AlignOptions, placed: &Placed) -> bool {
    options.lever_arm_m[..2] != [0.0; 2]
        && placed.place.attitude.is_none()
        && placed.speed_m_s.unwrap_or(0.0) < HeadingOptions::default().min_speed_m_s
}

/// The interpolation of a trajectory over gaps of at most `max_gap_s`.
#[must_use]
pub fn interpolator(max_gap_s: Option<f64>, trajectory: &Trajectory) -> Interpolator<'_> {
    let mut options = InterpolationOptions::default();
    options.max_gap_s = max_gap_s;
    Interpolator::new(trajectory, &options)
}

/// Places of single traces of a log on a trajectory, at any clock offset.
pub(crate) struct TracePlaces<'a> {
    time_s: &'a [f64],
    at: Interpolator<'a>,
    keeps_unfixed: bool,
}

impl<'a> TracePlaces<'a> {
    /// `None` where positions depend on more than the trajectory: positions recorded with the traces, or
    /// heights by the radar.
    pub fn of(flight: Flight<'a>, options: &AlignOptions) -> Option<Self> {
        let (Positions::Trajectory(trajectory), HeightSource::Positions) =
            (flight.positions, options.height)
        else {
            return None;
        };
        Some(Self {
            time_s: flight.radar.time_s(),
            at: interpolator(options.max_gap_s, trajectory),
            keeps_unfixed: options.unfixed == Unfixed::Keep,
        })
    }

    /// Positions (m) of some traces, equal to those of [`align`]; `None` where one of the traces has no
    /// position.
    pub fn at(&self, traces: &[usize], time_offset_s: f64) -> Option<Vec<[f64; 3]>> {
        let place = |trace: &usize| {
            let place = self.at.at(self.time_s[*trace] + time_offset_s);
            is_taken(&place, self.keeps_unfixed).then_some(place.position_m)
        };
        traces.iter().map(place).collect()
    }
}

/// Whether a trace at a place may enter an image.
fn is_taken(place: &Interpolated, keeps_unfixed: bool) -> bool {
    place.flag == Flag::Ok || place.flag == Flag::Unfixed && keeps_unfixed
}

/// Share of the traces that may lie before or after the trajectory without a warning.
const MOMENT: f64 = 0.01;

/// Error for traces at other times than the positions.
fn no_overlap(time_offset_s: f64, traces_s: [f64; 2], trajectory: &Trajectory) -> AlignError {
    AlignError::NoOverlap {
        time_offset_s,
        traces_s,
        trajectory_s: [trajectory.start_s(), trajectory.end_s()],
    }
}

/// A trace with its place.
struct Placed {
    trace: usize,
    place: Interpolated,
    /// Horizontal speed (m/s), averaged over half a second; `None` where the position is much worse than
    /// others.
    speed_m_s: Option<f64>,
}

/// Traces at times of a trajectory.
struct OnTrajectory<'a> {
    times_s: &'a [f64],
    trajectory: &'a Trajectory,
    time_offset_s: f64,
}

impl OnTrajectory<'_> {
    fn placed(
        &self,
        options: &AlignOptions,
        warnings: &mut Warnings,
    ) -> Result<(Vec<Interpolated>, Vec<Placed>), AlignError> {
        let at = interpolator(options.max_gap_s, self.trajectory);
        let (places, coverage) = at.at_all(self.times_s);
        if !places.iter().any(|place| place.flag.is_covered()) {
            let ends = [self.times_s.first(), self.times_s.last()];
            let traces_s = ends.map(|t| t.copied().unwrap_or(f64::NAN));
            return Err(no_overlap(self.time_offset_s, traces_s, self.trajectory));
        }
        let outside = coverage.count(Flag::BeforeStart) + coverage.count(Flag::AfterEnd);
        // A radar log slightly longer than the trajectory is normal; the finding `trajectory_coverage` still
        // counts these traces.
        if outside as f64 > MOMENT * self.times_s.len() as f64 {
            warnings.count(
                outside,
                "traces lie before or after the trajectory and were left out",
            );
        }
        warnings.count(
            coverage.count(Flag::InGap),
            format!(
                "traces fall into gaps of the trajectory longer than {:.2} s and were left out",
                coverage.max_gap_s
            ),
        );
        let keep_unfixed = options.unfixed == Unfixed::Keep;
        let largest_m = largest_informative_m(self.trajectory);
        warnings.count(
            coverage.count(Flag::Unfixed),
            if keep_unfixed {
                "traces are at unfixed positions and are used"
            } else {
                "traces are at unfixed positions and were left out"
            },
        );
        let placed = places
            .iter()
            .enumerate()
            .filter(|(_, place)| is_taken(place, keep_unfixed))
            .map(|(trace, place)| {
                let ends = [-0.25, 0.25].map(|d| at.at(place.time_s + d));
                let is_used = |p: &Interpolated| is_informative(p.covariance_m2, largest_m);
                let [before, after] = ends.map(|p| p.position_m);
                let speed_m_s = (after[0] - before[0]).hypot(after[1] - before[1]) / 0.5;
                Placed {
                    trace,
                    place: *place,
                    speed_m_s: ends.iter().all(is_used).then_some(speed_m_s),
                }
            })
            .collect();
        Ok((places, placed))
    }
}

/// Positions recorded with the traces.
fn per_trace(
    time_s: &[f64],
    places: &TracePositions,
) -> Result<(Vec<Interpolated>, Vec<Placed>), AlignError> {
    let position_m = &places.position_m;
    if time_s.len() != position_m.len() {
        return Err(AlignError::Positions {
            traces: time_s.len(),
            positions: position_m.len(),
        });
    }
    let starts = &places.line_starts;
    let near = |trace: usize, sign: f64| {
        // The trace about a quarter of a second away, or the last one of the line on that side.
        let wanted = time_s[trace] + sign * 0.25;
        let line = line_of(starts, trace);
        let first = line.checked_sub(1).map_or(0, |k| starts[k]);
        let end = starts.get(line).copied().unwrap_or(time_s.len());
        let k = time_s.partition_point(|s| *s < wanted);
        k.max(first).min(end.min(time_s.len()) - 1)
    };
    let speed_m_s = |trace: usize| {
        let (a, b) = (near(trace, -1.0), near(trace, 1.0));
        let seconds = time_s[b] - time_s[a];
        let [dx, dy] = [0, 1].map(|i| position_m[b][i] - position_m[a][i]);
        if seconds > 0.0 {
            dx.hypot(dy) / seconds
        } else {
            0.0
        }
    };
    let place = |t: f64, p: [f64; 3]| Interpolated {
        time_s: t,
        position_m: p,
        velocity_m_s: [0.0; 3],
        covariance_m2: None,
        attitude: None,
        gimbal: None,
        status: SolutionStatus::External,
        flag: Flag::Ok,
    };
    let all: Vec<Interpolated> = time_s
        .iter()
        .zip(position_m)
        .map(|(t, p)| place(*t, *p))
        .collect();
    let placed = all
        .iter()
        .enumerate()
        .map(|(trace, place)| Placed {
            trace,
            place: *place,
            speed_m_s: Some(speed_m_s(trace)),
        })
        .collect();
    Ok((all, placed))
}
/// Replaces the positions' heights of the traces by heights that the radar measures.
fn with_heights_by_radar(
    mut aligned: Aligned,
    flight: Flight<'_>,
    options: &AlignOptions,
) -> Result<Aligned, AlignError> {
    let RadarContent::Radargram(radargram) = flight.radar else {
        return Err(RadarHeightError::Spectra.into());
    };
    let poor = PoorHeights {
        radargram: &radargram.select(&aligned.traces)?,
        height_m: &aligned.height_m,
        delay_s: options.delay_ns.map(|ns| 1e-9 * ns),
    };
    let found = radar_heights(poor, flight.scene)?;
    let mut stated_m: Vec<f64> = aligned.sigma_m.iter().map(|sigma| sigma[2]).collect();
    stated_m.sort_by(f64::total_cmp);
    for (position, (old, new)) in aligned
        .position_m
        .iter_mut()
        .zip(aligned.height_m.iter().zip(&found.height_m))
    {
        position[2] += new - old;
    }
    aligned
        .sigma_m
        .iter_mut()
        .for_each(|s| s[2] = found.sigma_m);
    aligned.path_m = aligned.path_along_lines_m(&aligned.position_m);
    aligned.height_m = found.height_m;
    aligned.radar_height = Some(HeightsReplaced {
        positions_off_m: found.positions_off_m,
        stated_m: stated_m.get(stated_m.len() / 2).copied(),
        sigma_m: found.sigma_m,
        picked: found.picked,
    });
    Ok(aligned)
}
