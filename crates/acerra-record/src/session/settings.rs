//! The session file: which radio, which receiver, which flight.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use acerra_radar::mrm::RadarConfig;
use acerra_settings::{Rule, SyntaxError, ValueError, check, rules, within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::live_section::LiveSection;
use crate::driver::Setup;
use crate::gnss::Receiver;

/// A session file.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// The radio.
    #[serde(default)]
    pub radio: RadioSection,
    /// The receiver that flies; absent where none is logged.
    #[serde(default)]
    pub gnss: Option<GnssSection>,
    /// What is planned.
    #[serde(default)]
    pub flight: FlightSection,
    /// The image that forms while the recording goes on.
    #[serde(default)]
    pub live: LiveSection,
    /// Tables of the written campaign file: settings of `focus` for the recording.
    #[serde(default)]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub campaign: toml::Table,
}

/// `[radio]`: where the radio is and how it scans.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadioSection {
    /// Address and UDP port.
    pub address: Option<SocketAddr>,
    /// Serial or USB port, instead of an address.
    pub serial: Option<String>,
    /// Rate of the serial port (bits per second).
    pub baud: u32,
    /// Start and end of the scan window (ps). The radio rounds the end up to 96 samples.
    pub window_ps: [i32; 2],
    /// Pulse integration index: 2^PII pulses for each sample.
    pub integration_index: u16,
    /// 0 TxA/RxA, 1 TxB/RxB, 2 TxA/RxB, 3 TxB/RxA.
    pub antenna_mode: u8,
    /// Transmit gain index, 0 to 63. The operator is responsible for the legal limit of radiated power, which
    /// depends on place and antenna.
    pub transmit_gain: u8,
    /// Code channel, 0 to 10.
    pub code_channel: u8,
    /// Interval between scans (ms); 0 is as fast as possible.
    pub scan_interval_ms: f64,
    /// Time from the middle of a scan to its message at this computer (ms), if measured; by default half the
    /// scan's estimated duration, with the remaining uncertainty.
    pub latency_ms: Option<f64>,
    /// Standard deviation of that time (ms), if measured.
    pub latency_sigma_ms: Option<f64>,
    /// Time from the radio's pulse on the receiver's EXTINT to the middle of the scan (ms), if measured; by
    /// default half the scan's estimated duration, with the remaining uncertainty.
    pub mark_delay_ms: Option<f64>,
    /// Standard deviation of that time (ms), if measured.
    pub mark_delay_sigma_ms: Option<f64>,
}

impl Default for RadioSection {
    fn default() -> Self {
        Self {
            address: None,
            serial: None,
            baud: 115_200,
            window_ps: [0, 70_312],
            integration_index: 11,
            antenna_mode: 2,
            transmit_gain: 63,
            code_channel: 0,
            scan_interval_ms: 0.0,
            latency_ms: None,
            latency_sigma_ms: None,
            mark_delay_ms: None,
            mark_delay_sigma_ms: None,
        }
    }
}

/// `[gnss]`: the receiver that flies.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GnssSection {
    /// TCP address and port that the receiver's bytes come from.
    #[serde(default)]
    pub address: Option<SocketAddr>,
    /// Serial or USB port, instead of an address.
    #[serde(default)]
    pub serial: Option<String>,
    /// Rate of the serial port (bits per second).
    #[serde(default = "default_gnss_baud")]
    pub baud: u32,
    /// Which receiver it is, to be configured for raw output; `"as-is"` leaves it alone.
    #[serde(default)]
    pub receiver: Receiver,
    /// Measurements in a second.
    #[serde(default = "default_rate_hz")]
    pub rate_hz: f64,
    /// Time from a measurement to its first byte at this computer (ms), if measured. Data alone cannot
    /// determine the shortest delay.
    #[serde(default)]
    pub latency_ms: f64,
    /// Standard deviation of that time (ms).
    #[serde(default = "default_latency_sigma_ms")]
    pub latency_sigma_ms: f64,
    /// Where the kernel stamps the receiver's pulse per second: `/dev/pps0`, `/sys/class/pps/pps0/assert`, or a
    /// file of the latter's content. GPS time then comes from the pulses, and `latency_ms` is measured.
    #[serde(default)]
    pub pps: Option<String>,
}

fn default_gnss_baud() -> u32 {
    115_200
}

fn default_rate_hz() -> f64 {
    5.0
}

fn default_latency_sigma_ms() -> f64 {
    20.0
}

/// `[flight]`: the planned flight, for checks before and during it.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct FlightSection {
    /// Height above ground (m).
    pub height_m: Option<f64>,
    /// Slant range to the farthest target (m).
    pub far_range_m: Option<f64>,
    /// Speed over ground (m/s).
    pub speed_m_s: Option<f64>,
    /// Fast time at which range is zero (ns).
    pub delay_ns: Option<f64>,
    /// Time after which recording ends by itself (s).
    pub stop_after_s: Option<f64>,
}

/// Why a session file is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Not TOML, an unknown key, or a value of the wrong form.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// A value outside its possible range.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// No address of an instrument, or two.
    #[error("[{table}]: expected either address or serial")]
    Way {
        /// The table.
        table: &'static str,
    },
}

impl Session {
    /// Reads a session from the text of its file.
    ///
    /// # Errors
    /// Unknown keys, values of the wrong form, values that cannot be.
    ///
    /// ```
    /// use acerra_record::session::Session;
    /// let session = Session::parse("[radio]\naddress = \"192.168.1.100:21210\"\n")?;
    /// assert_eq!(session.radio.integration_index, 11);
    /// assert!(Session::parse("[radio]\ngain = 63\n").is_err());
    /// # Ok::<(), acerra_record::session::SettingsError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, SettingsError> {
        let session: Self = acerra_settings::parse(text)?;
        session.check()?;
        Ok(session)
    }

    fn check(&self) -> Result<(), SettingsError> {
        let radio = &self.radio;
        radio.way()?;
        let [start, stop] = radio.window_ps;
        let window = Rule::new(
            "window_ps",
            start < stop && i64::from(stop) - i64::from(start) < 10_000_000,
            "a start before its end, and less than 10 µs",
            format!("[{start}, {stop}]"),
        );
        check("radio", &[window])?;
        let rules = rules!(radio as "{}" {
            integration_index: within(6..=15) => "6 to 15",
            antenna_mode: within(0..=3) => "0 to 3",
            transmit_gain: within(0..=63) => "0 to 63",
            code_channel: within(0..=10) => "0 to 10",
            scan_interval_ms: within(0.0..=60_000.0) => "0 to 60000",
        });
        check("radio", &rules)?;
        for (key, value_ms, least_ms, expected) in [
            ("latency_ms", radio.latency_ms, 0.0, "0 to 5000"),
            ("latency_sigma_ms", radio.latency_sigma_ms, 0.0, "0 to 5000"),
            (
                "mark_delay_ms",
                radio.mark_delay_ms,
                -5_000.0,
                "-5000 to 5000",
            ),
            (
                "mark_delay_sigma_ms",
                radio.mark_delay_sigma_ms,
                0.0,
                "0 to 5000",
            ),
        ] {
            let value_ms = value_ms.unwrap_or(0.0);
            check(
                "radio",
                &[Rule::range(key, value_ms, least_ms..=5_000.0, expected)],
            )?;
        }
        let baud = rules!(radio as "{}" { baud: within(1200..=10_000_000) => "1200 to 10000000" });
        check("radio", &baud)?;
        if let Some(gnss) = &self.gnss {
            gnss.check()?;
        }
        self.live.check()?;
        self.flight.check()
    }

    /// These settings with relative paths of `[campaign]` resolved in the session file's folder, so that they
    /// are valid from the recording's.
    #[must_use]
    pub fn resolved_in(mut self, folder: &Path) -> Self {
        const PATHS: [(&str, &str); 5] = [
            ("gnss", "base"),
            ("gnss", "rover"),
            ("gnss", "navigation"),
            ("gnss", "config"),
            ("trajectory", "file"),
        ];
        for (table, key) in PATHS {
            let value = self.campaign.get_mut(table).and_then(|t| t.get_mut(key));
            if let Some(value) = value {
                resolve(value, folder);
            }
        }
        self
    }
}

fn resolve(value: &mut toml::Value, folder: &Path) {
    match value {
        toml::Value::String(path) => {
            let absolute = std::path::absolute(folder.join(&*path));
            *path = absolute
                .unwrap_or_else(|_| PathBuf::from(&*path))
                .display()
                .to_string();
        }
        toml::Value::Array(list) => list.iter_mut().for_each(|value| resolve(value, folder)),
        _ => {}
    }
}

/// The address of the instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way<'a> {
    /// Over the network.
    Address(SocketAddr),
    /// By a serial or USB port.
    Serial(&'a str),
}

fn way<'a>(
    table: &'static str,
    address: Option<SocketAddr>,
    serial: Option<&'a str>,
) -> Result<Way<'a>, SettingsError> {
    match (address, serial) {
        (Some(address), None) => Ok(Way::Address(address)),
        (None, Some(port)) => Ok(Way::Serial(port)),
        _ => Err(SettingsError::Way { table }),
    }
}

impl RadioSection {
    /// The way to the radio.
    ///
    /// # Errors
    /// None, or two.
    pub fn way(&self) -> Result<Way<'_>, SettingsError> {
        way("radio", self.address, self.serial.as_deref())
    }

    /// Settings of the radio.
    #[must_use]
    pub fn setup(&self) -> Setup {
        let config = RadarConfig {
            scan_start_ps: self.window_ps[0],
            scan_stop_ps: self.window_ps[1],
            integration_index: self.integration_index,
            antenna_mode: self.antenna_mode,
            transmit_gain: self.transmit_gain,
            code_channel: self.code_channel,
            ..RadarConfig::default()
        };
        Setup::raw(config, (1000.0 * self.scan_interval_ms).round() as u32)
    }
}

impl GnssSection {
    /// The way to the receiver.
    ///
    /// # Errors
    /// None, or two.
    pub fn way(&self) -> Result<Way<'_>, SettingsError> {
        way("gnss", self.address, self.serial.as_deref())
    }

    fn check(&self) -> Result<(), SettingsError> {
        self.way()?;
        check(
            "gnss",
            &rules!(self as "{}" {
                rate_hz: within(0.1..=50.0) => "0.1 to 50",
                latency_ms: within(0.0..=5_000.0) => "0 to 5000",
                latency_sigma_ms: within(0.0..=5_000.0) => "0 to 5000",
                baud: within(1200..=10_000_000) => "1200 to 10000000",
            }),
        )?;
        let is_path = self.pps.as_ref().is_none_or(|path| !path.is_empty());
        let pps = Rule::new("pps", is_path, "a path, such as /dev/pps0", "none");
        Ok(check("gnss", &[pps])?)
    }
}

impl FlightSection {
    fn check(&self) -> Result<(), SettingsError> {
        let positive = |key, value: Option<f64>| {
            let value = value.unwrap_or(1.0);
            Rule::new(key, value > 0.0 && value < 1e6, "a positive number", value)
        };
        Ok(check(
            "flight",
            &[
                positive("height_m", self.height_m),
                positive("far_range_m", self.far_range_m),
                positive("speed_m_s", self.speed_m_s),
                positive("stop_after_s", self.stop_after_s),
                Rule::range(
                    "delay_ns",
                    self.delay_ns.unwrap_or(0.0),
                    -1e4..=1e4,
                    "-10000 to 10000",
                ),
            ],
        )?)
    }
}
