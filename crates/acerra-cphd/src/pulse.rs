//! The parameters of a vector that the reader uses.

use std::io::{Read, Seek, SeekFrom};

use crate::error::ReadError;
use crate::geometry::{minus, norm};
use crate::header::Block;
use crate::layout::{ChannelLayout, Parameters, is_on_earth};
use crate::model::SPEED_OF_LIGHT_M_S;

/// Largest difference of the two-way path by transmitter and receiver from that by an antenna between them
/// (wavelengths).
const MAX_SEPARATION: f64 = 1.0 / 32.0;
/// Distance from the centre of the Earth below which there is no antenna (m).
const INSIDE_EARTH_M: f64 = 6.2e6;
/// Value of the parameter SIGNAL of vectors that hold echoes.
const NORMAL_SIGNAL: i64 = 1;

/// Used parameters of a vector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pulse {
    pub number: usize,
    pub is_normal: bool,
    /// Middle of transmit and receive time (s).
    pub time_s: f64,
    /// Middle of the places of transmission and reception, Earth-centred, Earth-fixed (m).
    pub place_m: [f64; 3],
    /// Two-way delay of the reference point's echo (s).
    pub srp_delay_s: f64,
    pub amplitude: f64,
    pub band_hz: [f64; 2],
    pub swath_s: [f64; 2],
    pub first_hz: f64,
    pub step_hz: f64,
}

/// Reads the parameters of a channel's vectors from their block.
///
/// # Errors
/// A block that is too short; vectors with a signal whose parameters cannot be, or whose times do not
/// rise; no such vector.
pub(crate) fn read_vectors(
    reader: &mut (impl Read + Seek),
    block: Block,
    channel: &ChannelLayout,
    parameters: &Parameters,
) -> Result<Vec<Pulse>, ReadError> {
    let size = channel.vectors.checked_mul(parameters.bytes as u64);
    let what = format!("parameters of channel {:?} in their block", channel.name);
    let block = block.part(&what, channel.vector_offset, size)?;
    reader.seek(SeekFrom::Start(block.offset))?;
    let mut bytes = vec![0; parameters.bytes];
    let mut vectors: Vec<Pulse> = Vec::new();
    let mut last_s = f64::NEG_INFINITY;
    for number in 0..channel.vectors as usize {
        reader.read_exact(&mut bytes)?;
        let raw = RawPulse {
            bytes: &bytes,
            parameters,
            number,
            channel: &channel.name,
        };
        let vector = raw.checked()?;
        if vector.is_normal {
            if vector.time_s <= last_s {
                return Err(raw.wrong("TxTime", "rising times", vector.time_s));
            }
            last_s = vector.time_s;
        }
        vectors.push(vector);
    }
    if vectors.iter().any(|v| v.is_normal) {
        Ok(vectors)
    } else {
        Err(ReadError::Empty {
            channel: channel.name.clone(),
        })
    }
}

/// A vector's parameters as bytes.
struct RawPulse<'a> {
    bytes: &'a [u8],
    parameters: &'a Parameters,
    number: usize,
    channel: &'a str,
}

impl RawPulse<'_> {
    fn checked(&self) -> Result<Pulse, ReadError> {
        let at = self.parameters;
        let transmit_m = self.place(at.transmit_place);
        let receive_m = self.place(at.receive_place);
        let srp_m = self.place(at.reference_point);
        let place_m: [f64; 3] = std::array::from_fn(|i| 0.5 * (transmit_m[i] + receive_m[i]));
        let range_m = norm(minus(place_m, srp_m));
        let vector = Pulse {
            number: self.number,
            is_normal: at.signal.is_none_or(|at| self.integer(at) == NORMAL_SIGNAL),
            // Additional delay of the reference point's echo.
            time_s: self.number(at.transmit_time) + range_m / SPEED_OF_LIGHT_M_S,
            place_m,
            srp_delay_s: 2.0 * range_m / SPEED_OF_LIGHT_M_S,
            amplitude: at.amplitude.map_or(1.0, |at| self.number(at)),
            band_hz: at.band.map(|at| self.number(at)),
            swath_s: at.swath.map(|at| self.number(at)),
            first_hz: self.number(at.first_sample),
            step_hz: self.number(at.sample_step),
        };
        if !vector.is_normal {
            return Ok(vector);
        }
        for (parameter, place) in [("TxPos", transmit_m), ("RcvPos", receive_m)] {
            if !place.iter().all(|v| v.is_finite()) || norm(place) < INSIDE_EARTH_M {
                return Err(self.wrong(parameter, "a place on or above the Earth", place));
            }
        }
        if !is_on_earth(srp_m) {
            return Err(self.wrong("SRPPos", "a place on the Earth", srp_m));
        }
        let positive = |v: f64| v.is_finite() && v > 0.0;
        for (parameter, value) in [
            ("SC0", vector.first_hz),
            ("SCSS", vector.step_hz),
            ("AmpSF", vector.amplitude),
        ] {
            if !positive(value) {
                return Err(self.wrong(parameter, "a positive number", value));
            }
        }
        if !vector.time_s.is_finite() {
            return Err(self.wrong("TxTime", "a finite time", vector.time_s));
        }
        let apart_m = norm(minus(transmit_m, receive_m));
        let excess_m = apart_m * apart_m / (4.0 * range_m);
        let wavelength_m = SPEED_OF_LIGHT_M_S / vector.first_hz;
        if excess_m > MAX_SEPARATION * wavelength_m {
            let expected =
                "the place of transmission, within the tolerance of one antenna between them";
            return Err(self.wrong("RcvPos", expected, format!("{apart_m:.3} m from it")));
        }
        Ok(vector)
    }

    fn number(&self, at: usize) -> f64 {
        f64::from_be_bytes(self.word(at))
    }

    fn integer(&self, at: usize) -> i64 {
        i64::from_be_bytes(self.word(at))
    }

    fn place(&self, at: usize) -> [f64; 3] {
        std::array::from_fn(|i| self.number(at + 8 * i))
    }

    /// Eight bytes; the layout has made sure that they are there.
    fn word(&self, at: usize) -> [u8; 8] {
        std::array::from_fn(|i| self.bytes.get(at + i).copied().unwrap_or_default())
    }

    fn wrong(
        &self,
        parameter: &'static str,
        expected: &'static str,
        found: impl std::fmt::Debug,
    ) -> ReadError {
        ReadError::Parameter {
            channel: self.channel.to_owned(),
            vector: self.number,
            parameter,
            expected,
            found: format!("{found:?}"),
        }
    }
}
