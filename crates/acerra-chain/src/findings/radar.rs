//! Findings on a track's radargram: direct coupling and spectrum, and by other topics clock, delay and surface echo.

use acerra_radar::Radargram;
use acerra_radar::quality::{self, spectrum_occupancy};

use super::delay::{delay_before_zero, delay_seen};
use super::grid::LIGHT_SPEED_M_S;
use super::surface::{self, follows_height};
use super::{altimeter, clock};
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::prepare::{Prepared, Track};

/// Coupling: least level above the rest of the mean trace (dB), largest wander (s), and largest distance from
/// fast time zero (s).
const COUPLING_CONTRAST_DB: f64 = 20.0;
const COUPLING_SPREAD_S: f64 = 0.1e-9;

const COUPLING_REACH_S: f64 = 25e-9;

/// Judges the radargram of a track; no finding where the track's log holds spectra.
///
/// The spectrum is that of the recorded traces. For an image below ground it is that of the traces without coupling and
/// surface echo: close to the ground the direct wave is stronger than the echoes, and has other frequencies.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    band_hz: [f64; 2],
    is_below_ground: bool,
) -> Vec<Finding> {
    let mut findings = clock::weigh(prepared, track);
    let Some(traces) = &track.cleaned else {
        return findings;
    };
    findings.extend(delay_before_zero(-1e9 * traces.shift_s));
    findings.extend(delay_seen(prepared, track, traces.shift_s));
    if follows_height(track) {
        findings.extend(surface::weigh(prepared, track));
    } else {
        findings.extend(altimeter::weigh(prepared, track, traces));
    }
    findings.extend(coupling_seen(&traces.raw).map(|seen| coupling(&seen)));
    let of_echoes = if is_below_ground {
        &traces.clean
    } else {
        &traces.raw
    };
    if let Some(spectrum) = spectrum_occupancy(of_echoes) {
        let ghz = |band: [f64; 2]| band.map(|f| f * 1e-9);
        let occupied = spectrum.occupied_share_of(band_hz);
        findings.push(band(occupied, ghz(band_hz), ghz(spectrum.band_hz)));
        findings.push(band_used(ghz(band_hz), ghz(spectrum.band_hz)));
    }
    findings
}

/// The direct coupling, where the window begins before it and its echo is clear and constant.
fn coupling_seen(raw: &Radargram) -> Option<CouplingSeen> {
    let seen = quality::coupling(raw)?;
    let is_coupling = seen.contrast_db >= COUPLING_CONTRAST_DB
        && seen.spread_s <= COUPLING_SPREAD_S
        && seen.fast_time_s.abs() <= COUPLING_REACH_S
        && raw.fast_time_start_s < seen.fast_time_s - 1e-9;
    is_coupling.then_some(CouplingSeen {
        delay_ns: 1e9 * seen.fast_time_s,
        spread_ns: 1e9 * seen.spread_s,
    })
}

/// The direct coupling between the antennas.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CouplingSeen {
    /// Fast time after zero-timing (ns).
    pub delay_ns: f64,
    /// Standard deviation over the traces (ns).
    pub spread_ns: f64,
}

/// Distance of the antennas up to which direct coupling is searched (m).
const ANTENNA_SEPARATION_M: f64 = 0.6;

/// Judges the direct coupling: with fast time zero at range zero it arrives after the time from
/// antenna to antenna, never before zero.
fn coupling(seen: &CouplingSeen) -> Finding {
    let longest_ns = 1e9 * ANTENNA_SEPARATION_M / LIGHT_SPEED_M_S;
    let middle_ns = 0.5 * longest_ns;
    // The envelope's maximum may be half a pulse (0.6 ns) off its delay.
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

/// Judges the stated band: `occupied` is the share of its frequencies at which the radar's spectrum is less
/// than 10 dB below its maximum.
fn band(occupied: f64, band_ghz: [f64; 2], spectrum_ghz: [f64; 2]) -> Finding {
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

/// Share of the radar's own band below which the stated band is doubted: the size of the range cell grows
/// with the inverse of the band.
const LEAST_USED: f64 = 0.6;

/// Judges the share of the radar's own band that the stated band uses.
fn band_used(band_ghz: [f64; 2], spectrum_ghz: [f64; 2]) -> Finding {
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
