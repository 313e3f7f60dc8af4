//! From a log's samples to a trajectory on GPS time.

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::matrix::{multiply, multiply_vector, rotate_covariance, transpose};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Attitude, Fix, Frame, TimeOrigin, Trajectory};

use crate::attitudes::LogAttitudes;
use crate::choose;
use crate::clock::{self, ClockFit};
use crate::error::LogError;
use crate::gimbal::GimbalTrack;
use crate::height::{Heights, of_one_datum};
use crate::options::LogOptions;
use crate::remarks::{clock_remarks, gimbal_remarks, remarks};
use crate::report::{AttitudeSummary, ClockSummary, LogReport, LogWarning, SourceSummary};
use crate::sample::{
    AttitudeSource, GimbalSample, GimbalSource, Place, PositionSample, PositionSource, Recording,
    Stamp, Teller,
};
use crate::timeline::{AttitudeTrack, StatusTrack, gps_time, longest_rising};

/// A position with its instant.
type Timed = (GpsTime, PositionSample);

/// Output of a recording.
pub struct Assembled {
    /// Positions with the attitudes at their times.
    pub trajectory: Trajectory,
    /// The attitudes at their times.
    pub attitudes: LogAttitudes,
    /// Remarks on them.
    pub report: LogReport,
}

/// The trajectory and the attitudes of a recording, with remarks.
///
/// # Errors
/// Sources that are ambiguous or absent, times without a scale, positions outside the grid of the
/// geoid.
pub fn assemble(recording: &Recording, options: &LogOptions) -> Result<Assembled, LogError> {
    let mut warnings: Vec<LogWarning> = Vec::new();
    let source = choose::positions(recording, options, &mut warnings)?;
    let attitude_source = choose::attitudes(recording, options, &source.name, &mut warnings)?;
    let gimbal_source = choose::gimbal(recording, options, &mut warnings)?;
    let clock = clock_of(recording, source)?;

    let (samples, left_out) = of_one_datum(&source.samples);
    if left_out > 0 {
        warnings.push(LogWarning::OtherDatumLeftOut { count: left_out });
    }
    let timed = in_order(&samples, clock.as_ref(), &source.name, &mut warnings)?;
    let mut heights = Heights::new(options.geoid.as_deref());
    let mut places = Vec::with_capacity(timed.len());
    for (_, sample) in &timed {
        places.push(heights.ellipsoidal(sample.place)?);
    }
    warnings.extend(heights.remark(&source.name));

    let statuses = StatusTrack::of(recording, source, clock.as_ref());
    let attitudes = attitude_source.map(|a| AttitudeTrack::new(&a.samples, clock.as_ref()));
    let gimbal = gimbal_source
        .as_ref()
        .map(|g| GimbalTrack::new(&g.samples, clock.as_ref(), attitudes.as_ref()));
    let frame = frame_of(places.first(), options.origin);
    let is_own_clock = clock.is_some_and(|clock| clock.is_own);
    let (time_origin, start) = time_origin(&timed, is_own_clock);
    let fixes: Vec<Fix> = timed
        .iter()
        .zip(&places)
        .map(|((time, sample), place)| {
            let turns = Turns {
                vehicle: attitudes.as_ref().and_then(|a| a.at(*time)),
                gimbal: gimbal.as_ref().and_then(|g| g.track.at(*time)),
            };
            let mut fix = fix_at(*place, sample, turns, &frame);
            fix.time_s = *time - start;
            fix.status = statuses.at(*time, sample);
            fix
        })
        .collect();
    let trajectory = Trajectory::new(frame, time_origin, fixes)?;

    let with_attitude = trajectory
        .fixes()
        .iter()
        .filter(|fix| fix.attitude.is_some());
    let with_attitude = with_attitude.count();
    let gimbal_attitudes = trajectory.fixes().iter().filter(|f| f.gimbal.is_some());
    let gimbal_attitudes = gimbal_attitudes.count();
    if let (Some(source), Some(track)) = (&gimbal_source, &gimbal) {
        refuse_useless(source, track, gimbal_attitudes)?;
        warnings.extend(gimbal_remarks(source, track, &trajectory));
    }
    let positions_need = uses_boot_clock(&source.samples);
    let attitudes_need = with_attitude > 0 && attitude_source.is_some_and(has_boot_times)
        || gimbal_source.as_ref().is_some_and(|g| {
            let mut stamps = g.samples.iter().map(|s| s.stamp);
            stamps.any(|stamp| matches!(stamp, Stamp::Boot(_)))
        });
    if is_own_clock {
        warnings.push(LogWarning::OwnClock);
    }
    let clock = clock.filter(|clock| !clock.is_own && (positions_need || attitudes_need));
    let clock = clock.map(|fit| ClockSummary {
        readings: fit.readings,
        left_out: fit.left_out,
        rate_ppm: 1e6 * fit.rate,
        spread_s: fit.spread_s,
        kind: recording.pair_kind,
    });
    warnings.extend(clock.iter().flat_map(|c| clock_remarks(c, positions_need)));
    warnings.extend(remarks(recording, source, &trajectory));
    let report = LogReport {
        format: recording.format,
        sources: recording.positions.iter().map(summary).collect(),
        attitude_sources: recording.attitudes.iter().map(attitude_summary).collect(),
        gimbal_sources: recording.gimbals.iter().map(gimbal_summary).collect(),
        source: summary(source),
        attitude_source: attitude_source.map(|a| a.name.clone()),
        attitudes: with_attitude,
        gimbal_source: gimbal_source.map(|g| g.name.clone()),
        gimbal_attitudes,
        height_datum: heights.datum(),
        clock,
        statuses: trajectory.status_counts(),
        warnings,
    };
    Ok(Assembled {
        trajectory,
        attitudes: LogAttitudes {
            vehicle: attitudes,
            gimbal: gimbal.map(|g| g.track),
        },
        report,
    })
}

fn uses_boot_clock(samples: &[PositionSample]) -> bool {
    samples.iter().any(|s| matches!(s.stamp, Stamp::Boot(_)))
}

fn has_boot_times(source: &AttitudeSource) -> bool {
    source
        .samples
        .iter()
        .any(|s| matches!(s.stamp, Stamp::Boot(_)))
}

/// The autopilot's clock on GPS time. Positions that need it do not go without it.
fn clock_of(recording: &Recording, source: &PositionSource) -> Result<Option<ClockFit>, LogError> {
    let fit = clock::fit(&recording.pairs, recording.pair_kind)?;
    if !uses_boot_clock(&source.samples) {
        return Ok(fit);
    }
    match fit {
        Some(fit) => Ok(Some(fit)),
        None if recording.allows_own_clock => Ok(Some(ClockFit::own())),
        None => Err(LogError::NoGpsTime {
            source_name: source.name.clone(),
            expected: recording.pair_source,
        }),
    }
}

/// Meaning of second zero: the start of the GPS week, or that of the log's clock.
fn time_origin(timed: &[Timed], is_own_clock: bool) -> (TimeOrigin, GpsTime) {
    if is_own_clock {
        return (TimeOrigin::Relative, GpsTime::EPOCH);
    }
    let week = timed.first().map_or(0, |(time, _)| time.week());
    let start = GpsTime::from_week_tow(week, 0.0);
    (TimeOrigin::Gps(start), start)
}

/// The samples with their instants, those left out that give another time than the log's other readings,
/// and those whose time does not advance.
fn in_order(
    samples: &[PositionSample],
    clock: Option<&ClockFit>,
    source: &str,
    warnings: &mut Vec<LogWarning>,
) -> Result<Vec<Timed>, LogError> {
    let is_elsewhere = |s: &PositionSample| match (s.stamp, s.arrival_s, clock) {
        (Stamp::Gps(time), Some(arrival_s), Some(clock)) => !clock.agrees(time, arrival_s),
        _ => false,
    };
    let timed: Vec<Timed> = samples
        .iter()
        .filter(|s| !is_elsewhere(s))
        .filter_map(|s| Some((gps_time(s.stamp, clock)?, *s)))
        .collect();
    if timed.len() < samples.len() {
        warnings.push(LogWarning::OtherTimeLeftOut {
            count: samples.len() - timed.len(),
        });
    }
    let times: Vec<GpsTime> = timed.iter().map(|(time, _)| *time).collect();
    let kept = longest_rising(&times);
    let count = timed.len() - kept.len();
    if 2 * kept.len() < timed.len() {
        return Err(LogError::TimesUnordered {
            bad: count,
            total: timed.len(),
            source_name: source.to_owned(),
        });
    }
    if count > 0 {
        warnings.push(LogWarning::TimesRepeated { count });
    }
    Ok(kept.into_iter().map(|k| timed[k]).collect())
}

/// The frame about the origin stated, else about the first position.
fn frame_of(first: Option<&Place>, origin: Option<Geodetic>) -> Frame {
    match (origin, first) {
        (Some(origin), _) => Frame::Enu(EnuFrame::new(origin)),
        (None, Some(Place::Geodetic(place, _))) => Frame::Enu(EnuFrame::new(*place)),
        (None, _) => Frame::Local,
    }
}

/// Attitudes at one time.
#[derive(Clone, Copy)]
struct Turns {
    vehicle: Option<Attitude>,
    gimbal: Option<Attitude>,
}

/// Refuses a gimbal whose angles have an unknown reference, or whose attitude no position has: a pattern
/// would follow no attitude.
fn refuse_useless(
    source: &GimbalSource,
    track: &GimbalTrack,
    attitudes: usize,
) -> Result<(), LogError> {
    let samples = source.samples.len();
    let of_servos = |s: &GimbalSample| s.teller == Teller::ServosOfUnknownFrame;
    let why = match attitudes {
        _ if source.samples.iter().any(of_servos) => {
            "servos that measure nothing move it (parameter MNT1_TYPE = 1), and by its version ArduPilot logs \
             their angles from the horizon or from the vehicle; antenna_axis = \"vertical\" where it keeps level"
        }
        0 if track.without_heading == samples => {
            "they count from the vehicle's nose, and no attitude of the vehicle gives its heading"
        }
        0 => "the log has them at other times, or no clock relates their times to GPS time",
        _ => return Ok(()),
    };
    Err(LogError::GimbalUnusable {
        source_name: source.name.clone(),
        samples,
        why,
    })
}

/// A position in `frame`. Deviations, velocity and attitude come in the axes of the place itself.
fn fix_at(place: Place, sample: &PositionSample, turns: Turns, frame: &Frame) -> Fix {
    let covariance_m2 = sample
        .sigma_m
        .map(|[e, n, u]| [[e * e, 0.0, 0.0], [0.0, n * n, 0.0], [0.0, 0.0, u * u]]);
    let mut fix = Fix::new(0.0, [0.0; 3]);
    fix.covariance_m2 = covariance_m2;
    fix.velocity_m_s = sample.velocity_m_s;
    fix.attitude = turns.vehicle;
    fix.gimbal = turns.gimbal;
    fix.satellites = sample.satellites;
    match (place, frame) {
        (Place::Geodetic(place, _), Frame::Enu(frame)) => {
            let here = EnuFrame::new(place);
            let frame_from_here = multiply(
                frame.rotation_enu_from_ecef(),
                &transpose(here.rotation_enu_from_ecef()),
            );
            fix.position_m = frame.enu_from_geodetic(&place);
            fix.covariance_m2 = covariance_m2.map(|c| rotate_covariance(&frame_from_here, &c));
            fix.velocity_m_s = sample
                .velocity_m_s
                .map(|v| multiply_vector(&frame_from_here, v));
            fix.attitude = turns.vehicle.map(|a| a.turned_by(&frame_from_here));
            fix.gimbal = turns.gimbal.map(|a| a.turned_by(&frame_from_here));
        }
        (Place::Geodetic(..), _) => {}
        (Place::Local(position_m), _) => fix.position_m = position_m,
    }
    fix
}

fn summary(source: &PositionSource) -> SourceSummary {
    SourceSummary {
        name: source.name.clone(),
        kind: source.kind,
        positions: source.samples.len(),
    }
}

fn attitude_summary(source: &AttitudeSource) -> AttitudeSummary {
    AttitudeSummary {
        name: source.name.clone(),
        attitudes: source.samples.len(),
    }
}

fn gimbal_summary(source: &GimbalSource) -> AttitudeSummary {
    AttitudeSummary {
        name: source.name.clone(),
        attitudes: source.samples.len(),
    }
}
