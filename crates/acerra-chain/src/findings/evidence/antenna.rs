//! The antenna's pattern and the attitude, of the platform or of a gimbal, that it is turned by.

use super::finding::{Finding, Verdict};
use super::setting::Setting;

/// What the antenna's axis is fixed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisCarrier {
    /// The platform.
    Platform,
    /// A gimbal.
    Gimbal {
        /// Whether the axis is the gimbal's forward one; else its down one.
        is_forward: bool,
        /// Median angle between the other of the two and the vertical (rad).
        other_tilt_rad: f64,
    },
}

/// Where the antenna looked during a flight, and what that does to the weights by its pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennaSeen {
    /// What turned it.
    pub carrier: AxisCarrier,
    /// Median and largest angle between the antenna's axis and the vertical (rad).
    pub tilt_rad: [f64; 2],
    /// Root mean square and largest change of a pixel's weight by the tilt (dB).
    pub change_db: [f64; 2],
    /// Share of the traces without an attitude of their own.
    pub without: f64,
}

/// Tilt above which the axes of an attitude are doubted (rad): a small multirotor that stands against a wind of
/// 10 m/s, a drag of about a third of its weight, tilts by 20°.
const MOST_TILT_RAD: f64 = 0.35;

/// Share of traces without an attitude above which the pattern is doubted.
const MOST_WITHOUT: f64 = 0.1;

/// Judges the recorded attitude that the antenna's pattern is turned by. A gimbal may look far to the side; it is
/// doubted where its other axis lies nearer to the vertical than the one taken for the antenna's.
///
/// ```
/// use acerra_chain::evidence::{AntennaSeen, AxisCarrier, Verdict, antenna_tilt};
/// let seen = AntennaSeen {
///     carrier: AxisCarrier::Platform,
///     tilt_rad: [0.05, 0.12],
///     change_db: [0.3, 1.1],
///     without: 0.0,
/// };
/// assert_eq!(antenna_tilt(&seen).verdict, Verdict::Agrees);
/// // Axes that are not forward, left, up.
/// let turned = AntennaSeen { tilt_rad: [1.57, 1.6], ..seen };
/// assert_eq!(antenna_tilt(&turned).verdict, Verdict::Doubtful);
/// // The forward axis of a gimbal that looks down as a camera does.
/// let carrier = AxisCarrier::Gimbal { is_forward: true, other_tilt_rad: 1.5 };
/// assert_eq!(antenna_tilt(&AntennaSeen { carrier, ..seen }).verdict, Verdict::Agrees);
/// assert_eq!(antenna_tilt(&AntennaSeen { carrier, ..turned }).verdict, Verdict::Doubtful);
/// ```
#[must_use]
pub fn antenna_tilt(seen: &AntennaSeen) -> Finding {
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
             {most_db:.1} dB at most; {:.0} % of the traces have no attitude of their own. {} \
             ([image] antenna_axis, antenna_cosine_power)",
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
