//! The finding on the antenna's axis.

use acerra_imaging::IncidenceWeight;

use crate::choices::AntennaAxis;
use crate::findings::evidence::{AntennaSeen, AxisCarrier, Finding, ImageGeometry, antenna_tilt};
use crate::findings::weigh::median::median;
use crate::focus::ImageRequest;
use crate::position::boresight::Boresights;
use crate::prepare::{Prepared, Track};

/// Traces whose weights are compared at most.
const MOST_TRACES: usize = 500;

/// Weight from the vertical below which a pixel hardly enters the image, and its change does not count.
const LEAST_WEIGHT: f64 = 0.1;

/// What the recorded attitude does to the weights by the antenna's pattern; none where no pattern is asked for,
/// no attitude is recorded or the antenna is said to look straight down.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
    request: &ImageRequest,
) -> Option<Finding> {
    let weight = request.options.incidence?;
    if weight.cosine_power == 0.0 {
        return None;
    }
    let axis = request.options.antenna_axis;
    let boresights = prepared.aligned.boresights(axis)?;
    let boresight = boresights.looks.get(track.range.clone())?;
    let own = boresights.is_own.get(track.range.clone())?;
    if !own.contains(&true) {
        return None;
    }
    let without = own.iter().filter(|is_own| !**is_own).count() as f64 / own.len() as f64;
    Some(antenna_tilt(&AntennaSeen {
        carrier: carrier(prepared, track, axis)?,
        tilt_rad: [
            median(tilts_rad(boresight))?,
            tilts_rad(boresight).fold(0.0, f64::max),
        ],
        change_db: weight_change_db(&weight, geometry, boresight),
        without,
    }))
}

/// Angles between the vertical and where an axis points (rad).
fn tilts_rad(boresight: &[[f64; 3]]) -> impl Iterator<Item = f64> {
    boresight.iter().map(|b| (-b[2]).clamp(-1.0, 1.0).acos())
}

/// What turns the axis; of a gimbal with how its other axis lies.
fn carrier(prepared: &Prepared, track: &Track, axis: AntennaAxis) -> Option<AxisCarrier> {
    let tilt_rad = |other: &Boresights| median(tilts_rad(other.looks.get(track.range.clone())?));
    Some(match axis {
        AntennaAxis::Attitude | AntennaAxis::Vertical => AxisCarrier::Platform,
        AntennaAxis::Gimbal => AxisCarrier::Gimbal {
            is_forward: false,
            other_tilt_rad: tilt_rad(&prepared.aligned.gimbal_forward)?,
        },
        AntennaAxis::GimbalForward => AxisCarrier::Gimbal {
            is_forward: true,
            other_tilt_rad: tilt_rad(&prepared.aligned.gimbal_down)?,
        },
    })
}

/// Root mean square and largest change of the weights of pixels by the tilt (dB), where they count.
fn weight_change_db(
    weight: &IncidenceWeight,
    geometry: &ImageGeometry<'_>,
    boresight: &[[f64; 3]],
) -> [f64; 2] {
    let step = boresight.len().div_ceil(MOST_TRACES).max(1);
    let traces = geometry.position_m.iter().zip(boresight).step_by(step);
    let (mut squares, mut most, mut count) = (0.0, 0.0_f64, 0_u64);
    for (position_m, looks) in traces {
        for pixel_m in geometry.pixel_m {
            let way: [f64; 3] = std::array::from_fn(|a| pixel_m[a] - position_m[a]);
            let range_m = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            let level = (-way[2] / range_m).clamp(-1.0, 1.0);
            let tilted = (0..3).map(|a| way[a] * looks[a]).sum::<f64>() / range_m;
            let level_weight = weight.at(level.acos());
            // Beyond the pattern's edge the change has no measure in decibels: 40 dB stand for it.
            if level_weight >= LEAST_WEIGHT {
                let ratio = (tilted / level).max(0.0).powf(weight.cosine_power);
                let change_db = (20.0 * ratio.log10()).clamp(-40.0, 40.0);
                squares += change_db * change_db;
                most = most.max(change_db.abs());
                count += 1;
            }
        }
    }
    [(squares / count.max(1) as f64).sqrt(), most]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roll_of_ten_degrees_changes_a_squared_cosine_as_the_angles_do() {
        let weight = IncidenceWeight {
            cosine_power: 2.0,
            ..IncidenceWeight::default()
        };
        // One pixel at 45° to the east, one trace that rolls towards it.
        let geometry = ImageGeometry {
            position_m: &[[0.0, 0.0, 5.0]],
            pixel_m: &[[5.0, 0.0, 0.0]],
            band_hz: [3.1e9, 4.8e9],
            light_speed_m_s: 3e8,
        };
        let (s, c) = 10_f64.to_radians().sin_cos();
        let found = weight_change_db(&weight, &geometry, &[[s, 0.0, -c]]);
        let (tilted, level) = (35_f64.to_radians().cos(), 45_f64.to_radians().cos());
        let expected_db = 40.0 * (tilted / level).log10();
        assert!((expected_db - 2.56).abs() < 0.01);
        for db in found {
            assert!((db - expected_db).abs() < 1e-9, "{found:?}");
        }
        assert_eq!(
            weight_change_db(&weight, &geometry, &[[0.0, 0.0, -1.0]]),
            [0.0; 2]
        );
    }
}
