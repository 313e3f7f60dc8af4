//! Stage `position`: the trajectory of the positioned point in the image's frame.

pub mod aligned;
pub mod attitude_file;
pub mod boresight;
pub mod clock_shift;
pub(crate) mod height_noise;
pub(crate) mod informative;
pub mod positioning;
pub mod trace_numbers;
pub mod trajectory_file;

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use acerra_autopilot::{GimbalChoice, LogOptions, LogReport};
use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::lever_arm::{HeadingOptions, LeverArmError, apply_lever_arm};
use acerra_geo::trajectory::{Frame, StatusCounts, TimeOrigin, Trajectory, TrajectoryError};
use acerra_gnss::{BasePosition, PositioningMode, PpkOptions};

use crate::choices::HeightDatum;
use crate::journal::warnings::Warnings;
use crate::position::attitude_file::{AttitudeFileError, AttitudesSeen, with_log_attitudes};
use crate::position::positioning::{
    GnssConfiguration, GnssConfigurationError, PositioningError, PositioningInput,
};
use crate::position::trace_numbers::{TraceNumberError, at_traces};
use crate::position::trajectory_file::{
    TrajectoryFileError, TrajectoryFileOptions, read_trajectory_file,
};
use crate::read::name_of;
use crate::read::trace_positions::TracePositions;

/// Positions of the radar's phase centre.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a survey holds one value for each track"
)]
pub enum Positions {
    /// A trajectory with its clock.
    Trajectory(Box<Trajectory>),
    /// One position for each trace, on the traces' own clock.
    PerTrace(TracePositions),
}

/// Positions of a track, and the meaning of their axes.
#[derive(Clone, Debug)]
pub struct Positioned {
    /// The positions.
    pub positions: Positions,
    /// Whether a trajectory file gives positions in a local frame, with an origin on the Earth or without.
    pub has_local_axes: bool,
    /// Sources of the positions in autopilots' logs.
    pub log_sources: LogSources,
    /// Step of the last digit of the positions in a file, east, north and up (m).
    pub resolution_m: Option<[f64; 3]>,
    /// Quality of the positions as stated by their source.
    pub seen: SourceSeen,
    /// Whether a table gives the positions by trace number; the positions are then on the traces' clock.
    pub by_trace_number: bool,
}

/// Quality of positions as stated by their source, for the findings.
#[derive(Clone, Debug, Default)]
pub struct SourceSeen {
    /// Name of the source in an autopilot's log, and the number of its positions of each status.
    pub autopilot: Option<(String, StatusCounts)>,
    /// Distance of the base's position from the base's own single-point position (m).
    pub base_from_single_m: Option<f64>,
    /// Clock and place of a separate log of attitudes, compared with the positions.
    pub attitudes: Option<AttitudesSeen>,
}

/// Sources of positions in autopilots' logs, in words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogSources {
    /// Source in the log that gives the positions.
    pub positions: Option<String>,
    /// Source in a separate log of attitudes.
    pub attitudes: Option<String>,
}

impl<T: Into<Positions>> From<T> for Positioned {
    fn from(positions: T) -> Self {
        Self {
            positions: positions.into(),
            has_local_axes: false,
            log_sources: LogSources::default(),
            resolution_m: None,
            seen: SourceSeen::default(),
            by_trace_number: false,
        }
    }
}

impl From<Trajectory> for Positions {
    fn from(trajectory: Trajectory) -> Self {
        Self::Trajectory(Box::new(trajectory))
    }
}

impl From<Vec<[f64; 3]>> for Positions {
    fn from(position_m: Vec<[f64; 3]>) -> Self {
        Self::PerTrace(position_m.into())
    }
}

impl Positions {
    /// Converts positions on the Earth to another local frame.
    fn move_to(&mut self, target: EnuFrame) -> Result<(), PositionError> {
        match self {
            Self::Trajectory(trajectory) => {
                **trajectory = trajectory.in_frame(target).map_err(PositionError::Frame)?;
            }
            Self::PerTrace(places) => *places = places.clone().in_frame(target),
        }
        Ok(())
    }

    /// The frame of the positions, where its place on the Earth is known.
    #[must_use]
    pub fn earth_frame(&self) -> Option<EnuFrame> {
        self.frame().enu().copied()
    }

    /// Frame of the positions' axes.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        match self {
            Self::Trajectory(trajectory) => trajectory.frame(),
            Self::PerTrace(places) => &places.frame,
        }
    }

    /// The instant at which the positions' clock is zero.
    #[must_use]
    pub fn time_origin(&self) -> TimeOrigin {
        match self {
            Self::Trajectory(trajectory) => trajectory.time_origin(),
            Self::PerTrace(places) => places.time_origin,
        }
    }
}

/// Parameters of the stage `position`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PositionOptions {
    /// Source of the positions.
    pub source: PositionSource,
    /// Origin of the local east-north-up frame. By default the file's own origin, or its first
    /// position.
    pub origin: Option<Geodetic>,
    /// Rigid body to take from a motion-capture export that holds several.
    pub rigid_body: Option<String>,
    /// Source of the positions in the log of an autopilot or a robot.
    pub log_source: Option<String>,
    /// Log of an autopilot or a robot that gives the attitudes.
    pub attitude_file: Option<PathBuf>,
    /// Source of the attitudes in the attitude file, or else in the log of the positions.
    pub attitude_source: Option<String>,
    /// The gimbal that carries the antenna; the log of the attitudes contains the gimbal's attitude.
    pub gimbal: GimbalChoice,
    /// Vertical datum of the heights of a table, where its header states none.
    pub height_datum: Option<HeightDatum>,
    /// Grid of the geoid, which converts heights above the sea in a log or table to heights above the
    /// ellipsoid.
    pub geoid: Option<PathBuf>,
    /// Vector from the positioned point to the radar's phase centre: forward, left, up (m).
    pub lever_arm_m: [f64; 3],
}

/// Source of positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PositionSource {
    /// The radar file, with one position for each trace.
    #[default]
    RadarFile,
    /// A trajectory file.
    Trajectory(PathBuf),
    /// Raw GNSS logs, processed by carrier-phase differential positioning.
    Gnss(Box<GnssLogs>),
}

/// Raw GNSS logs to compute a trajectory from.
#[derive(Clone, Debug, PartialEq)]
pub struct GnssLogs {
    /// The logs and navigation files.
    pub files: PositioningInput,
    /// RTKLIB configuration with the options of the positioning.
    pub config: Option<PathBuf>,
    /// Position of the base's antenna; by default as stated in the base's log.
    pub base: Option<BasePlace>,
}

/// Position of the base's antenna.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BasePlace {
    /// Earth-centred, Earth-fixed (m).
    Ecef([f64; 3]),
    /// Latitude, longitude and ellipsoidal height.
    Geodetic(Geodetic),
}

/// Reason for which there are no positions.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PositionError {
    /// The operating system does not open the file.
    #[error("{}: {cause}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The trajectory file cannot be read.
    #[error("{}: {cause}", path.display())]
    Trajectory {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: Box<TrajectoryFileError>,
    },
    /// Positions by trace numbers that the radar log does not contain.
    #[error("{}: {cause}", path.display())]
    TraceNumbers {
        /// The file of positions.
        path: PathBuf,
        /// The number found, and the numbers of the traces.
        cause: TraceNumberError,
    },
    /// A clock offset stated for positions by trace number.
    #[error(
        "[trajectory] time_offset_s: expected none, as the positions of {} are by the numbers of its traces",
        radar_file.display()
    )]
    OffsetOfTraceNumbers {
        /// The radar file.
        radar_file: PathBuf,
    },
    /// The attitudes cannot be combined with the positions.
    #[error("{}: {cause}", path.display())]
    Attitudes {
        /// The log of the attitudes.
        path: PathBuf,
        /// What was expected and what was found.
        cause: Box<AttitudeFileError>,
    },
    /// The RTKLIB configuration cannot be read.
    #[error(transparent)]
    Configuration(GnssConfigurationError),
    /// The GNSS logs give no solution.
    #[error("[gnss]{}: {}", base_keys(.0), .0)]
    Positioning(PositioningError),
    /// The solution is no valid trajectory.
    #[error("[gnss]: {0}")]
    Solution(TrajectoryError),
    /// The trajectory cannot be converted to the stated origin.
    #[error("[trajectory] origin_deg_m: {0}")]
    Origin(TrajectoryError),
    /// The lever arm cannot be applied.
    #[error("[trajectory] lever_arm_m: {0}")]
    LeverArm(LeverArmError),
    /// A lever arm is stated although the positions are the phase centre's.
    #[error(
        "[trajectory] lever_arm_m: expected none, as position_m in {} gives the phase centre itself",
        radar_file.display()
    )]
    LeverArmOfPhaseCentre {
        /// The radar file with the positions.
        radar_file: PathBuf,
    },
    /// No source of positions.
    #[error(
        "no positions: expected [trajectory] file, [gnss], [radar] line_start_m and line_end_m, or position_m in {}",
        radar_file.display()
    )]
    Missing {
        /// The radar file, which holds no positions.
        radar_file: PathBuf,
    },
    /// Tracks in frames that cannot be converted to each other.
    #[error(
        "[[track]] {track}: expected positions in the frame of the first track; one is on the \
         Earth, the other at no known place"
    )]
    Frames {
        /// Number of the track, from 1.
        track: usize,
    },
    /// The recorded clock is on GPS time, the positions are not.
    #[error(
        "[trajectory] time_offset_s = \"logged\": expected positions on GPS time for {}, found times that \
         name no day; state the offset, or take positions of a GNSS receiver",
        radar_file.display()
    )]
    NotOnGpsTime {
        /// The radar log.
        radar_file: PathBuf,
    },
    /// A trajectory that cannot be converted to the frame of the first track.
    #[error("{0}")]
    Frame(TrajectoryError),
}

/// Finds the positions of a track whose radar log is `radar_file` and has traces at `trace_time_s`; `inside`
/// are the positions in the radar log.
///
/// # Errors
/// No source of positions, or one that cannot be read; the message names the file and the place.
pub fn position(
    options: &PositionOptions,
    (radar_file, trace_time_s): (&Path, &[f64]),
    inside: Option<&TracePositions>,
    warnings: &mut Warnings,
) -> Result<Positioned, PositionError> {
    let radar_file = || radar_file.to_owned();
    match (&options.source, inside) {
        (PositionSource::Gnss(logs), _) => from_gnss(logs, options, warnings),
        (PositionSource::Trajectory(file), inside) => {
            if inside.is_some() {
                warnings.add(format!(
                    "{} holds positions; those of {} are used instead",
                    name_of(&radar_file()),
                    name_of(file)
                ));
            }
            from_file((file, trace_time_s), options, warnings)
        }
        (PositionSource::RadarFile, Some(_)) if options.lever_arm_m != [0.0; 3] => {
            Err(PositionError::LeverArmOfPhaseCentre {
                radar_file: radar_file(),
            })
        }
        (PositionSource::RadarFile, Some(places)) => {
            let places = places.clone();
            let places = match options.origin {
                Some(origin) => places.in_frame(EnuFrame::new(origin)),
                None => places,
            };
            Ok(Positions::PerTrace(places).into())
        }
        (PositionSource::RadarFile, None) => Err(PositionError::Missing {
            radar_file: radar_file(),
        }),
    }
}

/// Positions in memory, converted to the origin and to the radar's phase centre like the positions of a file:
/// local frames count from the origin, where one is stated.
///
/// # Errors
/// A lever arm of positions by trace; a trajectory whose heading cannot be found.
pub fn placed(
    positions: Positions,
    options: &PositionOptions,
) -> Result<Positioned, PositionError> {
    let origin = options.origin.map(EnuFrame::new);
    let trajectory = match positions {
        Positions::PerTrace(_) if options.lever_arm_m != [0.0; 3] => {
            return Err(PositionError::LeverArmOfPhaseCentre {
                radar_file: PathBuf::from("positions in memory"),
            });
        }
        Positions::PerTrace(places) => {
            let places = match origin {
                Some(origin) => places.in_frame(origin),
                None => places,
            };
            return Ok(Positions::PerTrace(places).into());
        }
        Positions::Trajectory(trajectory) => *trajectory,
    };
    let has_local_axes = *trajectory.frame() == Frame::Local;
    let trajectory = match origin {
        None => trajectory,
        Some(origin) if has_local_axes => {
            let time_origin = trajectory.time_origin();
            Trajectory::new(Frame::Enu(origin), time_origin, trajectory.into_fixes())
                .map_err(PositionError::Origin)?
        }
        Some(origin) => trajectory.in_frame(origin).map_err(PositionError::Origin)?,
    };
    Ok(Positioned {
        positions: at_phase_centre(trajectory, options.lever_arm_m)?.into(),
        has_local_axes,
        log_sources: LogSources::default(),
        resolution_m: None,
        seen: SourceSeen::default(),
        by_trace_number: false,
    })
}

fn open(path: &Path) -> Result<BufReader<File>, PositionError> {
    File::open(path)
        .map(BufReader::new)
        .map_err(|cause| PositionError::Open {
            path: path.to_owned(),
            cause,
        })
}

fn from_file(
    (path, trace_time_s): (&Path, &[f64]),
    options: &PositionOptions,
    warnings: &mut Warnings,
) -> Result<Positioned, PositionError> {
    let holds_attitudes = options.attitude_file.is_none();
    let reading = TrajectoryFileOptions {
        origin: options.origin,
        rigid_body: options.rigid_body.clone(),
        source: options.log_source.clone(),
        attitude_source: options.attitude_source.clone().filter(|_| holds_attitudes),
        gimbal: if holds_attitudes {
            options.gimbal.clone()
        } else {
            GimbalChoice::None
        },
        takes_first_source: false,
        height_datum: options.height_datum,
        geoid: options.geoid.clone(),
        trace_numbers: true,
    };
    let file =
        read_trajectory_file(open(path)?, &reading).map_err(|cause| PositionError::Trajectory {
            path: path.to_owned(),
            cause: Box::new(cause),
        })?;
    for remark in file.remarks() {
        warnings.add(format!("{}: {remark}", name_of(path)));
    }
    let log = file.log();
    let autopilot = log.map(|log| (log.source.name.clone(), log.statuses));
    let sources = log.map(LogReport::sources_used);
    let has_local_axes = file.has_local_axes();
    let resolution_m = file.resolution_m();
    let by_trace_number = file.trajectory.time_origin() == TimeOrigin::TraceNumbers;
    let mut trajectory = file.trajectory;
    if by_trace_number {
        let (timed, first) =
            at_traces(trajectory, trace_time_s).map_err(|cause| PositionError::TraceNumbers {
                path: path.to_owned(),
                cause,
            })?;
        warnings.note(format!(
            "{}: numbers of traces count from {first}",
            name_of(path)
        ));
        trajectory = timed;
    }
    let (trajectory, attitudes, attitudes_seen) = with_attitudes(trajectory, options, warnings)?;
    Ok(Positioned {
        by_trace_number,
        has_local_axes,
        resolution_m,
        log_sources: LogSources {
            positions: sources,
            attitudes,
        },
        seen: SourceSeen {
            autopilot,
            base_from_single_m: None,
            attitudes: attitudes_seen,
        },
        positions: at_phase_centre(trajectory, options.lever_arm_m)?.into(),
    })
}

/// The positions with the attitudes of the campaign's attitude file, the sources of this file in words, and
/// the comparison of its clock and positions with the positions.
fn with_attitudes(
    trajectory: Trajectory,
    options: &PositionOptions,
    warnings: &mut Warnings,
) -> Result<(Trajectory, Option<String>, Option<AttitudesSeen>), PositionError> {
    let Some(path) = &options.attitude_file else {
        return Ok((trajectory, None, None));
    };
    let mut reading = LogOptions::default();
    reading.attitude_source.clone_from(&options.attitude_source);
    reading.gimbal.clone_from(&options.gimbal);
    let turned = with_log_attitudes(&trajectory, open(path)?, &reading).map_err(|cause| {
        PositionError::Attitudes {
            path: path.to_owned(),
            cause: Box::new(cause),
        }
    })?;
    for remark in turned.remarks() {
        warnings.add(format!("{}: {remark}", name_of(path)));
    }
    let (seen, used) = (turned.seen(), turned.report.attitudes_used());
    Ok((turned.trajectory, Some(used), seen))
}

fn from_gnss(
    logs: &GnssLogs,
    options: &PositionOptions,
    warnings: &mut Warnings,
) -> Result<Positioned, PositionError> {
    let (files, ppk) = positioning_of(logs, warnings)?;
    let positioned = positioning::run(&files, &ppk).map_err(PositionError::Positioning)?;
    for warning in &positioned.warnings {
        warnings.add(format!("[gnss] {warning}"));
    }
    let from_single_m = positioned.solution.summary.base_from_single_m;
    let mut trajectory = positioned
        .solution
        .trajectory()
        .map_err(PositionError::Solution)?;
    if let Some(origin) = options.origin {
        trajectory = trajectory
            .in_frame(EnuFrame::new(origin))
            .map_err(PositionError::Origin)?;
    }
    let (trajectory, attitudes, attitudes_seen) = with_attitudes(trajectory, options, warnings)?;
    let trajectory = at_phase_centre(trajectory, options.lever_arm_m)?;
    Ok(Positioned {
        log_sources: LogSources {
            positions: None,
            attitudes,
        },
        seen: SourceSeen {
            autopilot: None,
            base_from_single_m: from_single_m,
            attitudes: attitudes_seen,
        },
        ..Positioned::from(trajectory)
    })
}

/// The campaign keys that remove an error of the positioning.
fn base_keys(error: &PositioningError) -> &'static str {
    match error.is_base_position_missing() {
        true => " base_deg_m",
        false => "",
    }
}

/// The files and the options of the positioning, from the settings of the configuration file (with the
/// safeguards of `acerra ppk`) and the base's position.
fn positioning_of(
    logs: &GnssLogs,
    warnings: &mut Warnings,
) -> Result<(PositioningInput, PpkOptions), PositionError> {
    let mut files = logs.files.clone();
    let mut options = PpkOptions::default();
    if let Some(path) = &logs.config {
        let conf = GnssConfiguration::read(path).map_err(PositionError::Configuration)?;
        for setting in &conf.not_followed {
            warnings.add(format!("{}: {setting}", name_of(path)));
        }
        options = conf.options;
        if options.mode == PositioningMode::MovingBase {
            warnings.add(format!(
                "{}: with a moving base the positions are as good as the base's own codes, to metres: an \
                 image needs a base at rest",
                name_of(path)
            ));
        }
        files.needs_precise_orbits = conf.needs_precise_orbits;
        files.antennas = conf.antennas;
    }
    match &logs.base {
        None => {}
        Some(BasePlace::Ecef(ecef_m)) => options.base_position = BasePosition::Ecef(*ecef_m),
        Some(BasePlace::Geodetic(place)) => {
            options.base_position = BasePosition::Ecef(ecef_from_geodetic(place));
        }
    }
    Ok((files, options))
}

/// Moves a trajectory of the positioned point to the radar's phase centre.
fn at_phase_centre(
    trajectory: Trajectory,
    lever_arm_m: [f64; 3],
) -> Result<Trajectory, PositionError> {
    if lever_arm_m == [0.0; 3] {
        return Ok(trajectory);
    }
    let (moved, _) = apply_lever_arm(&trajectory, lever_arm_m, &HeadingOptions::default())
        .map_err(PositionError::LeverArm)?;
    Ok(moved)
}

/// Converts the trajectories of all tracks to the frame of the first.
///
/// # Errors
/// Frames on the Earth together with frames of unknown place.
pub fn in_one_frame<'a>(
    positions: impl IntoIterator<Item = &'a mut Positions>,
) -> Result<(), PositionError> {
    let mut first = None;
    for (k, p) in positions.into_iter().enumerate() {
        let frame = *p.frame();
        // Positions recorded with the traces may be in any frame of the first track.
        if frame == Frame::Local && matches!(p, Positions::PerTrace(_)) {
            continue;
        }
        match (first, frame) {
            (None, frame) => first = Some(frame),
            (Some(Frame::Enu(target)), Frame::Enu(own)) => {
                if own != target {
                    p.move_to(target)?;
                }
            }
            (Some(Frame::Local), Frame::Local) => {}
            _ => return Err(PositionError::Frames { track: k + 1 }),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::trajectory::Fix;

    fn at(frame: Frame, position_m: [f64; 3]) -> Positions {
        let fix = Fix::new(0.0, position_m);
        Trajectory::new(frame, TimeOrigin::Relative, vec![fix])
            .unwrap()
            .into()
    }

    #[test]
    fn tracks_about_different_origins_meet_in_the_frame_of_the_first() {
        // The second origin is 111 m north of the first and 3 m above it.
        let first = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
        let second = EnuFrame::new(Geodetic::from_degrees(41.001, 14.2, 63.0));
        let place = [5.0, 120.0, 7.0];
        let seen = second.enu_from_ecef(first.ecef_from_enu(place));
        assert!((place[1] - seen[1]).abs() > 100.0);
        let mut positions = [
            at(Frame::Enu(first), [0.0; 3]),
            at(Frame::Enu(second), seen),
            vec![[1.0; 3]].into(),
        ];
        in_one_frame(&mut positions).unwrap();
        let Positions::Trajectory(moved) = &positions[1] else {
            panic!("a trajectory");
        };
        for (found, expected) in moved.fixes()[0].position_m.iter().zip(place) {
            assert!((found - expected).abs() < 1e-6);
        }
        let mut apart = [at(Frame::Enu(first), [0.0; 3]), at(Frame::Local, [0.0; 3])];
        let message = in_one_frame(&mut apart).unwrap_err().to_string();
        assert!(message.contains("[[track]] 2"), "{message}");
    }
}
