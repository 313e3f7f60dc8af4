//! The base's position: its source, and a check of its plausibility.

use crate::measurements::measurement::Epoch;
use crate::observations::observation::ObservationData;
use crate::options::{BasePosition, PpkOptions};
use crate::single::{SingleContext, SinglePoint};
use crate::solution::{PpkError, PpkWarning};
use acerra_geo::geodesy::EnuFrame;

/// Least spacing of base epochs that enter a mean position (s).
const AVERAGE_INTERVAL_S: f64 = 1.0 - 0.025;
/// Number of base epochs whose single-point position is computed to check a given position.
const CHECKED_EPOCHS: usize = 16;
/// Number of base epochs where the median is suggested as the base's position.
const SUGGESTED_EPOCHS: usize = 240;
const LEAST_RADIUS_M: f64 = 6.0e6;
const LARGEST_DISTANCE_M: f64 = 100e3;
/// Distance from the base's single-point position beyond which a base position is doubtful (m): three times
/// the error of the median of single-frequency positions.
const DOUBTFUL_DISTANCE_M: f64 = 10.0;
/// Median Doppler speed above which a base counts as moving (m/s).
const MOVING_SPEED_M_S: f64 = 0.3;

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn single_points<'e>(
    context: &SingleContext<'_>,
    epochs: impl Iterator<Item = &'e Epoch>,
) -> Vec<SinglePoint> {
    let mut start = [0.0; 3];
    epochs
        .filter_map(|epoch| {
            let states = context.states(epoch, epoch.tag, true);
            let point = context.solve(epoch, &states, start).ok()?;
            start = point.position_ecef_m;
            Some(point)
        })
        .collect()
}

/// Place of the base's antenna.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BasePlace {
    /// Position of the antenna (ECEF, m).
    pub position_ecef_m: [f64; 3],
    /// Distance from the base's own single-point position (m), where there is one that is not the source of
    /// the position.
    pub from_single_m: Option<f64>,
}

/// The base antenna's place, checked against the base's own measurements.
pub(crate) fn base_position(
    context: &SingleContext<'_>,
    data: &ObservationData,
    epochs: &[Epoch],
    options: &PpkOptions,
    warnings: &mut Vec<PpkWarning>,
) -> Result<BasePlace, PpkError> {
    let averaging = options.base_position == BasePosition::AverageSingle;
    let points = if averaging {
        let mut last = None;
        single_points(
            context,
            epochs.iter().filter(|e| {
                let due = last.is_none_or(|t| e.tag.seconds_since(t) >= AVERAGE_INTERVAL_S);
                if due {
                    last = Some(e.tag);
                }
                due
            }),
        )
    } else {
        let is_missing =
            options.base_position == BasePosition::Header && data.station.position_ecef_m.is_none();
        let most = if is_missing {
            SUGGESTED_EPOCHS
        } else {
            CHECKED_EPOCHS
        };
        let step = epochs.len().div_ceil(most).max(1);
        single_points(context, epochs.iter().step_by(step))
    };
    let speed = |p: &SinglePoint| p.velocity.map(|(v, _)| distance(v, [0.0; 3]));
    if let Some(speed_m_s) = median(points.iter().filter_map(speed).collect())
        && speed_m_s > MOVING_SPEED_M_S
    {
        warnings.push(PpkWarning::BaseMoves { speed_m_s });
    }
    let middle = |axis: usize| median(points.iter().map(|p| p.position_ecef_m[axis]).collect());
    let own = match (middle(0), middle(1), middle(2)) {
        (Some(x), Some(y), Some(z)) => Some([x, y, z]),
        _ => None,
    };
    let position = match options.base_position {
        BasePosition::Ecef(position) => position,
        BasePosition::Header => {
            let marker = data
                .station
                .position_ecef_m
                .ok_or(PpkError::BasePositionMissing {
                    own_single_ecef_m: own,
                })?;
            warnings.push(PpkWarning::HeaderPositionUsed {
                distance_from_single_m: own.map(|p| distance(p, marker)),
            });
            let offset = data.station.antenna_offset;
            let local = [offset.east_m, offset.north_m, offset.up_m];
            EnuFrame::from_ecef(marker).ecef_from_enu(local)
        }
        BasePosition::AverageSingle => {
            if points.is_empty() {
                return Err(PpkError::BasePositionMissing {
                    own_single_ecef_m: None,
                });
            }
            let n = points.len() as f64;
            std::array::from_fn(|k| points.iter().map(|p| p.position_ecef_m[k]).sum::<f64>() / n)
        }
    };
    let from_own_m = own.map(|own| distance(own, position));
    let radius = distance(position, [0.0; 3]);
    if radius.is_nan()
        || radius < LEAST_RADIUS_M
        || from_own_m.is_some_and(|d| d > LARGEST_DISTANCE_M)
    {
        return Err(PpkError::BasePositionImplausible {
            position_ecef_m: position,
            own_single_ecef_m: own,
        });
    }
    match from_own_m {
        Some(distance_m) if distance_m > DOUBTFUL_DISTANCE_M => {
            warnings.push(PpkWarning::BasePositionDoubtful { distance_m });
        }
        _ => {}
    }
    Ok(BasePlace {
        position_ecef_m: position,
        from_single_m: from_own_m.filter(|_| !averaging),
    })
}
