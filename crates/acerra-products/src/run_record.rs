//! `targets.json` and `run.json`, typed.

use acerra_chain::Track;
use acerra_chain::align::calibration::TrackCalibration;
use acerra_chain::align::delay::{DelayCue, DelayFound};
use acerra_chain::align::offset::{Curve, OffsetSearch};
use acerra_chain::campaign::Campaign;
use acerra_chain::choices::{GroundSurface, Permittivity};
use acerra_chain::clean::{CleanedTraces, Surface};
use acerra_chain::findings::{Evidence, Finding, Unchecked};
use acerra_chain::focus::inversion::InversionRecord;
use acerra_chain::focus::permittivity::PermittivityFound;
use acerra_chain::journal::stages::Stage;

use acerra_chain::position::Positions;
use acerra_chain::read::inputs::InputFile;
use acerra_imaging::metrics::{ImageStatistics, Target};
use acerra_radar::LoggedClock;
use serde::Serialize;

use crate::outcome::Outcome;
use crate::surveyed::SurveyRecord;
use crate::uncertainty::place_sigma;

/// `targets.json`: the targets of the image.
#[derive(Clone, Debug, Serialize)]
pub struct TargetsRecord<'a> {
    /// Targets, strongest first.
    pub targets: Vec<TargetRecord<'a>>,
    /// The frame of their coordinates.
    pub frame: FrameRecord,
    /// Levels of the image as a whole.
    pub image: &'a ImageStatistics,
    /// Fate of the local maxima.
    pub maxima: MaximaRecord,
    /// Surveyed points, and the target nearest to each.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub surveyed: &'a [SurveyRecord],
}

/// A target, its place on the Earth, and the uncertainty of the place.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TargetRecord<'a> {
    /// The target in the image's frame.
    #[serde(flatten)]
    pub target: &'a Target,
    /// Latitude and longitude (degrees) and ellipsoidal height (m); absent where the frame's place on
    /// the Earth is not known.
    pub place_deg_m: Option<[f64; 3]>,
    /// Height above the geoid (m), where `[image] geoid` names a grid that covers the place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_above_geoid_m: Option<f64>,
    /// Standard deviation along and across the track (m), by the stated errors of positions and clock offset;
    /// an error of the delay is not included.
    pub sigma_along_across_m: Option<[f64; 2]>,
    /// Depth below the surface of `[ground]` (m), of targets below it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
    /// Its standard deviation (m), by the distance of the volume's slices, the deviation that the heights of
    /// the positions state, and that of the permittivity where it was found or the finding
    /// `ground_permittivity` gives one; an error of the delay is not included.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_sigma_m: Option<f64>,
    /// Whether the target exceeds the clutter at its depth by more than chance, of targets below ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exceeds_clutter: Option<bool>,
}

/// Depth of a target below the surface of `[ground]`, and its standard deviation (m).
///
/// An antenna that hangs higher than is stated by δ makes targets below it deeper by δ/n, n being the refractive index.
#[must_use]
pub fn depth_of(outcome: &Outcome, target: &Target) -> Option<[f64; 2]> {
    let ground = outcome.campaign.ground.as_ref()?;
    let surface_z_m = match ground.surface {
        GroundSurface::Level => ground.surface_z_m,
        GroundSurface::Terrain | GroundSurface::Radar => outcome
            .prepared
            .scene
            .ground
            .below_m(target.x_m, target.y_m),
    };
    let depth_m = surface_z_m - target.z_m;
    if depth_m <= 0.0 {
        return None;
    }
    let slices_m = (outcome.focused.projections.as_ref()).map_or(0.0, |p| p.volume.step_m);
    let heights: Vec<f64> = (outcome.prepared.aligned.sigma_m.iter())
        .map(|s| s[2])
        .collect();
    let height_sigma_m = heights.iter().sum::<f64>() / heights.len().max(1) as f64;
    let top = ground
        .layer
        .first()
        .map(|layer| layer.relative_permittivity);
    let one = ground.relative_permittivity.and_then(Permittivity::given);
    let index = one.or(top).unwrap_or(1.0).sqrt();
    let sigma_m = (slices_m / 12f64.sqrt()).hypot(height_sigma_m / index);
    let soil_sigma_m = 0.5 * depth_m * permittivity_sigma(outcome).unwrap_or(0.0);
    Some([depth_m, sigma_m.hypot(soil_sigma_m)])
}

/// Relative standard deviation of the permittivity, as found or by the evidence: depth is proportional to its
/// square root.
fn permittivity_sigma(outcome: &Outcome) -> Option<f64> {
    if let Some(found) = outcome.prepared.permittivity {
        return Some(found.sigma / found.value);
    }
    let is_of_soil = |finding: &&Finding| finding.name == "ground_permittivity";
    let finding = outcome.evidence.findings().iter().find(is_of_soil)?;
    Some(finding.sigma? / finding.value?)
}

impl<'a> TargetRecord<'a> {
    fn of(outcome: &Outcome, k: usize, target: &'a Target) -> Self {
        let frame = outcome.prepared.first().positions.earth_frame();
        let place = frame.map(|f| f.geodetic_from_enu([target.x_m, target.y_m, target.z_m]));
        let sigma = place_sigma(&outcome.prepared, target);
        let depth = depth_of(outcome, target);
        Self {
            depth_m: depth.map(|[depth_m, _]| depth_m),
            depth_sigma_m: depth.map(|[_, sigma_m]| sigma_m),
            exceeds_clutter: outcome.exceeds_clutter.get(k).copied(),
            target,
            place_deg_m: place.map(|p| [p.latitude_deg(), p.longitude_deg(), p.height_m]),
            height_above_geoid_m: place.and_then(|p| outcome.above_sea_m(&p)),
            sigma_along_across_m: sigma.map(|s| [s.along_m, s.across_m]),
        }
    }
}

/// Fate of the local maxima of an image.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MaximaRecord {
    /// Number of maxima above the threshold.
    pub above_threshold: usize,
    /// Number of maxima at the level of the clutter about them.
    pub clutter: usize,
    /// Number of maxima explained as sidelobes of a target.
    pub sidelobes: usize,
    /// Number of maxima taken for ghosts.
    pub ghosts: usize,
    /// Number of maxima not examined.
    pub not_examined: usize,
}

/// `run.json`: processing, inputs and cost of a run.
#[derive(Clone, Debug, Serialize)]
pub struct RunRecord<'a> {
    /// Version of the program.
    pub version: &'static str,
    /// Findings of the run on its settings.
    pub evidence: &'a Evidence,
    /// Settings that no data check.
    pub unchecked: &'a [Unchecked],
    /// The campaign, every default filled in.
    pub configuration: &'a Campaign,
    /// The files that were read.
    pub inputs: &'a [InputFile],
    /// Cost of each stage.
    pub stages: &'a [Stage],
    /// Remarks on the result.
    pub warnings: &'a [String],
    /// Harmless omissions.
    pub notes: &'a [String],
    /// Trajectory time minus radar time of the first track (s).
    pub time_offset_s: f64,
    /// Search of the offset, where it was not given.
    pub time_offset_search: Option<SearchRecord<'a>>,
    /// The clock recorded with the radar log of the first track, where the offset is by this clock.
    pub recorded_clock: Option<&'a LoggedClock>,
    /// How the fast time at which range is zero was found in the first track, where the campaign left it
    /// open.
    pub delay_search: Option<DelayRecord>,
    /// The shift of fast time.
    pub zero_timing: ZeroTimingRecord,
    /// The frame of all coordinates.
    pub frame: FrameRecord,
    /// The height of the ground, where it was found from the data: the height and its standard
    /// deviation (m).
    pub ground_found_m: Option<[f64; 2]>,
    /// The permittivity of the ground, where it was found from the data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub permittivity_found: Option<PermittivityFound>,
    /// The traces that entered the image.
    pub traces: TracesRecord,
    /// The tracks of a campaign that lists them.
    pub tracks: Vec<TrackRecord<'a>>,
    /// First and last trace of each look.
    pub looks: Option<&'a [[usize; 2]]>,
    /// Solution for the scene, where `[image] method` is not the adjoint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inversion: Option<&'a InversionRecord>,
    /// Choices of the planner, and their reasons.
    pub plan: &'a str,
    /// Relative L2 error that the plan's self-check found.
    pub plan_checked_error: Option<f64>,
    /// Memory of the image.
    pub memory: MemoryRecord,
}

/// The search of a clock offset.
#[derive(Clone, Debug, Serialize)]
pub struct SearchRecord<'a> {
    /// The offset taken (s).
    pub time_offset_s: f64,
    /// Standard deviation of the offset taken (s).
    pub sigma_s: f64,
    /// The most likely other offset (s), and the log-likelihood by which it is surpassed.
    pub second: Option<[f64; 2]>,
    /// The offset by the height of the surface echo alone (s).
    pub height_offset_s: Option<f64>,
    /// The offset by motion alone (s).
    pub motion_offset_s: Option<f64>,
    /// Share of the radargram's change that the speed explains there.
    pub motion_explained: Option<f64>,
    /// The offset by the sharpness of images alone, and its standard deviation (s).
    pub sharpness_offset_s: Option<[f64; 2]>,
    /// The fast time at which range is zero by the surface echo, and its standard deviation (ns).
    pub delay_ns: Option<[f64; 2]>,
    /// Sharpness of the images about the offsets that height and motion leave.
    pub sharpness: CurveRecord<'a>,
}

/// A score over the offsets tried.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CurveRecord<'a> {
    /// Offsets (s), rising.
    pub offset_s: &'a [f64],
    /// Scores.
    pub score: &'a [f64],
}

/// The search of the fast time at which range is zero.
#[derive(Clone, Debug, Serialize)]
pub struct DelayRecord {
    /// The delay taken (ns).
    pub delay_ns: f64,
    /// Standard deviation of the delay taken (ns).
    pub sigma_ns: f64,
    /// The most likely other delay (ns), and the log-likelihood by which it is surpassed.
    pub second: Option<[f64; 2]>,
    /// The delay by the echo that follows the height, and its standard deviation (ns).
    pub surface_ns: Option<[f64; 2]>,
    /// The delay by the direct coupling, and its standard deviation (ns).
    pub coupling_ns: Option<[f64; 2]>,
    /// Delays tried (ns), rising.
    pub tried_ns: Vec<f64>,
    /// Log-likelihoods of the delays tried, by sharpness and echoes together.
    pub log_likelihood: Vec<f64>,
}

/// The shift of fast time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ZeroTimingRecord {
    /// Added to fast time (ns).
    pub shift_ns: Option<f64>,
    /// The surface echo against the height.
    pub surface: Option<SurfaceRecord>,
}

/// The surface echo against the height.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SurfaceRecord {
    /// Median of the echo less 2h/c (s).
    pub median_residual_s: Option<f64>,
    /// Median distance from that median (s).
    pub spread_s: Option<f64>,
    /// Level of the echo above everything else that was tried (dB).
    pub contrast_db: f64,
}

/// The frame of all coordinates.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrameRecord {
    /// `"enu"`, east, north and up about an origin on the Earth; or `"local"`, x, y and z as the
    /// positions state them.
    pub kind: &'static str,
    /// Latitude and longitude (degrees) and ellipsoidal height (m) of the origin.
    pub origin_deg_m: Option<[f64; 3]>,
}

/// The traces that entered the image.
#[derive(Clone, Debug, Serialize)]
pub struct TracesRecord {
    /// Traces in all logs.
    pub in_log: usize,
    /// Traces imaged.
    pub selected: usize,
    /// Number of the first.
    pub first: Option<usize>,
    /// Number of the last.
    pub last: Option<usize>,
    /// Rows of `trajectory.csv`, counted from 0, with which a line or a track begins, other than the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub line_starts: Vec<usize>,
}

/// Traces of all logs, track after track, with which a line or a track begins, other than the first.
fn line_starts(tracks: &[Track]) -> Vec<usize> {
    let mut starts = Vec::new();
    let mut before = 0;
    for track in tracks {
        starts.push(before);
        if let Positions::PerTrace(places) = &track.positions {
            starts.extend(places.line_starts.iter().map(|start| before + start));
        }
        before += track.traces_in_log;
    }
    starts.split_off(starts.len().min(1))
}

/// A track.
#[derive(Clone, Debug, Serialize)]
pub struct TrackRecord<'a> {
    /// Name of the track.
    pub name: &'a str,
    /// Traces in its log.
    pub traces_in_log: usize,
    /// Traces imaged.
    pub selected: usize,
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// The clock recorded with its radar log, where the offset is by this clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recorded_clock: Option<&'a LoggedClock>,
    /// Added to fast time (ns).
    pub shift_ns: Option<f64>,
    /// Delay and phase taken off.
    pub calibration: TrackCalibration,
}

/// Memory of the image.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MemoryRecord {
    /// Bytes that the plan needs in addition to the input.
    pub promised_bytes: u64,
    /// Bytes of the image itself.
    pub image_bytes: usize,
}

impl<'a> TargetsRecord<'a> {
    /// Levels of the image of a run.
    #[must_use]
    pub fn of(outcome: &'a Outcome) -> Self {
        let measured = &outcome.measured;
        Self {
            targets: measured
                .targets
                .iter()
                .enumerate()
                .map(|(k, target)| TargetRecord::of(outcome, k, target))
                .collect(),
            frame: FrameRecord::of(&outcome.prepared.first().positions),
            image: &measured.statistics,
            maxima: MaximaRecord {
                above_threshold: measured.maxima,
                clutter: measured.clutter,
                sidelobes: measured.sidelobes,
                ghosts: measured.ghosts,
                not_examined: measured.skipped,
            },
            surveyed: &outcome.surveyed,
        }
    }
}

impl<'a> RunRecord<'a> {
    /// The record of a run and of the cost of its stages.
    #[must_use]
    pub fn of(outcome: &'a Outcome, stages: &'a [Stage]) -> Self {
        let prepared = &outcome.prepared;
        let first = prepared.first();
        let cleaned = prepared.cleaned();
        let focused = &outcome.focused;
        let traces = &prepared.aligned.traces;
        Self {
            version: env!("CARGO_PKG_VERSION"),
            evidence: &outcome.evidence,
            unchecked: &outcome.unchecked,
            configuration: &outcome.campaign,
            inputs: &outcome.inputs,
            stages,
            warnings: &outcome.warnings,
            notes: &outcome.notes,
            time_offset_s: first.time_offset_s,
            time_offset_search: first.search.as_ref().map(SearchRecord::of),
            recorded_clock: first.recorded_clock.as_ref(),
            delay_search: first.delay.as_ref().map(DelayRecord::of),
            zero_timing: ZeroTimingRecord {
                shift_ns: cleaned.map(shift_ns),
                surface: cleaned
                    .and_then(|traces| traces.surface.as_ref())
                    .map(SurfaceRecord::of),
            },
            frame: FrameRecord::of(&first.positions),
            ground_found_m: prepared.ground.map(|found| [found.z_m, found.sigma_m]),
            permittivity_found: prepared.permittivity,
            traces: TracesRecord {
                in_log: prepared.traces_in_log(),
                selected: traces.len(),
                first: traces.first().copied(),
                last: traces.last().copied(),
                line_starts: line_starts(&prepared.tracks),
            },
            tracks: outcome
                .listed_tracks()
                .iter()
                .map(TrackRecord::of)
                .collect(),
            looks: focused.multilook.as_ref().map(|m| m.traces.as_slice()),
            inversion: focused.inversion.as_ref(),
            plan: &focused.plan,
            plan_checked_error: focused.checked_error,
            memory: MemoryRecord {
                promised_bytes: focused.promised_bytes,
                image_bytes: focused.image.len() * 8,
            },
        }
    }
}

impl<'a> SearchRecord<'a> {
    fn of(search: &'a OffsetSearch) -> Self {
        let estimate = &search.estimate;
        let (height, motion) = (&search.likelihood.height, &search.likelihood.motion);
        Self {
            time_offset_s: estimate.offset_s,
            sigma_s: estimate.sigma_s,
            second: estimate.second.map(|(offset_s, below)| [offset_s, below]),
            height_offset_s: height.as_ref().map(|cue| cue.offset_s),
            motion_offset_s: motion.as_ref().map(|cue| cue.offset_s),
            motion_explained: motion.as_ref().map(|cue| cue.explained),
            sharpness_offset_s: estimate
                .sharpness
                .as_ref()
                .map(|cue| [cue.offset_s, cue.sigma_s]),
            delay_ns: estimate
                .delay_s
                .map(|(delay_s, sigma_s)| [delay_s * 1e9, sigma_s * 1e9]),
            sharpness: CurveRecord::of(&search.sharpness),
        }
    }
}

impl<'a> CurveRecord<'a> {
    fn of(curve: &'a Curve) -> Self {
        Self {
            offset_s: &curve.offset_s,
            score: &curve.score,
        }
    }
}

impl DelayRecord {
    fn of(found: &DelayFound) -> Self {
        let ns = |cue: DelayCue| [cue.delay_s, cue.sigma_s].map(|s| s * 1e9);
        Self {
            delay_ns: found.delay_s * 1e9,
            sigma_ns: found.sigma_s * 1e9,
            second: found.second.map(|(delay_s, below)| [delay_s * 1e9, below]),
            surface_ns: found.surface.map(ns),
            coupling_ns: found.coupling.map(ns),
            tried_ns: found.curve.delay_s.iter().map(|d| d * 1e9).collect(),
            log_likelihood: found.curve.log_likelihood.clone(),
        }
    }
}

impl FrameRecord {
    fn of(positions: &Positions) -> Self {
        match positions.earth_frame() {
            Some(frame) => {
                let origin = frame.origin();
                Self {
                    kind: "enu",
                    origin_deg_m: Some([
                        origin.latitude_rad.to_degrees(),
                        origin.longitude_rad.to_degrees(),
                        origin.height_m,
                    ]),
                }
            }
            None => Self {
                kind: "local",
                origin_deg_m: None,
            },
        }
    }
}

impl SurfaceRecord {
    fn of(surface: &Surface) -> Self {
        Self {
            median_residual_s: surface.median_residual_s,
            spread_s: surface.spread_s,
            contrast_db: surface.contrast_db,
        }
    }
}

impl<'a> TrackRecord<'a> {
    fn of(track: &'a Track) -> Self {
        Self {
            name: &track.name,
            traces_in_log: track.traces_in_log,
            selected: track.range.len(),
            time_offset_s: track.time_offset_s,
            recorded_clock: track.recorded_clock.as_ref(),
            shift_ns: track.cleaned.as_ref().map(shift_ns),
            calibration: track.calibration,
        }
    }
}

fn shift_ns(traces: &CleanedTraces) -> f64 {
    traces.shift_s * 1e9
}
