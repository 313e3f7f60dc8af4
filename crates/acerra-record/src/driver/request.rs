//! Requests and their confirms.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use acerra_radar::mrm::RadarConfig;

use super::error::DriverError;
use super::intake::{Intake, Taken};
use super::setup::{Mismatch, Setup, first_mismatch};
use crate::link::{Arrival, Link};
use crate::message::{
    ConfigConfirm, ControlRequest, FilterConfig, Message, OPERATING_MODE_MRM, Packet, StatusCode,
    StatusInfo,
};

/// Time to wait for an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequestOptions {
    /// Time waited for a confirm.
    pub timeout: Duration,
    /// Times a request is sent.
    pub attempts: u32,
}

impl Default for RequestOptions {
    fn default() -> Self {
        Self {
            timeout: Duration::from_millis(500),
            attempts: 4,
        }
    }
}

/// A radio at the other end of a link.
///
/// Every message that comes, scans among them, is kept for [`Driver::next_arrival`] and counted,
/// also while a confirm is waited for.
pub struct Driver<L> {
    link: L,
    options: RequestOptions,
    next_id: u16,
    intake: Intake,
    arrivals: VecDeque<Arrival>,
}

impl<L: Link> Driver<L> {
    /// A driver over a link.
    pub fn new(link: L, options: RequestOptions) -> Self {
        Self {
            link,
            options,
            next_id: 1,
            intake: Intake::default(),
            arrivals: VecDeque::new(),
        }
    }

    /// Versions, serial number, temperature.
    ///
    /// # Errors
    /// A link that fails, no answer, a refusal.
    pub fn status(&mut self) -> Result<StatusInfo, DriverError> {
        let info = self.request(&Message::GetStatusInfoRequest, |m| match m {
            Message::GetStatusInfoConfirm(info) => Some(*info),
            _ => None,
        })?;
        self.accepted("GET_STATUSINFO_REQUEST", info.status)?;
        Ok(info)
    }

    /// The configuration in force and the radio's clock.
    ///
    /// # Errors
    /// A link that fails, no answer, a refusal.
    pub fn config(&mut self) -> Result<ConfigConfirm, DriverError> {
        let confirm = self.request(&Message::GetConfigRequest, |m| match m {
            Message::GetConfigConfirm(confirm) => Some(confirm),
            _ => None,
        })?;
        self.accepted("GET_CONFIG_REQUEST", confirm.status)?;
        Ok(confirm)
    }

    /// Puts the radio into the mode of the monostatic radar, stops scans, configures it, and reads
    /// everything back. Returns the configuration in force, whose window the radio may have rounded
    /// up.
    ///
    /// # Errors
    /// A link that fails, no answer, a refusal, settings that read back otherwise.
    pub fn set_up(&mut self, setup: &Setup) -> Result<RadarConfig, DriverError> {
        let mode = self.request(
            &Message::SetOpmodeRequest(OPERATING_MODE_MRM),
            |m| match m {
                Message::SetOpmodeConfirm(confirm) => Some(confirm),
                _ => None,
            },
        )?;
        self.accepted("SET_OPMODE_REQUEST", mode.status)?;
        self.same(
            "operating mode",
            OPERATING_MODE_MRM.into(),
            mode.mode.into(),
        )?;
        self.stop()?;
        self.set_config(&setup.config)?;
        let found = self.config()?.config;
        if let Some(mismatch) = first_mismatch(&setup.config, &found) {
            return Err(self.read_back(mismatch));
        }
        self.set_filter(setup.filter)?;
        Ok(found)
    }

    fn set_config(&mut self, config: &RadarConfig) -> Result<(), DriverError> {
        let status = self.request(&Message::SetConfigRequest(*config), |m| match m {
            Message::SetConfigConfirm(status) => Some(status),
            _ => None,
        })?;
        self.accepted("SET_CONFIG_REQUEST", status)
    }

    fn set_filter(&mut self, filter: FilterConfig) -> Result<(), DriverError> {
        let status = self.request(&Message::SetFilterConfigRequest(filter), |m| match m {
            Message::SetFilterConfigConfirm(status) => Some(status),
            _ => None,
        })?;
        self.accepted("SET_FILTER_CONFIG_REQUEST", status)?;
        let confirm = self.request(&Message::GetFilterConfigRequest, |m| match m {
            Message::GetFilterConfigConfirm(confirm) => Some(confirm),
            _ => None,
        })?;
        self.accepted("GET_FILTER_CONFIG_REQUEST", confirm.status)?;
        let found = confirm.filter.filter_mask;
        self.same("filter mask", filter.filter_mask.into(), found.into())
    }

    /// Starts scans until [`Driver::stop`].
    ///
    /// # Errors
    /// A link that fails, no answer, a refusal.
    pub fn start(&mut self, scan_interval_us: u32) -> Result<(), DriverError> {
        self.control(ControlRequest::continuous(scan_interval_us))
    }

    /// Stops scans. Messages in transit may still arrive.
    ///
    /// # Errors
    /// A link that fails, no answer, a refusal.
    pub fn stop(&mut self) -> Result<(), DriverError> {
        self.control(ControlRequest::STOP)
    }

    fn control(&mut self, request: ControlRequest) -> Result<(), DriverError> {
        let status = self.request(&Message::ControlRequest(request), |m| match m {
            Message::ControlConfirm(status) => Some(status),
            _ => None,
        })?;
        self.accepted("CONTROL_REQUEST", status)
    }

    /// Restarts the radio.
    ///
    /// # Errors
    /// A link that fails, no answer.
    pub fn reboot(&mut self) -> Result<(), DriverError> {
        self.request(&Message::RebootRequest, |m| {
            (m == Message::RebootConfirm).then_some(())
        })
    }

    /// The next message that came, in the order of arrival; waits for one where none is left.
    ///
    /// # Errors
    /// A link that fails.
    pub fn next_arrival(&mut self, wait: Duration) -> Result<Option<Arrival>, DriverError> {
        if self.arrivals.is_empty() {
            self.hear(wait)?;
        }
        Ok(self.arrivals.pop_front())
    }

    /// The counts of messages, and whole scans.
    pub fn intake(&mut self) -> &mut Intake {
        &mut self.intake
    }

    /// The link.
    pub fn link(&mut self) -> &mut L {
        &mut self.link
    }

    /// Sends a request until its confirm comes.
    fn request<T>(
        &mut self,
        message: &Message,
        confirmed: impl Fn(Message) -> Option<T>,
    ) -> Result<T, DriverError> {
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1);
        let bytes = Packet {
            id,
            message: message.clone(),
        }
        .encode();
        for attempt in 0..self.options.attempts {
            if attempt > 0 {
                self.intake.count_retry();
            }
            self.link.send(&bytes)?;
            let until = Instant::now() + self.options.timeout;
            while let Some(left) = until
                .checked_duration_since(Instant::now())
                .filter(|left| !left.is_zero())
            {
                let Some(packet) = self.hear(left)? else {
                    continue;
                };
                if packet.id == id
                    && let Some(answer) = confirmed(packet.message)
                {
                    return Ok(answer);
                }
            }
        }
        Err(DriverError::Silent {
            peer: self.link.peer(),
            request: message.kind().name(),
            attempts: self.options.attempts,
            timeout: self.options.timeout,
        })
    }

    /// Waits for one message and takes it in; returns it if it is not a scan.
    fn hear(&mut self, wait: Duration) -> Result<Option<Packet>, DriverError> {
        let Some(arrival) = self.link.receive(wait)? else {
            return Ok(None);
        };
        let taken = self.intake.take(&arrival.body);
        self.arrivals.push_back(arrival);
        Ok(match taken {
            Taken::Other(packet) => Some(packet),
            Taken::Scan(_) | Taken::Undecodable => None,
        })
    }

    fn accepted(&self, request: &'static str, status: StatusCode) -> Result<(), DriverError> {
        match status {
            StatusCode::Success => Ok(()),
            status => Err(DriverError::Refused {
                peer: self.link.peer(),
                request,
                status,
            }),
        }
    }

    fn same(&self, field: &'static str, wanted: i64, found: i64) -> Result<(), DriverError> {
        if wanted == found {
            return Ok(());
        }
        Err(self.read_back(Mismatch {
            field,
            wanted,
            found,
        }))
    }

    fn read_back(&self, mismatch: Mismatch) -> DriverError {
        DriverError::ReadBack {
            peer: self.link.peer(),
            mismatch,
        }
    }
}
