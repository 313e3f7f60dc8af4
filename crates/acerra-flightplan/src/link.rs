//! Radar range equation: signal-to-noise ratio of an echo.

use std::f64::consts::PI;

use super::{LIGHT_SPEED_M_S, Radar};

/// Thermal noise power of 1 Hz at 290 K (dBm).
const NOISE_DBM_HZ: f64 = -173.975;

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// Signal-to-noise ratio (dB) of one scan: P G² λ² σ n / ((4π)³ R⁴ k T B F), the n pulses of the
/// scan added up in phase, the target on the antennas' axis.
///
/// ```
/// use acerra_flightplan::{Radar, pulse_snr_db};
/// let radar = Radar::default();
/// let near = pulse_snr_db(&radar, 5.0, 0.0);
/// // Twice the range costs 12 dB.
/// assert!((near - pulse_snr_db(&radar, 10.0, 0.0) - 12.04).abs() < 0.01);
/// ```
#[must_use]
pub fn pulse_snr_db(radar: &Radar, range_m: f64, rcs_dbsm: f64) -> f64 {
    let wavelength_m = LIGHT_SPEED_M_S / radar.centre_hz();
    let signal_dbm =
        radar.power_dbm + 2.0 * radar.antenna_gain_dbi + 2.0 * db(wavelength_m) + rcs_dbsm
            - 3.0 * db(4.0 * PI)
            - 4.0 * db(range_m);
    let noise_dbm = NOISE_DBM_HZ + db(radar.bandwidth_hz()) + radar.noise_figure_db
        - db(radar.pulses_per_scan.into());
    signal_dbm - noise_dbm
}

/// Signal-to-noise ratio (dB) in the image of a target at closest range `range_m`, seen within
/// ±`half_view_rad` by scans `step_m` apart: that of one scan at the edge of the view, with the
/// antenna 6 dB down there and back, times the number of scans.
///
/// The edge of the view is the worst of all scans, so that this is a lower bound.
#[must_use]
pub fn image_snr_db(
    radar: &Radar,
    range_m: f64,
    rcs_dbsm: f64,
    half_view_rad: f64,
    step_m: f64,
) -> f64 {
    let scans = (2.0 * range_m * half_view_rad.tan() / step_m).max(1.0);
    pulse_snr_db(radar, range_m / half_view_rad.cos(), rcs_dbsm) - 6.0 + db(scans)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked by hand: −13 + 12 + 20 log 0.075897 + 0 − 32.976 − 40 log 10 = −96.37 dBm over
    /// −173.975 + 92.304 + 5 − 33.113 = −109.78 dBm.
    #[test]
    fn the_paper_s_radar_at_ten_metres() {
        let snr = pulse_snr_db(&Radar::default(), 10.0, 0.0);
        assert!((snr - 13.41).abs() < 0.02, "{snr}");
    }

    #[test]
    fn a_longer_view_adds_scans_and_loses_range() {
        let radar = Radar::default();
        let narrow = image_snr_db(&radar, 10.0, 0.0, 0.1, 0.02);
        let n = 2.0 * 10.0 * 0.1f64.tan() / 0.02;
        let want = pulse_snr_db(&radar, 10.0, 0.0) + 40.0 * 0.1f64.cos().log10() - 6.0 + db(n);
        assert!((narrow - want).abs() < 1e-9);
    }
}
