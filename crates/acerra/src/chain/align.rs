//! Stage `align`: a position for every trace, and which traces enter the image.

use acerra_geo::interpolate::{
    Flag, Interpolated, InterpolationOptions, Interpolator, path_length_per_trace_m,
};
use acerra_geo::lever_arm::HeadingOptions;
use acerra_geo::trajectory::{SolutionStatus, Trajectory};
use anyhow::bail;

use acerra_radar::{MovingOptions, moving_traces};

use super::ground::Site;
use super::offset::OffsetSearch;
use super::position::Positions;
use super::warnings::Warnings;
use crate::campaign::{Campaign, Select, Unfixed};

/// The traces that enter the image, with their positions. All lists have one entry a trace.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// How the offset was found, when it was not given.
    pub search: Option<OffsetSearch>,
    /// Numbers of the traces in the log.
    pub traces: Vec<usize>,
    /// Their radar time (s).
    pub time_s: Vec<f64>,
    /// Place of the phase centre: east, north, up (m).
    pub position_m: Vec<[f64; 3]>,
    /// Standard deviations of the places (m); empty where the trajectory does not tell.
    pub sigma_m: Vec<[f64; 3]>,
    /// Solution status.
    pub status: Vec<SolutionStatus>,
    /// Height of the phase centre above the ground below it (m).
    pub height_m: Vec<f64>,
    /// Path that each trace stands for (m).
    pub path_m: Vec<f64>,
    /// The places of all traces of the log, with what stands behind each.
    pub all: Vec<Interpolated>,
}

/// Gives every trace its position at a known offset, and selects.
///
/// # Errors
/// No overlap of radar log and trajectory, or no trace left.
pub fn align(
    campaign: &Campaign,
    radar_time_s: &[f64],
    site: Site<'_>,
    time_offset_s: f64,
    warnings: &mut Warnings,
) -> anyhow::Result<Aligned> {
    let Site { positions, ground } = site;
    let (all, covered) = match positions {
        Positions::PerTrace(position_m) => per_trace(radar_time_s, position_m),
        Positions::Trajectory(trajectory) => {
            on_trajectory(campaign, radar_time_s, trajectory, time_offset_s, warnings)?
        }
    };
    let selected = select(campaign, radar_time_s.len(), &covered)?;
    let kept: Vec<&Placed> = covered.iter().filter(|p| selected[p.trace]).collect();
    if kept.is_empty() {
        bail!(
            "no trace is left: {} have a position, none of them is selected",
            covered.len()
        );
    }
    warnings.count(
        kept.iter().filter(|p| is_held(campaign, p)).count(),
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
    Ok(Aligned {
        time_offset_s,
        search: None,
        traces: kept.iter().map(|p| p.trace).collect(),
        time_s: kept.iter().map(|p| radar_time_s[p.trace]).collect(),
        height_m: position_m
            .iter()
            .map(|p| p[2] - ground.below_m(p[0], p[1]))
            .collect(),
        path_m: path_length_per_trace_m(&position_m),
        position_m,
        sigma_m: sigma_m.unwrap_or_default(),
        status: kept.iter().map(|p| p.place.status).collect(),
        all,
    })
}

/// Whether the lever arm of a trace rests on a heading from before.
fn is_held(campaign: &Campaign, placed: &Placed) -> bool {
    let [forward, left, _] = campaign.trajectory.lever_arm_m;
    (forward != 0.0 || left != 0.0)
        && placed.place.attitude.is_none()
        && placed.speed_m_s < HeadingOptions::default().min_speed_m_s
}

/// The interpolation that a campaign asks for.
#[must_use]
pub fn interpolator<'a>(campaign: &Campaign, trajectory: &'a Trajectory) -> Interpolator<'a> {
    let mut options = InterpolationOptions::default();
    options.max_gap_s = campaign.trajectory.max_gap_s;
    Interpolator::new(trajectory, &options)
}

/// A trace with its place.
struct Placed {
    trace: usize,
    place: Interpolated,
    /// Horizontal speed (m/s), averaged over half a second.
    speed_m_s: f64,
}

fn on_trajectory(
    campaign: &Campaign,
    radar_time_s: &[f64],
    trajectory: &Trajectory,
    time_offset_s: f64,
    warnings: &mut Warnings,
) -> anyhow::Result<(Vec<Interpolated>, Vec<Placed>)> {
    let at = interpolator(campaign, trajectory);
    let times_s: Vec<f64> = radar_time_s.iter().map(|t| t + time_offset_s).collect();
    let (places, coverage) = at.at_all(&times_s);
    if !places.iter().any(|place| place.flag.is_covered()) {
        bail!(
            "radar log and trajectory do not overlap: with time_offset_s = {time_offset_s} the \
             traces fall on {:.3} to {:.3} s, the trajectory covers {:.3} to {:.3} s",
            times_s.first().copied().unwrap_or(f64::NAN),
            times_s.last().copied().unwrap_or(f64::NAN),
            trajectory.start_s(),
            trajectory.end_s(),
        );
    }
    let outside = coverage.count(Flag::BeforeStart) + coverage.count(Flag::AfterEnd);
    warnings.count(
        outside,
        "traces lie before or after the trajectory and were left out",
    );
    warnings.count(
        coverage.count(Flag::InGap),
        format!(
            "traces fall into gaps of the trajectory longer than {:.2} s and were left out",
            coverage.max_gap_s
        ),
    );
    let keep_unfixed = campaign.trajectory.unfixed == Unfixed::Keep;
    warnings.count(
        coverage.count(Flag::Unfixed),
        if keep_unfixed {
            "traces stand at unfixed positions and entered all the same"
        } else {
            "traces stand at unfixed positions and were left out"
        },
    );
    let placed = places
        .iter()
        .enumerate()
        .filter(|(_, place)| place.flag == Flag::Ok || place.flag == Flag::Unfixed && keep_unfixed)
        .map(|(trace, place)| {
            let [before, after] = [-0.25, 0.25].map(|d| at.at(place.time_s + d).position_m);
            let speed_m_s = (after[0] - before[0]).hypot(after[1] - before[1]) / 0.5;
            Placed {
                trace,
                place: *place,
                speed_m_s,
            }
        })
        .collect();
    Ok((places, placed))
}

/// Positions that came with the traces.
fn per_trace(time_s: &[f64], position_m: &[[f64; 3]]) -> (Vec<Interpolated>, Vec<Placed>) {
    let near = |t: f64, sign: f64| {
        // The trace about a quarter of a second away, or the last one on that side.
        let wanted = t + sign * 0.25;
        let k = time_s.partition_point(|s| *s < wanted);
        k.min(time_s.len() - 1)
    };
    let speed_m_s = |t: f64| {
        let (a, b) = (near(t, -1.0), near(t, 1.0));
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
            speed_m_s: speed_m_s(place.time_s),
        })
        .collect();
    (all, placed)
}

/// Which traces of the log `[radar] select` takes.
fn select(campaign: &Campaign, traces: usize, placed: &[Placed]) -> anyhow::Result<Vec<bool>> {
    let mut selected = vec![false; traces];
    match campaign.radar.select {
        Select::All => selected.fill(true),
        Select::Range([first, last]) => {
            if last >= traces {
                bail!(
                    "[radar] select: expected trace numbers below {traces}, the traces of the \
                     log, found {last}"
                );
            }
            selected[first..=last].fill(true);
        }
        Select::Moving => {
            let mut speed_m_s = vec![f64::NAN; traces];
            for p in placed {
                speed_m_s[p.trace] = p.speed_m_s;
            }
            let moving = moving_traces(&speed_m_s, &MovingOptions::default());
            if moving.is_empty() {
                bail!("[radar] select = \"moving\": the platform never moves over ground");
            }
            selected[moving].fill(true);
        }
    }
    Ok(selected)
}
