//! What the radargram itself says of the settings: surface echo, direct coupling, spectrum.

use super::finding::{Finding, Verdict};
use super::setting::Setting;

/// Speed of light in vacuum (m/s), for delays that settings are judged by.
const LIGHT_SPEED_M_S: f64 = 299_792_458.0;

/// The surface echo of the traces beside 2h/c, after zero-timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSeen {
    /// Median of echo minus 2h/c (ns).
    pub level_ns: f64,
    /// Robust standard deviation of echo minus 2h/c (ns).
    pub spread_ns: f64,
    /// Its standard deviation expected from the positions' own σ and the echo's timing (ns).
    pub expected_spread_ns: f64,
    /// Change of echo minus 2h/c from the first trace to the last by a straight line (ns).
    pub drift_ns: f64,
    /// Standard deviation of that change (ns).
    pub drift_sigma_ns: f64,
    /// Whether fast time was calibrated (stated) rather than set by this very echo.
    pub is_calibrated: bool,
}

/// Roughness of ordinary ground as the surface echo shows it (ns): 5 cm, one standard deviation.
const GROUND_ROUGHNESS_NS: f64 = 0.33;
/// Deviation of the delay by the surface echo of a whole flight (ns): the ground's mean level about
/// the plane, 3 cm, of which the roughness is no part any more, and the echo's own delay, a tenth of
/// the pulse's length of 1 ns.
const MEAN_LEVEL_NS: f64 = 0.22;

/// Judges the surface echo: its level where fast time is calibrated, its spread and its drift.
///
/// A wrong clock offset or another flight's log leaves the flight's own climbs and descents in
/// echo minus 2h/c; a wrong delay, lever arm, plane or propagation speed shifts it.
#[must_use]
pub fn surface(seen: &SurfaceSeen) -> Vec<Finding> {
    let mut findings = Vec::new();
    let spread_sigma_ns = seen.expected_spread_ns.hypot(GROUND_ROUGHNESS_NS);
    if seen.is_calibrated {
        let sigma_ns = spread_sigma_ns.hypot(0.3);
        findings.push(
            Finding::compared("surface_delay", seen.level_ns, 0.0, sigma_ns, "ns")
                .checking(Setting::Heights)
                .because(format!(
                    "the surface echo comes {:+.2} ns after 2h/c: {:+.2} m of range ([radar] \
                     delay_ns, [image] z_m, [trajectory] origin_deg_m and lever_arm_m)",
                    seen.level_ns,
                    0.5e-9 * seen.level_ns * LIGHT_SPEED_M_S
                )),
        );
    }
    let verdict = match seen.spread_ns / spread_sigma_ns {
        r if r <= 1.5 => Verdict::Agrees,
        r if r <= 3.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    findings.push(
        Finding::judged("surface_spread", seen.spread_ns, "ns", verdict)
            .expecting(spread_sigma_ns)
            .because(format!(
                "the surface echo scatters by {:.2} ns about 2h/c, {spread_sigma_ns:.2} ns are \
                 explained by the positions and the ground ([trajectory] time_offset_s; is this the \
                 trajectory of this flight?)",
                seen.spread_ns
            )),
    );
    let drift_sigma_ns = seen.drift_sigma_ns.hypot(GROUND_ROUGHNESS_NS);
    findings.push(
        Finding::compared("surface_drift", seen.drift_ns, 0.0, drift_sigma_ns, "ns")
            .at_most(Verdict::Doubtful)
            .because(format!(
                "the surface echo drifts by {:+.2} ns against 2h/c over the flight (sloping ground, \
                 drifting positions or clock)",
                seen.drift_ns
            )),
    );
    findings
}

/// Delay of half a metre of range (ns).
const FAR_NS: f64 = 3.3;

/// Judges the fast time taken for range zero by the echo that follows the flight's height: `delay_ns`
/// in force, `seen_ns` ± `sigma_ns` by that echo.
#[must_use]
pub fn zero_timing(delay_ns: f64, seen_ns: f64, sigma_ns: f64) -> Finding {
    let sigma_ns = sigma_ns.hypot(MEAN_LEVEL_NS);
    let finding = Finding::compared("delay", delay_ns, seen_ns, sigma_ns, "ns");
    // An image half a metre above or below the ground may be meant.
    let is_far = (delay_ns - seen_ns).abs() > FAR_NS;
    let most = if is_far {
        Verdict::Contradicts
    } else {
        Verdict::Doubtful
    };
    finding.checking(Setting::Heights).at_most(most).because(format!(
        "fast time {delay_ns:.2} ns is taken for range zero, the echo that follows the flight's \
         height says {seen_ns:.2} ns: {:+.2} m of range ([radar] delay_ns, [preprocess] zero_timing, \
         heights)",
        0.5e-9 * (delay_ns - seen_ns) * LIGHT_SPEED_M_S
    ))
}

/// The direct coupling between the antennas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingSeen {
    /// Its fast time after zero-timing (ns).
    pub delay_ns: f64,
    /// Its standard deviation over the traces (ns).
    pub spread_ns: f64,
}

/// Where the coupling of antennas up to this far apart (m) may stand.
const ANTENNA_SEPARATION_M: f64 = 0.6;

/// Judges the direct coupling: with fast time zero at range zero it arrives after the time from
/// antenna to antenna, never before zero.
#[must_use]
pub fn coupling(seen: &CouplingSeen) -> Finding {
    let longest_ns = 1e9 * ANTENNA_SEPARATION_M / LIGHT_SPEED_M_S;
    let middle_ns = 0.5 * longest_ns;
    // The envelope's maximum may stand half a pulse (0.6 ns) off its delay.
    let sigma_ns = (0.25 * longest_ns).hypot(0.3).hypot(seen.spread_ns);
    let finding = Finding::compared("coupling_delay", seen.delay_ns, middle_ns, sigma_ns, "ns");
    finding.checking(Setting::Delay).because(format!(
        "the direct coupling arrives at {:+.2} ns of fast time, {:.1} to {longest_ns:.1} ns are \
         expected of antennas side by side: heights, delay or propagation speed are off by \
         {:+.2} m ([radar] delay_ns, [trajectory] origin_deg_m, lever_arm_m, [image] z_m, \
         light_speed_m_s)",
        seen.delay_ns,
        0.0,
        0.5e-9 * (seen.delay_ns - middle_ns) * LIGHT_SPEED_M_S
    ))
}

/// Judges the band asked for: `occupied` is the share of its frequencies at which the radar's
/// spectrum stands less than 20 dB below its maximum.
#[must_use]
pub fn band(occupied: f64, band_ghz: [f64; 2], spectrum_ghz: [f64; 2]) -> Finding {
    let verdict = match occupied {
        share if share >= 0.7 => Verdict::Agrees,
        share if share >= 0.2 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    Finding::judged("band", occupied, "share of the band", verdict)
        .expecting(1.0)
        .because(format!(
            "the radar has energy in {:.0} % of the band {:.2} to {:.2} GHz; its spectrum reaches from \
             {:.2} to {:.2} GHz ([image] band_ghz)",
            100.0 * occupied,
            band_ghz[0],
            band_ghz[1],
            spectrum_ghz[0],
            spectrum_ghz[1]
        ))
}

/// Share of the radar's own band below which the one asked for is doubted: the range cell grows with its
/// inverse, and with it what runs together.
const LEAST_USED: f64 = 0.6;

/// Judges how much of the radar's own band the one asked for uses.
#[must_use]
pub fn band_used(band_ghz: [f64; 2], spectrum_ghz: [f64; 2]) -> Finding {
    let width = |[low, high]: [f64; 2]| (high - low).max(0.0);
    let common = [
        band_ghz[0].max(spectrum_ghz[0]),
        band_ghz[1].min(spectrum_ghz[1]),
    ];
    let used = width(common) / width(spectrum_ghz).max(f64::MIN_POSITIVE);
    let verdict = if used >= LEAST_USED {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    let cell_m = |band: [f64; 2]| 0.5e-9 * LIGHT_SPEED_M_S / width(band).max(1e-9);
    Finding::judged("band_used", used, "share of the spectrum", verdict).because(format!(
        "the image uses {:.2} of the {:.2} GHz that the radar fills: range cells of {:.2} m instead of \
         {:.2} m ([image] band_ghz)",
        width(common),
        width(spectrum_ghz),
        cell_m(common),
        cell_m(spectrum_ghz)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen() -> SurfaceSeen {
        SurfaceSeen {
            level_ns: 0.1,
            spread_ns: 0.05,
            expected_spread_ns: 0.1,
            drift_ns: 0.05,
            drift_sigma_ns: 0.1,
            is_calibrated: true,
        }
    }

    fn verdicts(seen: SurfaceSeen) -> Vec<(String, Verdict)> {
        surface(&seen)
            .into_iter()
            .map(|f| (f.name, f.verdict))
            .collect()
    }

    #[test]
    fn a_delay_two_nanoseconds_off_is_doubtful_and_one_of_ten_contradicts() {
        assert!(verdicts(seen()).iter().all(|(_, v)| *v == Verdict::Agrees));
        let off = |level_ns| verdicts(SurfaceSeen { level_ns, ..seen() })[0].clone();
        assert_eq!(off(2.0), ("surface_delay".to_owned(), Verdict::Doubtful));
        assert_eq!(off(-10.0).1, Verdict::Contradicts);
        let uncalibrated = SurfaceSeen {
            is_calibrated: false,
            level_ns: 5.0,
            ..seen()
        };
        assert!(
            verdicts(uncalibrated)
                .iter()
                .all(|(name, _)| name != "surface_delay")
        );
    }

    #[test]
    fn the_spread_of_a_wrong_offset_is_seen() {
        let spread = |spread_ns| {
            verdicts(SurfaceSeen {
                spread_ns,
                ..seen()
            })[1]
                .1
        };
        assert_eq!(spread(0.05), Verdict::Agrees);
        assert_eq!(spread(0.72), Verdict::Doubtful);
        assert_eq!(spread(3.0), Verdict::Contradicts);
    }

    #[test]
    fn coupling_before_zero_cannot_be() {
        let at = |delay_ns| {
            coupling(&CouplingSeen {
                delay_ns,
                spread_ns: 0.02,
            })
            .verdict
        };
        assert_eq!(at(1.0), Verdict::Agrees);
        assert_ne!(at(-1.7), Verdict::Agrees);
        assert_eq!(at(10.0), Verdict::Contradicts);
    }

    #[test]
    fn a_part_of_the_radars_band_is_doubted() {
        assert_eq!(band_used([3.1, 4.8], [3.0, 5.0]).verdict, Verdict::Agrees);
        assert_eq!(band_used([3.1, 4.0], [3.0, 5.0]).verdict, Verdict::Doubtful);
        let none = band_used([1.0, 2.0], [3.0, 5.0]);
        assert_eq!((none.value, none.verdict), (Some(0.0), Verdict::Doubtful));
    }

    #[test]
    fn a_band_below_the_radars_contradicts() {
        assert_eq!(band(1.0, [3.1, 4.8], [3.0, 5.0]).verdict, Verdict::Agrees);
        assert_eq!(
            band(0.0, [1.0, 2.0], [3.0, 5.0]).verdict,
            Verdict::Contradicts
        );
    }
}
