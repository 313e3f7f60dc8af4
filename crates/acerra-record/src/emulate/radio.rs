//! The emulated radio's answers: a state and the effect of each request on it.

use acerra_radar::mrm::RadarConfig;

use crate::driver::{SAMPLE_QUANTUM, window_samples};
use crate::message::{
    ConfigConfirm, ControlRequest, FilterConfig, FilterConfirm, Message, ModeConfirm,
    OPERATING_MODE_MRM, Packet, SLEEP_MODE_ACTIVE, StatusCode, StatusInfo,
};

/// State of an emulated radio; a restart clears all but a persistent configuration.
#[derive(Debug, Clone)]
pub struct RadioState {
    config: RadarConfig,
    filter: FilterConfig,
    sleep_mode: u32,
    /// Interval of the scans in progress, µs, and the number left; `None` while none are made.
    scanning: Option<(u32, u16)>,
    temperature_quarter_c: i32,
}

/// Side effect of a request on the emulator, in addition to the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    None,
    /// Scans begin.
    Start,
    /// Scans end.
    Stop,
    /// The radio restarts.
    Reboot,
}

impl RadioState {
    /// A radio fresh from power-on with this configuration.
    #[must_use]
    pub fn new(config: RadarConfig) -> Self {
        Self {
            config,
            filter: FilterConfig::RAW_ONLY,
            sleep_mode: SLEEP_MODE_ACTIVE,
            scanning: None,
            temperature_quarter_c: 4 * 38,
        }
    }

    /// The configuration in force.
    #[must_use]
    pub fn config(&self) -> &RadarConfig {
        &self.config
    }

    /// Interval of the scans in progress, µs.
    #[must_use]
    pub fn scan_interval_us(&self) -> Option<u32> {
        self.scanning.map(|(interval_us, _)| interval_us)
    }

    /// One scan was made; the last of a counted request ends the scans.
    pub fn count_scan(&mut self) {
        if let Some((_, left)) = &mut self.scanning
            && *left != ControlRequest::CONTINUOUS
        {
            *left -= 1;
            if *left == 0 {
                self.scanning = None;
            }
        }
    }

    /// Clears the state that does not outlive a restart.
    pub fn restart(&mut self) {
        let config = if self.config.persist == 0 {
            RadarConfig::default()
        } else {
            self.config
        };
        *self = Self::new(config);
    }

    /// Answers a request; `None` for other messages. `accepts` decides which configurations the source of
    /// scans can serve.
    pub fn answer(
        &mut self,
        packet: &Packet,
        clock_ms: u32,
        accepts: impl Fn(&RadarConfig) -> bool,
    ) -> Option<(Packet, Effect)> {
        let status = StatusCode::Success;
        let mut effect = Effect::None;
        let message = match &packet.message {
            Message::SetConfigRequest(config) => {
                let allowed = config.is_plausible() && accepts(config);
                if allowed {
                    self.config = with_whole_quanta(config);
                }
                Message::SetConfigConfirm(if allowed {
                    status
                } else {
                    StatusCode::UnsupportedValue
                })
            }
            Message::GetConfigRequest => Message::GetConfigConfirm(ConfigConfirm {
                config: self.config,
                timestamp_ms: clock_ms,
                status,
            }),
            Message::ControlRequest(request) => {
                let (answer, what) = self.control(*request);
                effect = what;
                Message::ControlConfirm(answer)
            }
            Message::SetFilterConfigRequest(filter) => {
                self.filter = *filter;
                Message::SetFilterConfigConfirm(status)
            }
            Message::GetFilterConfigRequest => Message::GetFilterConfigConfirm(FilterConfirm {
                filter: self.filter,
                status,
            }),
            Message::GetStatusInfoRequest => {
                Message::GetStatusInfoConfirm(Box::new(self.status_info()))
            }
            Message::RebootRequest => {
                effect = Effect::Reboot;
                Message::RebootConfirm
            }
            Message::SetOpmodeRequest(mode) => Message::SetOpmodeConfirm(ModeConfirm {
                mode: OPERATING_MODE_MRM,
                status: if *mode == OPERATING_MODE_MRM {
                    status
                } else {
                    StatusCode::UnsupportedValue
                },
            }),
            Message::SetSleepmodeRequest(mode) => {
                self.sleep_mode = *mode;
                Message::SetSleepmodeConfirm(ModeConfirm {
                    mode: *mode,
                    status,
                })
            }
            _ => return None,
        };
        let id = packet.id;
        Some((Packet { id, message }, effect))
    }

    fn control(&mut self, request: ControlRequest) -> (StatusCode, Effect) {
        match request.scan_count {
            0 => {
                self.scanning = None;
                (StatusCode::Success, Effect::Stop)
            }
            _ if self.sleep_mode != SLEEP_MODE_ACTIVE => (StatusCode::WrongMode, Effect::None),
            count => {
                self.scanning = Some((request.scan_interval_us, count));
                (StatusCode::Success, Effect::Start)
            }
        }
    }

    fn status_info(&self) -> StatusInfo {
        let mut package_version = [0; 32];
        let name = b"emulated by acerra";
        package_version[..name.len()].copy_from_slice(name);
        StatusInfo {
            mrm_major: 1,
            mrm_minor: 2,
            mrm_build: 0,
            kernel_major: 1,
            kernel_minor: 0,
            kernel_build: 0,
            fpga_version: 1,
            fpga_year: 19,
            fpga_month: 8,
            fpga_day: 4,
            serial_number: 0xACE0_0001,
            board_revision: b'A',
            power_on_bit_test: 0,
            board_type: 4,
            transmitter_configuration: 0,
            temperature_quarter_c: self.temperature_quarter_c,
            package_version,
            status: StatusCode::Success,
        }
    }
}

/// The configuration with its window's end at the end of the last quantum of samples.
fn with_whole_quanta(config: &RadarConfig) -> RadarConfig {
    let samples = window_samples(config);
    let step_ps = f64::from(config.scan_resolution_bins) * acerra_radar::FAST_TIME_BIN_S * 1e12;
    let length_ps = f64::from(samples) * step_ps;
    let asked_ps = f64::from(config.scan_stop_ps) - f64::from(config.scan_start_ps);
    // Whole picoseconds: a window that fills its quanta stays as it is.
    if length_ps - asked_ps < step_ps * f64::from(SAMPLE_QUANTUM) && length_ps - asked_ps > 1.0 {
        let scan_stop_ps = (f64::from(config.scan_start_ps) + length_ps).floor() as i32;
        return RadarConfig {
            scan_stop_ps,
            ..*config
        };
    }
    *config
}
