//! Every message of the radio's MRM interface, between bytes and fields.
//!
//! All fields are big-endian; each message begins with its type and an id that a confirm repeats of its
//! request. Each type has one length, and every byte is kept, reserved fields and unused places included:
//! decoding and encoding give the same bytes. Types and lengths follow [`acerra_radar::mrm::MessageType`];
//! SCAN_INFO headers are decoded by the reader of captures.

mod configuration;
mod control;
mod detection;
mod fields;
mod filter;
mod mode;
mod scan;
mod status_code;
mod status_info;

use acerra_radar::mrm::{HeaderFault, MessageType, RadarConfig};
use thiserror::Error;

pub use configuration::ConfigConfirm;
pub use control::ControlRequest;
pub use detection::{DETECTIONS_PER_MESSAGE, Detection, DetectionList};
pub use filter::{FilterConfig, FilterConfirm};
pub use mode::{ModeConfirm, OPERATING_MODE_MRM, SLEEP_MODE_ACTIVE};
pub use scan::ScanMessage;
pub use status_code::StatusCode;
pub use status_info::StatusInfo;

use fields::Fields;

/// Longest message, bytes.
pub const MAX_MESSAGE_BYTES: usize = MessageType::ScanInfo.bytes();

/// A message with its id.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// Id: of a request, chosen by the client; of a confirm, its request's; of a scan, its number.
    pub id: u16,
    /// The message.
    pub message: Message,
}

/// Fields of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// Configures the radio.
    SetConfigRequest(RadarConfig),
    /// Whether it was configured.
    SetConfigConfirm(StatusCode),
    /// Asks for the configuration.
    GetConfigRequest,
    /// The configuration in force.
    GetConfigConfirm(ConfigConfirm),
    /// Starts or stops scans.
    ControlRequest(ControlRequest),
    /// Whether they were started or stopped.
    ControlConfirm(StatusCode),
    /// Sets the parts of each scan that are sent.
    SetFilterConfigRequest(FilterConfig),
    /// Whether it was set.
    SetFilterConfigConfirm(StatusCode),
    /// Requests the parts of each scan that are sent.
    GetFilterConfigRequest,
    /// Parts of each scan that are sent.
    GetFilterConfigConfirm(FilterConfirm),
    /// Detections of the motion filter.
    DetectionListInfo(Box<DetectionList>),
    /// Asks for versions and temperature.
    GetStatusInfoRequest,
    /// Versions and temperature.
    GetStatusInfoConfirm(Box<StatusInfo>),
    /// Restarts the radio.
    RebootRequest,
    /// The radio will restart.
    RebootConfirm,
    /// Sets the operating mode.
    SetOpmodeRequest(u32),
    /// The operating mode in force.
    SetOpmodeConfirm(ModeConfirm),
    /// Sets the sleep mode.
    SetSleepmodeRequest(u32),
    /// The sleep mode in force.
    SetSleepmodeConfirm(ModeConfirm),
    /// Samples of a scan.
    ScanInfo(Box<ScanMessage>),
}

/// Reason why bytes are no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// Fewer bytes than a type and an id.
    #[error("expected a message of 4 bytes at least, found {found}")]
    Short {
        /// Bytes there.
        found: usize,
    },
    /// A type that the protocol does not have.
    #[error("expected a message type of the MRM interface, found {code:#06x}")]
    UnknownType {
        /// The type found.
        code: u16,
    },
    /// Another length than the type has.
    #[error("{}: expected {} bytes, found {found}", kind.name(), kind.bytes())]
    Length {
        /// The type.
        kind: MessageType,
        /// Bytes there.
        found: usize,
    },
    /// A SCAN_INFO header that contradicts itself.
    #[error("SCAN_INFO: {0}")]
    Scan(HeaderFault),
}

impl Message {
    /// The message's type.
    #[must_use]
    pub fn kind(&self) -> MessageType {
        match self {
            Self::SetConfigRequest(_) => MessageType::SetConfigRequest,
            Self::SetConfigConfirm(_) => MessageType::SetConfigConfirm,
            Self::GetConfigRequest => MessageType::GetConfigRequest,
            Self::GetConfigConfirm(_) => MessageType::GetConfigConfirm,
            Self::ControlRequest(_) => MessageType::ControlRequest,
            Self::ControlConfirm(_) => MessageType::ControlConfirm,
            Self::SetFilterConfigRequest(_) => MessageType::SetFilterConfigRequest,
            Self::SetFilterConfigConfirm(_) => MessageType::SetFilterConfigConfirm,
            Self::GetFilterConfigRequest => MessageType::GetFilterConfigRequest,
            Self::GetFilterConfigConfirm(_) => MessageType::GetFilterConfigConfirm,
            Self::DetectionListInfo(_) => MessageType::DetectionListInfo,
            Self::GetStatusInfoRequest => MessageType::GetStatusInfoRequest,
            Self::GetStatusInfoConfirm(_) => MessageType::GetStatusInfoConfirm,
            Self::RebootRequest => MessageType::RebootRequest,
            Self::RebootConfirm => MessageType::RebootConfirm,
            Self::SetOpmodeRequest(_) => MessageType::SetOpmodeRequest,
            Self::SetOpmodeConfirm(_) => MessageType::SetOpmodeConfirm,
            Self::SetSleepmodeRequest(_) => MessageType::SetSleepmodeRequest,
            Self::SetSleepmodeConfirm(_) => MessageType::SetSleepmodeConfirm,
            Self::ScanInfo(_) => MessageType::ScanInfo,
        }
    }
}

impl Packet {
    /// Decodes one whole message without a prefix.
    ///
    /// # Errors
    /// Bytes of another kind or length; a SCAN_INFO header that contradicts itself.
    ///
    /// ```
    /// use acerra_record::message::{Message, Packet};
    /// let reboot = Packet::decode(&[0xF0, 0x02, 0x00, 0x07])?;
    /// assert_eq!(reboot, Packet { id: 7, message: Message::RebootRequest });
    /// # Ok::<(), acerra_record::message::DecodeError>(())
    /// ```
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let found = bytes.len();
        let Some((head, body)) = bytes.split_first_chunk::<4>() else {
            return Err(DecodeError::Short { found });
        };
        let code = u16::from_be_bytes([head[0], head[1]]);
        let kind = MessageType::from_code(code).ok_or(DecodeError::UnknownType { code })?;
        if found != kind.bytes() {
            return Err(DecodeError::Length { kind, found });
        }
        let message = decode_fields(kind, bytes, &mut Fields::new(body))?;
        let id = u16::from_be_bytes([head[2], head[3]]);
        Ok(Self { id, message })
    }

    /// Encodes the message without a prefix.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let kind = self.message.kind();
        let mut out = Vec::with_capacity(kind.bytes());
        if let Message::ScanInfo(scan) = &self.message {
            scan.encode(self.id, &mut out);
            return out;
        }
        out.extend_from_slice(&kind.code().to_be_bytes());
        out.extend_from_slice(&self.id.to_be_bytes());
        encode_body(&self.message, &mut out);
        out
    }
}

/// Fields of a message whose length is right; `fields` begin behind type and id.
fn decode_fields(
    kind: MessageType,
    bytes: &[u8],
    fields: &mut Fields<'_>,
) -> Result<Message, DecodeError> {
    let status = |fields: &mut Fields<'_>| StatusCode::from_code(fields.u32());
    Ok(match kind {
        MessageType::SetConfigRequest => {
            Message::SetConfigRequest(configuration::decode_config(fields))
        }
        MessageType::SetConfigConfirm => Message::SetConfigConfirm(status(fields)),
        MessageType::GetConfigRequest => Message::GetConfigRequest,
        MessageType::GetConfigConfirm => Message::GetConfigConfirm(ConfigConfirm::decode(fields)),
        MessageType::ControlRequest => Message::ControlRequest(ControlRequest::decode(fields)),
        MessageType::ControlConfirm => Message::ControlConfirm(status(fields)),
        MessageType::SetFilterConfigRequest => {
            Message::SetFilterConfigRequest(FilterConfig::decode(fields))
        }
        MessageType::SetFilterConfigConfirm => Message::SetFilterConfigConfirm(status(fields)),
        MessageType::GetFilterConfigRequest => Message::GetFilterConfigRequest,
        MessageType::GetFilterConfigConfirm => {
            Message::GetFilterConfigConfirm(FilterConfirm::decode(fields))
        }
        MessageType::GetStatusInfoRequest => Message::GetStatusInfoRequest,
        MessageType::RebootRequest => Message::RebootRequest,
        MessageType::RebootConfirm => Message::RebootConfirm,
        MessageType::SetOpmodeRequest => Message::SetOpmodeRequest(fields.u32()),
        MessageType::SetOpmodeConfirm => Message::SetOpmodeConfirm(ModeConfirm::decode(fields)),
        MessageType::SetSleepmodeRequest => Message::SetSleepmodeRequest(fields.u32()),
        MessageType::SetSleepmodeConfirm => {
            Message::SetSleepmodeConfirm(ModeConfirm::decode(fields))
        }
        MessageType::DetectionListInfo => {
            Message::DetectionListInfo(Box::new(DetectionList::decode(fields)))
        }
        MessageType::GetStatusInfoConfirm => {
            Message::GetStatusInfoConfirm(Box::new(StatusInfo::decode(fields)))
        }
        MessageType::ScanInfo => {
            let scan = ScanMessage::decode(bytes).map_err(DecodeError::Scan)?;
            Message::ScanInfo(Box::new(scan))
        }
    })
}

fn encode_body(message: &Message, out: &mut Vec<u8>) {
    match message {
        Message::SetConfigRequest(config) => out.extend_from_slice(&config.to_bytes()),
        Message::SetConfigConfirm(status)
        | Message::ControlConfirm(status)
        | Message::SetFilterConfigConfirm(status) => {
            out.extend_from_slice(&status.code().to_be_bytes());
        }
        Message::GetConfigConfirm(confirm) => confirm.encode(out),
        Message::ControlRequest(request) => request.encode(out),
        Message::SetFilterConfigRequest(filter) => filter.encode(out),
        Message::GetFilterConfigConfirm(confirm) => confirm.encode(out),
        Message::DetectionListInfo(list) => list.encode(out),
        Message::GetStatusInfoConfirm(info) => info.encode(out),
        Message::SetOpmodeRequest(mode) | Message::SetSleepmodeRequest(mode) => {
            out.extend_from_slice(&mode.to_be_bytes());
        }
        Message::SetOpmodeConfirm(confirm) | Message::SetSleepmodeConfirm(confirm) => {
            confirm.encode(out);
        }
        Message::GetConfigRequest
        | Message::GetFilterConfigRequest
        | Message::GetStatusInfoRequest
        | Message::RebootRequest
        | Message::RebootConfirm
        | Message::ScanInfo(_) => {}
    }
}
