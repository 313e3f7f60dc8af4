//! Parameters of the atmosphere and the receivers.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[gnss]` of a scene file.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GnssModel {
    /// Lowest elevation at which a satellite is tracked (degrees).
    pub elevation_mask_deg: f64,
    /// Ratio of the ionosphere's delay to that of the broadcast model; 0 for none.
    pub ionosphere_scale: f64,
    /// Relative humidity of the troposphere, 0 to 1; negative for no troposphere at all.
    pub humidity: f64,
    /// A navigation file whose GPS satellites are in the sky, about the scene's `start_gpst`; by
    /// default a constellation is made up. Relative paths are relative to the scene file.
    pub navigation: Option<PathBuf>,
    /// The flying receiver.
    pub rover: ReceiverModel,
    /// The receiver on the ground.
    pub base: ReceiverModel,
}

/// One receiver and its surroundings. The defaults are a u-blox LEA-6T with a patch antenna under
/// an open sky.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReceiverModel {
    /// Time between epochs (s), in whole milliseconds.
    pub interval_s: f64,
    /// Receiver time of the epochs beyond multiples of the interval (s), in whole milliseconds.
    pub tag_offset_s: f64,
    /// Clock offset at the start (s); jumps of one millisecond keep it within half a millisecond.
    pub clock_offset_s: f64,
    /// Clock drift at the start (s/s).
    pub clock_drift: f64,
    /// Random walk of the drift (1/√s).
    pub clock_drift_walk: f64,
    /// Standard deviation of white code noise at the zenith (m); grows as √(1 + 1/sin² el)/√2.
    pub code_noise_m: f64,
    /// Standard deviation of white carrier-phase noise (m).
    pub phase_noise_m: f64,
    /// Standard deviation of the Doppler (Hz).
    pub doppler_noise_hz: f64,
    /// Standard deviation of code multipath at the horizon (m); falls with elevation as
    /// 0.2 + 0.8 exp(−el/25°).
    pub code_multipath_m: f64,
    /// Standard deviation of carrier-phase multipath at the horizon (m).
    pub phase_multipath_m: f64,
    /// Time over which multipath forgets itself (s).
    pub multipath_time_s: f64,
    /// Cycle slips per satellite and hour.
    pub slips_per_hour: f64,
    /// Shortest and longest time after acquiring a satellite during which the half cycle is not
    /// resolved (s). Satellites in view at the start have been tracked before.
    pub half_cycle_time_s: [f64; 2],
    /// Number of times an hour that one satellite is hidden (by trees, by the craft).
    pub blockages_per_hour: f64,
    /// Mean duration of a blockage (s).
    pub blockage_time_s: f64,
    /// Stretches of time (s from the start) without any satellite.
    pub outages_s: Vec<[f64; 2]>,
}

impl Default for GnssModel {
    fn default() -> Self {
        Self {
            elevation_mask_deg: 10.0,
            ionosphere_scale: 1.0,
            humidity: 0.5,
            navigation: None,
            rover: ReceiverModel {
                multipath_time_s: 8.0,
                ..ReceiverModel::default()
            },
            base: ReceiverModel {
                clock_offset_s: -1.7e-4,
                clock_drift: -1.1e-7,
                multipath_time_s: 60.0,
                blockages_per_hour: 0.0,
                slips_per_hour: 0.2,
                ..ReceiverModel::default()
            },
        }
    }
}

impl Default for ReceiverModel {
    fn default() -> Self {
        Self {
            interval_s: 0.2,
            tag_offset_s: 0.0,
            clock_offset_s: 2.3e-4,
            clock_drift: 2.4e-7,
            clock_drift_walk: 2e-10,
            code_noise_m: 0.35,
            phase_noise_m: 0.0015,
            doppler_noise_hz: 0.2,
            code_multipath_m: 1.0,
            phase_multipath_m: 0.006,
            multipath_time_s: 20.0,
            slips_per_hour: 2.0,
            half_cycle_time_s: [2.0, 8.0],
            blockages_per_hour: 1.0,
            blockage_time_s: 3.0,
            outages_s: Vec::new(),
        }
    }
}

impl ReceiverModel {
    /// This receiver without any error: perfect clock, no noise, no multipath, no slips, no gaps. Only
    /// geometry and atmosphere remain.
    #[must_use]
    pub fn perfect(self) -> Self {
        Self {
            clock_offset_s: 0.0,
            clock_drift: 0.0,
            clock_drift_walk: 0.0,
            ..self.noiseless()
        }
    }

    /// This receiver with its clock, but without noise, multipath, slips and blockages.
    #[must_use]
    pub fn noiseless(self) -> Self {
        Self {
            code_noise_m: 0.0,
            phase_noise_m: 0.0,
            doppler_noise_hz: 0.0,
            code_multipath_m: 0.0,
            phase_multipath_m: 0.0,
            slips_per_hour: 0.0,
            blockages_per_hour: 0.0,
            outages_s: Vec::new(),
            ..self
        }
    }
}

/// Reason why a GNSS model is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GnssError {
    /// A value outside its possible range.
    #[error("[gnss] {key}: expected {expected}, found {found}")]
    Value {
        /// The key.
        key: &'static str,
        /// What is possible.
        expected: &'static str,
        /// What was asked.
        found: f64,
    },
    /// Too few satellites above the elevation mask.
    #[error("[gnss]: expected at least 4 GPS satellites in view, found {most} at the most")]
    EmptySky {
        /// The largest number in view at one epoch.
        most: usize,
    },
}

pub(super) fn require(
    ok: bool,
    key: &'static str,
    expected: &'static str,
    found: f64,
) -> Result<(), GnssError> {
    if ok {
        Ok(())
    } else {
        Err(GnssError::Value {
            key,
            expected,
            found,
        })
    }
}

impl GnssModel {
    /// Refuses impossible parameters of atmosphere and receivers.
    ///
    /// # Errors
    /// The first impossible value.
    pub fn check(&self) -> Result<(), GnssError> {
        let within = |value: f64, low: f64, high: f64| value >= low && value <= high;
        let mask = self.elevation_mask_deg;
        require(
            within(mask, 0.0, 60.0),
            "elevation_mask_deg",
            "0 to 60 degrees",
            mask,
        )?;
        let scale = self.ionosphere_scale;
        require(
            within(scale, 0.0, 10.0),
            "ionosphere_scale",
            "0 to 10",
            scale,
        )?;
        require(
            within(self.humidity, -1.0, 1.0),
            "humidity",
            "−1 to 1",
            self.humidity,
        )?;
        self.rover.check()?;
        self.base.check()
    }
}

impl ReceiverModel {
    fn check(&self) -> Result<(), GnssError> {
        let within = |value: f64, low: f64, high: f64| value >= low && value <= high;
        let whole_ms = |value: f64| (value * 1e3 - (value * 1e3).round()).abs() < 1e-6;
        let interval = self.interval_s;
        require(
            within(interval, 0.05, 60.0) && whole_ms(interval),
            "interval_s",
            "0.05 to 60 s in whole milliseconds",
            interval,
        )?;
        let offset = self.tag_offset_s;
        require(
            within(offset, 0.0, interval) && whole_ms(offset),
            "tag_offset_s",
            "0 to interval_s in whole milliseconds",
            offset,
        )?;
        let clock = self.clock_offset_s;
        require(
            within(clock, -5e-4, 5e-4),
            "clock_offset_s",
            "−0.5 to 0.5 ms",
            clock,
        )?;
        require(
            within(self.clock_drift, -1e-5, 1e-5),
            "clock_drift",
            "−1e-5 to 1e-5",
            self.clock_drift,
        )?;
        for (key, value, high, expected) in [
            ("clock_drift_walk", self.clock_drift_walk, 1e-7, "0 to 1e-7"),
            ("code_noise_m", self.code_noise_m, 100.0, "0 to 100 m"),
            ("phase_noise_m", self.phase_noise_m, 0.1, "0 to 0.1 m"),
            (
                "doppler_noise_hz",
                self.doppler_noise_hz,
                100.0,
                "0 to 100 Hz",
            ),
            (
                "code_multipath_m",
                self.code_multipath_m,
                100.0,
                "0 to 100 m",
            ),
            (
                "phase_multipath_m",
                self.phase_multipath_m,
                0.05,
                "0 to 0.05 m",
            ),
            ("slips_per_hour", self.slips_per_hour, 3600.0, "0 to 3600"),
            (
                "blockages_per_hour",
                self.blockages_per_hour,
                3600.0,
                "0 to 3600",
            ),
            (
                "blockage_time_s",
                self.blockage_time_s,
                3600.0,
                "0 to 3600 s",
            ),
        ] {
            require(within(value, 0.0, high), key, expected, value)?;
        }
        // Multipath moves in steps of the interval, which must be well below its memory.
        require(
            within(self.multipath_time_s, 4.0 * interval, 1e5),
            "multipath_time_s",
            "at least 4 intervals",
            self.multipath_time_s,
        )?;
        let [shortest, longest] = self.half_cycle_time_s;
        require(
            within(shortest, 0.0, longest) && longest <= 600.0,
            "half_cycle_time_s",
            "shortest and longest time, rising, up to 600 s",
            longest,
        )?;
        for [from, to] in &self.outages_s {
            require(
                from.is_finite() && to.is_finite() && from < to,
                "outages_s",
                "begin before end",
                *from,
            )?;
        }
        Ok(())
    }
}
