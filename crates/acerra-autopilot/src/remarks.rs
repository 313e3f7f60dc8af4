//! Remarks on a log in addition to its trajectory.

use acerra_geo::trajectory::Trajectory;

use crate::gimbal::GimbalTrack;
use crate::report::{ClockSummary, LogWarning};
use crate::sample::{
    GimbalSample, GimbalSource, PairKind, PositionSource, Recording, SourceKind, Stamp, Teller,
};

/// Remarks on times by the autopilot's clock: those of the positions, or of the attitudes alone.
pub fn clock_remarks(clock: &ClockSummary, positions_need: bool) -> Vec<LogWarning> {
    let mut remarks = Vec::new();
    if clock.kind == PairKind::Arrival {
        remarks.push(LogWarning::UnknownLatency {
            what: if positions_need {
                "positions"
            } else {
                "attitudes"
            },
            spread_s: clock.spread_s,
        });
    }
    if clock.left_out > 0 {
        remarks.push(LogWarning::ClockReadingsLeftOut {
            count: clock.left_out,
            total: clock.left_out + clock.readings,
        });
    }
    remarks
}

/// Remarks on the attitudes of the gimbal.
pub fn gimbal_remarks(
    gimbal: &GimbalSource,
    track: &GimbalTrack,
    trajectory: &Trajectory,
) -> Vec<LogWarning> {
    let mut remarks = Vec::new();
    let source = || gimbal.name.clone();
    let total = gimbal.samples.len();
    let count_of =
        |is: fn(&GimbalSample) -> bool| gimbal.samples.iter().filter(|sample| is(sample)).count();
    if gimbal.without_attitude > 0 {
        remarks.push(LogWarning::GimbalWithoutAttitude {
            source: source(),
            count: gimbal.without_attitude,
        });
    }
    if track.without_heading > 0 {
        remarks.push(LogWarning::GimbalWithoutHeading {
            source: source(),
            count: track.without_heading,
            total,
        });
    }
    let count = count_of(|sample| sample.is_doubted);
    if count > 0 {
        remarks.push(LogWarning::GimbalFailing {
            source: source(),
            count,
            total,
        });
    }
    if count_of(|sample| sample.teller == Teller::Servos) > 0 {
        remarks.push(LogWarning::GimbalCommanded { source: source() });
    }
    if count_of(|sample| sample.teller == Teller::Autopilot) > 0 {
        remarks.push(LogWarning::GimbalByAutopilot { source: source() });
    }
    let fixes = trajectory.fixes();
    let without = fixes.iter().filter(|fix| fix.gimbal.is_none()).count();
    if without > 0 {
        remarks.push(LogWarning::GimbalGaps {
            count: without,
            total: fixes.len(),
        });
    }
    remarks
}

/// Remarks on the source, its positions and their attitudes.
pub fn remarks(
    recording: &Recording,
    source: &PositionSource,
    trajectory: &Trajectory,
) -> Vec<LogWarning> {
    let mut remarks = Vec::new();
    let fixes = trajectory.fixes();
    let with_attitude = fixes.iter().filter(|fix| fix.attitude.is_some()).count();
    if recording.attitudes.is_empty() {
        remarks.push(LogWarning::NoAttitude);
    } else if with_attitude < fixes.len() {
        remarks.push(LogWarning::AttitudeGaps {
            count: fixes.len() - with_attitude,
            total: fixes.len(),
        });
    }
    let is_boot = source
        .samples
        .iter()
        .any(|s| matches!(s.stamp, Stamp::Boot(_)));
    if source.kind == SourceKind::Gnss && is_boot {
        remarks.push(LogWarning::StampedOnArrival {
            source: source.name.clone(),
        });
    }
    let statuses = trajectory.status_counts();
    if statuses.fixed() < statuses.total() {
        remarks.push(LogWarning::NotFixed {
            total: statuses.total(),
            statuses,
        });
    }
    if source.without_position > 0 {
        remarks.push(LogWarning::WithoutPosition {
            source: source.name.clone(),
            count: source.without_position,
        });
    }
    if recording.damage.places > 0 {
        remarks.push(LogWarning::Damaged(recording.damage));
    }
    remarks.extend(recording.remarks.iter().cloned().map(LogWarning::Remark));
    remarks
}
