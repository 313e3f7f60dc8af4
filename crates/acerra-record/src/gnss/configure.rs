//! Configuring u-blox receivers for raw measurements, each message acknowledged.
//!
//! UBX-CFG-MSG and UBX-CFG-RATE as in the u-blox 6 and M8 receiver descriptions; UBX-CFG-VALSET with
//! the key ids of the ZED-F9P interface description (HPG 1.30).

use std::time::{Duration, Instant};

use acerra_gnss::ubx::frame::{self, Piece, pieces};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::source::{ByteSource, SourceFault};

const CFG: u8 = 0x06;
const CFG_MSG: u8 = 0x01;
const CFG_RATE: u8 = 0x08;
const CFG_VALSET: u8 = 0x8A;
const ACK: u8 = 0x05;

const NAV: u8 = 0x01;
const RXM: u8 = 0x02;
const TIM: u8 = 0x0D;

/// Time waited for an acknowledgement; a receiver that is busy takes up to a second.
const ACK_WAIT: Duration = Duration::from_millis(1_500);
const ATTEMPTS: usize = 3;

/// Kind of receiver.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
pub enum Receiver {
    /// Already sends the required messages, or is not a u-blox receiver.
    #[default]
    #[serde(rename = "as-is")]
    AsIs,
    /// u-blox LEA-6T: RXM-RAW and RXM-SFRB.
    #[serde(rename = "lea-6t")]
    Lea6t,
    /// u-blox M8T or M8P: RXM-RAWX and RXM-SFRBX.
    #[serde(rename = "m8t")]
    M8t,
    /// u-blox F9P: RXM-RAWX and RXM-SFRBX by the configuration interface.
    #[serde(rename = "f9p")]
    F9p,
}

/// Reason why a receiver is not configured.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigureError {
    /// The connection ended.
    #[error(transparent)]
    Source(#[from] SourceFault),
    /// The receiver refuses.
    #[error(
        "the GNSS receiver refuses {name} (UBX-ACK-NAK); is it the kind that [gnss] receiver says?"
    )]
    Refused {
        /// What was to be set.
        name: &'static str,
    },
    /// No acknowledgement.
    #[error(
        "no acknowledgement of {name} from the GNSS receiver; is its UBX input on, and the rate right?"
    )]
    Silent {
        /// What was to be set.
        name: &'static str,
    },
}

/// One setting: a whole UBX frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// What it sets.
    pub name: &'static str,
    /// The frame.
    pub frame: Vec<u8>,
}

fn setting(name: &'static str, id: u8, payload: &[u8]) -> Option<Setting> {
    let frame = frame::encode(CFG, id, payload)?;
    Some(Setting { name, frame })
}

/// Rate of the receiver's own solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solutions {
    /// Once a second: enough to watch the fix.
    #[default]
    EachSecond,
    /// With each measurement, as finely as the receiver can: positions to image with.
    EachMeasurement,
}

/// Frames that make a receiver send raw measurements, navigation subframes and time marks, and its own
/// solution, where the receiver has a solution message with fix type (NAV-PVT; NAV-HPPOSLLH of an F9P with
/// each measurement); in the order in which they are sent. The settings last until the receiver loses its
/// power.
#[must_use]
pub fn configuration(receiver: Receiver, rate_hz: f64, solutions: Solutions) -> Vec<Setting> {
    let period_ms = (1000.0 / rate_hz.clamp(0.1, 50.0)).round() as u16;
    let message = |name, class, id| setting(name, CFG_MSG, &[class, id, 1]);
    let is_each = solutions == Solutions::EachMeasurement;
    let epochs = if is_each {
        1
    } else {
        (rate_hz.round() as u8).max(1)
    };
    // Measurement period, one solution a measurement, GPS time.
    let mut rate = period_ms.to_le_bytes().to_vec();
    rate.extend_from_slice(&[1, 0, 1, 0]);
    let settings = match receiver {
        Receiver::AsIs => vec![],
        Receiver::Lea6t => vec![
            setting("the measurement rate (CFG-RATE)", CFG_RATE, &rate),
            message("RXM-RAW (CFG-MSG)", RXM, 0x10),
            message("RXM-SFRB (CFG-MSG)", RXM, 0x11),
            message("TIM-TM2 (CFG-MSG)", TIM, 0x03),
        ],
        Receiver::M8t => vec![
            setting("the measurement rate (CFG-RATE)", CFG_RATE, &rate),
            message("RXM-RAWX (CFG-MSG)", RXM, 0x15),
            message("RXM-SFRBX (CFG-MSG)", RXM, 0x13),
            message("TIM-TM2 (CFG-MSG)", TIM, 0x03),
            setting("NAV-PVT (CFG-MSG)", CFG_MSG, &[NAV, 0x07, epochs]),
        ],
        Receiver::F9p => vec![
            valset(
                "the measurement rate (CFG-RATE-MEAS)",
                &[(0x3021_0001, &period_ms.to_le_bytes())],
            ),
            // The port in use is not known: USB and both UARTs.
            valset("RXM-RAWX", &on_every_port(0x2091_02A4, &[1])),
            valset("RXM-SFRBX", &on_every_port(0x2091_0231, &[1])),
            valset("TIM-TM2", &on_every_port(0x2091_0178, &[1])),
            valset("NAV-PVT", &on_every_port(0x2091_0006, &[epochs])),
            is_each
                .then(|| valset("NAV-HPPOSLLH", &on_every_port(0x2091_0033, &[1])))
                .flatten(),
        ],
    };
    settings.into_iter().flatten().collect()
}

/// Keys of a message's rate on I2C, UART 1, UART 2, USB and SPI follow each other; returns the keys of UART 1,
/// UART 2 and USB, each with the number of epochs from one message to the next.
fn on_every_port(i2c_key: u32, epochs: &[u8; 1]) -> [(u32, &[u8]); 3] {
    [1, 2, 3].map(|port| (i2c_key + port, epochs as &[u8]))
}

/// UBX-CFG-VALSET, version 0, into the receiver's memory that is in force.
fn valset(name: &'static str, values: &[(u32, &[u8])]) -> Option<Setting> {
    const LAYER_RAM: u8 = 1;
    let mut payload = vec![0, LAYER_RAM, 0, 0];
    for (key, value) in values {
        payload.extend_from_slice(&key.to_le_bytes());
        payload.extend_from_slice(value);
    }
    setting(name, CFG_VALSET, &payload)
}

/// Sends settings and waits for each to be acknowledged. Every byte that comes meanwhile is handed to
/// `keep`, acknowledgements included.
///
/// # Errors
/// A connection that ends, a refusal, silence.
pub fn configure(
    source: &mut dyn ByteSource,
    settings: &[Setting],
    keep: &mut dyn FnMut(&[u8]),
) -> Result<(), ConfigureError> {
    let mut heard = Vec::new();
    settings
        .iter()
        .try_for_each(|setting| configure_one(source, setting, &mut heard, keep))
}

fn configure_one(
    source: &mut dyn ByteSource,
    setting: &Setting,
    heard: &mut Vec<u8>,
    keep: &mut dyn FnMut(&[u8]),
) -> Result<(), ConfigureError> {
    let name = setting.name;
    let mut buffer = [0; 4096];
    for _ in 0..ATTEMPTS {
        source.write(&setting.frame)?;
        let until = Instant::now() + ACK_WAIT;
        while Instant::now() < until {
            let bytes = source.read(&mut buffer)?;
            keep(&buffer[..bytes]);
            heard.extend_from_slice(&buffer[..bytes]);
            match take_answer(heard, setting) {
                Some(true) => return Ok(()),
                Some(false) => return Err(ConfigureError::Refused { name }),
                None => {}
            }
        }
    }
    Err(ConfigureError::Silent { name })
}

/// Whether the setting was acknowledged or refused, by the first such answer among the received bytes;
/// processed bytes are dropped.
fn take_answer(heard: &mut Vec<u8>, setting: &Setting) -> Option<bool> {
    let mut answer = None;
    let mut through = 0;
    for piece in pieces(heard) {
        match piece {
            Piece::Frame(frame) => {
                through = frame.offset + frame.payload.len() + 8;
                let of_this = setting.frame.get(2..4) == Some(frame.payload);
                if frame.class == ACK && of_this {
                    answer = Some(frame.id == 1);
                    break;
                }
            }
            Piece::Outside { offset, bytes } => through = offset + bytes,
            Piece::BadChecksum { .. } | Piece::CutOff { .. } => {}
        }
    }
    heard.drain(..through.min(heard.len()));
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames as the receiver descriptions have them.
    #[test]
    fn frames_stand_byte_by_byte() {
        let m8t = configuration(Receiver::M8t, 5.0, Solutions::EachSecond);
        let rate = [
            0xB5, 0x62, 0x06, 0x08, 6, 0, 0xC8, 0, 1, 0, 1, 0, 0xDE, 0x6A,
        ];
        assert_eq!(m8t[0].frame, rate);
        let rawx = [0xB5, 0x62, 0x06, 0x01, 3, 0, 0x02, 0x15, 1, 0x22, 0x70];
        assert_eq!(m8t[1].frame, rawx);
        let lea = configuration(Receiver::Lea6t, 5.0, Solutions::EachSecond);
        assert_eq!(lea[1].frame[6..9], [0x02, 0x10, 1]);
        let f9p = configuration(Receiver::F9p, 10.0, Solutions::EachSecond);
        let period = [0, 1, 0, 0, 0x01, 0x00, 0x21, 0x30, 100, 0];
        assert_eq!(f9p[0].frame[6..16], period);
        // CFG-MSGOUT-UBX_RXM_RAWX_UART1 is 0x209102a5.
        assert_eq!(f9p[1].frame[10..15], [0xA5, 0x02, 0x91, 0x20, 1]);
        // CFG-MSGOUT-UBX_NAV_PVT_UART1 is 0x20910007; once in ten epochs.
        assert_eq!(f9p[4].frame[10..15], [0x07, 0x00, 0x91, 0x20, 10]);
        assert_eq!(m8t[4].frame[6..9], [0x01, 0x07, 5]);
        assert_eq!(f9p.len(), 5);
        let live = configuration(Receiver::F9p, 10.0, Solutions::EachMeasurement);
        assert_eq!(live[4].frame[14], 1);
        // CFG-MSGOUT-UBX_NAV_HPPOSLLH_UART1 is 0x20910034.
        assert_eq!(live[5].frame[10..15], [0x34, 0x00, 0x91, 0x20, 1]);
        let live = configuration(Receiver::M8t, 5.0, Solutions::EachMeasurement);
        assert_eq!(live[4].frame[6..9], [0x01, 0x07, 1]);
        assert!(configuration(Receiver::AsIs, 5.0, Solutions::EachSecond).is_empty());
    }

    /// A receiver that answers after other bytes.
    struct Answering {
        answers: Vec<Vec<u8>>,
        written: usize,
    }

    impl ByteSource for Answering {
        fn read(&mut self, buffer: &mut [u8]) -> Result<usize, SourceFault> {
            let bytes = self.answers.pop().unwrap_or_default();
            buffer[..bytes.len()].copy_from_slice(&bytes);
            Ok(bytes.len())
        }

        fn write(&mut self, _: &[u8]) -> Result<(), SourceFault> {
            self.written += 1;
            Ok(())
        }

        fn reopen(&mut self) -> Result<(), SourceFault> {
            Ok(())
        }
    }

    #[test]
    fn acknowledgement_and_refusal_are_told_apart_and_every_byte_is_kept() {
        let settings = &configuration(Receiver::M8t, 1.0, Solutions::EachSecond)[1..2];
        let ack = frame::encode(ACK, 1, &[CFG, CFG_MSG]).unwrap();
        let nak = frame::encode(ACK, 0, &[CFG, CFG_MSG]).unwrap();
        let of_another = frame::encode(ACK, 1, &[CFG, CFG_RATE]).unwrap();
        let noise = b"$GNGGA,,*00\r\n".to_vec();
        let run = |last: &[u8]| {
            let (first_half, second_half) = last.split_at(5);
            let mut answers = vec![noise.clone(), of_another.clone()];
            answers.extend([first_half.to_vec(), second_half.to_vec()]);
            answers.reverse();
            let expected: Vec<u8> = answers.iter().rev().flatten().copied().collect();
            let mut source = Answering {
                answers,
                written: 0,
            };
            let mut kept = Vec::new();
            let result = configure(&mut source, settings, &mut |b| kept.extend_from_slice(b));
            assert_eq!(kept, expected);
            assert_eq!(source.written, 1);
            result
        };
        assert!(run(&ack).is_ok());
        assert!(
            matches!(run(&nak), Err(ConfigureError::Refused { name }) if name == "RXM-RAWX (CFG-MSG)")
        );
    }
}
