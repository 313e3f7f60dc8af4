//! The antenna's pattern and the attitude that it is turned by.

use super::finding::{Finding, Verdict};
use super::setting::Setting;

/// Where the antenna looked during a flight, and what that does to the weights by its pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennaSeen {
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

/// Judges the recorded attitude that the antenna's pattern is turned by.
///
/// ```
/// use acerra_chain::evidence::{AntennaSeen, Verdict, antenna_tilt};
/// let seen = AntennaSeen { tilt_rad: [0.05, 0.12], change_db: [0.3, 1.1], without: 0.0 };
/// assert_eq!(antenna_tilt(&seen).verdict, Verdict::Agrees);
/// // Axes that are not forward, left, up.
/// let turned = AntennaSeen { tilt_rad: [1.57, 1.6], ..seen };
/// assert_eq!(antenna_tilt(&turned).verdict, Verdict::Doubtful);
/// ```
#[must_use]
pub fn antenna_tilt(seen: &AntennaSeen) -> Finding {
    let [median_deg, largest_deg] = seen.tilt_rad.map(f64::to_degrees);
    let [rms_db, most_db] = seen.change_db;
    let is_level = seen.tilt_rad[0] <= MOST_TILT_RAD;
    let is_known = seen.without <= MOST_WITHOUT;
    let verdict = if is_level && is_known {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("antenna_tilt", median_deg, "°", verdict)
        .checking(Setting::AntennaAxis)
        .because(format!(
            "by the recorded attitude the antenna looks {median_deg:.1}° off the vertical on the median, \
             {largest_deg:.1}° at most, which changes the weights by its pattern by {rms_db:.1} dB rms, \
             {most_db:.1} dB at most; {:.0} % of the traces have no attitude of their own. A drone that images \
             tilts by less than {:.0}°: more are axes that are not forward, left, up, or an antenna on a gimbal \
             ([image] antenna_axis, antenna_cosine_power)",
            100.0 * seen.without,
            MOST_TILT_RAD.to_degrees(),
        ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steep_and_missing_attitudes_are_doubted() {
        let seen = AntennaSeen {
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
}
