//! The antenna's pattern and the attitude, of the platform or of a gimbal, that it is turned by.

use acerra_imaging::IncidenceWeight;

use super::median::median;
use crate::align::geometry::ImageGeometry;
use crate::choices::AntennaAxis;
use crate::focus::ImageRequest;
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::position::boresight::Boresights;
use crate::prepare::{Prepared, Track};

/// Traces whose weights are compared at most.
const MOST_TRACES: usize = 500;

/// Weight from the vertical below which a pixel hardly enters the image, and its change does not count.
const LEAST_WEIGHT: f64 = 0.1;

/// Effect of the recorded attitude on the weights by the antenna's pattern; none where the campaign states no
/// pattern, no attitude is recorded or the antenna is said to look straight down.
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

/// Source of the axis' attitude; for a gimbal with the direction of its other axis.
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
            // Beyond the pattern's edge the change in decibels is unbounded: it counts as 40 dB.
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

/// Reference to which the antenna's axis is fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum AxisCarrier {
    /// The platform.
    Platform,
    /// A gimbal.
    Gimbal {
        /// Whether the axis is the gimbal's forward axis; else its down axis.
        is_forward: bool,
        /// Median angle between the other of the two and the vertical (rad).
        other_tilt_rad: f64,
    },
}

/// Axis of the antenna during a flight, and the effect on the weights by its pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AntennaSeen {
    /// Reference that turned the axis.
    pub carrier: AxisCarrier,
    /// Median and largest angle between the antenna's axis and the vertical (rad).
    pub tilt_rad: [f64; 2],
    /// Root mean square and largest change of a pixel's weight by the tilt (dB).
    pub change_db: [f64; 2],
    /// Share of the traces without a recorded attitude.
    pub without: f64,
}

/// Tilt above which the axes of an attitude are doubted (rad): a small multirotor that hovers against a wind
/// of 10 m/s, a drag of about a third of its weight, tilts by 20°.
const MOST_TILT_RAD: f64 = 0.35;

/// Share of traces without an attitude above which the pattern is doubted.
const MOST_WITHOUT: f64 = 0.1;

/// Judges the recorded attitude that turns the antenna's pattern. A gimbal may look far to the side; its
/// attitude is doubted where its other axis is nearer to the vertical than the axis taken for the antenna's.
fn antenna_tilt(seen: &AntennaSeen) -> Finding {
    let [median_deg, largest_deg] = seen.tilt_rad.map(f64::to_degrees);
    let [rms_db, most_db] = seen.change_db;
    let is_level = match seen.carrier {
        AxisCarrier::Platform => seen.tilt_rad[0] <= MOST_TILT_RAD,
        AxisCarrier::Gimbal { other_tilt_rad, .. } => seen.tilt_rad[0] <= other_tilt_rad,
    };
    let is_known = seen.without <= MOST_WITHOUT;
    let verdict = if is_level && is_known {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("antenna_tilt", median_deg, "°", verdict)
        .checking(Setting::AntennaAxis)
        .because(format!(
            "by the recorded attitude{} the antenna looks {median_deg:.1}° off the vertical on the median, \
             {largest_deg:.1}° at most, which changes the weights by its pattern by {rms_db:.1} dB rms, \
             {most_db:.1} dB at most; {:.0} % of the traces have no recorded attitude. {} ([image] \
             antenna_axis, antenna_cosine_power)",
            match seen.carrier {
                AxisCarrier::Platform => "",
                AxisCarrier::Gimbal { .. } => " of the gimbal",
            },
            100.0 * seen.without,
            what_would_be_wrong(seen.carrier),
        ))
}

fn what_would_be_wrong(carrier: AxisCarrier) -> String {
    match carrier {
        AxisCarrier::Platform => format!(
            "A drone that images tilts by less than {:.0}°: more are axes that are not forward, left, up, or an \
             antenna on a gimbal",
            MOST_TILT_RAD.to_degrees()
        ),
        AxisCarrier::Gimbal {
            is_forward,
            other_tilt_rad,
        } => {
            let (taken, other) = if is_forward {
                ("forward", "down")
            } else {
                ("down", "forward")
            };
            format!(
                "The gimbal's {taken} axis is taken for the antenna's; its {other} axis lies {:.1}° off the \
                 vertical on the median, and would be the more likely one where that is less: \"gimbal\" is an \
                 antenna that looks down at zero angles, \"gimbal-forward\" one in the place of a camera",
                other_tilt_rad.to_degrees()
            )
        }
    }
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

    #[test]
    fn steep_and_missing_attitudes_are_doubted() {
        let seen = AntennaSeen {
            carrier: AxisCarrier::Platform,
            tilt_rad: [0.1, 0.6],
            change_db: [0.5, 4.0],
            without: 0.02,
        };
        let verdict = |seen| antenna_tilt(&seen).verdict;
        assert_eq!(verdict(seen), Verdict::Agrees);
        let tilt_rad = [0.4, 0.6];
        assert_eq!(verdict(AntennaSeen { tilt_rad, ..seen }), Verdict::Doubtful);
        let without = 0.3;
        assert_eq!(verdict(AntennaSeen { without, ..seen }), Verdict::Doubtful);
        let tilt_rad = [f64::NAN; 2];
        assert_eq!(verdict(AntennaSeen { tilt_rad, ..seen }), Verdict::Doubtful);
        assert!(antenna_tilt(&seen).explanation.contains("34.4° at most"));
    }

    #[test]
    fn a_gimbal_may_look_to_the_side_but_not_along_the_less_likely_axis() {
        let gimbal = |is_forward, tilt_rad: f64, other_tilt_rad| {
            antenna_tilt(&AntennaSeen {
                carrier: AxisCarrier::Gimbal {
                    is_forward,
                    other_tilt_rad,
                },
                tilt_rad: [tilt_rad, tilt_rad + 0.1],
                change_db: [2.0, 9.0],
                without: 0.0,
            })
        };
        // Rolled by 60°: the nose stays level.
        let side = gimbal(false, 1.05, 1.57);
        assert_eq!(side.verdict, Verdict::Agrees);
        assert!(
            side.explanation
                .contains("attitude of the gimbal the antenna")
        );
        assert!(side.explanation.contains("its forward axis lies 90.0° off"));
        // A camera's gimbal pitched down by 80°, taken for one that looks down at zero angles.
        assert_eq!(gimbal(false, 1.4, 0.17).verdict, Verdict::Doubtful);
        assert_eq!(gimbal(true, 0.17, 1.4).verdict, Verdict::Agrees);
        assert_eq!(gimbal(true, 0.17, f64::NAN).verdict, Verdict::Doubtful);
    }
}
