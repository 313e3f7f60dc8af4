//! How the radio is to scan, and whether it does.

use acerra_radar::FAST_TIME_BIN_S;
use acerra_radar::mrm::RadarConfig;

use crate::message::FilterConfig;

/// The radio rounds its window up to this many samples.
pub const SAMPLE_QUANTUM: u32 = 96;

/// Settings of the radio before it scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    /// Window, integration, antennas, gain, code channel.
    pub config: RadarConfig,
    /// Interval between scans, µs; 0 is as fast as possible.
    pub scan_interval_us: u32,
    /// Parts of each scan that the radio sends.
    pub filter: FilterConfig,
}

impl Setup {
    /// Raw scans with this configuration.
    #[must_use]
    pub const fn raw(config: RadarConfig, scan_interval_us: u32) -> Self {
        Self {
            config,
            scan_interval_us,
            filter: FilterConfig::RAW_ONLY,
        }
    }
}

/// Samples of a configuration's window, rounded up to the radio's quantum.
///
/// ```
/// use acerra_radar::mrm::RadarConfig;
/// let flown = RadarConfig { scan_start_ps: 16_670, scan_stop_ps: 86_982, ..RadarConfig::default() };
/// assert_eq!(acerra_record::driver::window_samples(&flown), 1152);
/// ```
#[must_use]
pub fn window_samples(config: &RadarConfig) -> u32 {
    let length_ps = f64::from(config.scan_stop_ps) - f64::from(config.scan_start_ps);
    let step_ps = f64::from(config.scan_resolution_bins.max(1)) * FAST_TIME_BIN_S * 1e12;
    // A window that fills its quanta but for rounding to whole picoseconds takes no further one.
    let samples = ((length_ps - 1.0).max(0.0) / step_ps).ceil() as u32;
    samples.div_ceil(SAMPLE_QUANTUM).max(1) * SAMPLE_QUANTUM
}

/// A setting that reads back otherwise than it was set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Name of the field.
    pub field: &'static str,
    /// Value set.
    pub wanted: i64,
    /// Value read back.
    pub found: i64,
}

/// The first field in which the configuration read back differs from the one that was set. The end of the
/// window may be later, by less than the quantum to which the radio rounds it.
#[must_use]
pub fn first_mismatch(wanted: &RadarConfig, found: &RadarConfig) -> Option<Mismatch> {
    let pair = |field, wanted: i64, found: i64| Mismatch {
        field,
        wanted,
        found,
    };
    let stop_is_rounded = found.scan_stop_ps >= wanted.scan_stop_ps - 1
        && window_samples(found) == window_samples(wanted);
    let stop_wanted = if stop_is_rounded {
        found.scan_stop_ps
    } else {
        wanted.scan_stop_ps
    };
    [
        pair(
            "scan start (ps)",
            wanted.scan_start_ps.into(),
            found.scan_start_ps.into(),
        ),
        pair(
            "scan stop (ps)",
            stop_wanted.into(),
            found.scan_stop_ps.into(),
        ),
        pair(
            "scan resolution (bins)",
            wanted.scan_resolution_bins.into(),
            found.scan_resolution_bins.into(),
        ),
        pair(
            "pulse integration index",
            wanted.integration_index.into(),
            found.integration_index.into(),
        ),
        pair(
            "antenna mode",
            wanted.antenna_mode.into(),
            found.antenna_mode.into(),
        ),
        pair(
            "transmit gain",
            wanted.transmit_gain.into(),
            found.transmit_gain.into(),
        ),
        pair(
            "code channel",
            wanted.code_channel.into(),
            found.code_channel.into(),
        ),
    ]
    .into_iter()
    .find(|pair| pair.wanted != pair.found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_may_be_rounded_up_to_its_quantum_only() {
        let wanted = RadarConfig {
            scan_start_ps: 0,
            scan_stop_ps: 50_000,
            ..RadarConfig::default()
        };
        // 820 samples wanted, 864 made: 52 734 ps.
        assert_eq!(window_samples(&wanted), 864);
        let rounded = RadarConfig {
            scan_stop_ps: 52_734,
            ..wanted
        };
        assert_eq!(first_mismatch(&wanted, &rounded), None);
        let further = RadarConfig {
            scan_stop_ps: 58_000,
            ..wanted
        };
        assert_eq!(
            first_mismatch(&wanted, &further).map(|m| (m.field, m.found)),
            Some(("scan stop (ps)", 58_000))
        );
        let weaker = RadarConfig {
            transmit_gain: 40,
            ..wanted
        };
        assert_eq!(
            first_mismatch(&wanted, &weaker).map(|m| m.field),
            Some("transmit gain")
        );
    }
}
