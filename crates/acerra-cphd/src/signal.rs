//! The signals of a channel, and how they become spectra.

use std::f64::consts::TAU;
use std::io::{Read, Seek, SeekFrom};

use num_complex::Complex64;

use crate::band::CommonBand;
use crate::error::ReadError;
use crate::header::Block;
use crate::layout::{ChannelLayout, Layout, SampleFormat};
use crate::pulse::Pulse;

/// The signals of a channel.
pub(crate) struct Signals<'a> {
    channel: &'a ChannelLayout,
    block: Block,
    format: SampleFormat,
    is_conjugate: bool,
}

impl<'a> Signals<'a> {
    /// The signals of `channel` within the file's block of signals.
    ///
    /// # Errors
    /// A block that is too short.
    pub fn of(
        layout: &Layout,
        channel: &'a ChannelLayout,
        signals: Block,
    ) -> Result<Self, ReadError> {
        let samples = channel.vectors.checked_mul(channel.samples);
        let size = samples.and_then(|n| n.checked_mul(layout.format.bytes()));
        let what = format!("signal of channel {:?} in its block", channel.name);
        Ok(Self {
            channel,
            block: signals.part(&what, channel.signal_offset, size)?,
            format: layout.format,
            is_conjugate: layout.is_conjugate,
        })
    }

    /// Appends the spectrum of a pulse, relative to the antenna, to `spectrum`.
    ///
    /// # Errors
    /// A sample that is no number, a file that cannot be read.
    pub fn read(
        &self,
        reader: &mut (impl Read + Seek),
        pulse: &Pulse,
        band: &CommonBand,
        spectrum: &mut Vec<Complex64>,
    ) -> Result<(), ReadError> {
        let sample = self.format.bytes();
        let skipped = pulse.number as u64 * self.channel.samples + band.first as u64;
        reader.seek(SeekFrom::Start(self.block.offset + skipped * sample))?;
        let mut bytes = vec![0; band.frequency.count * sample as usize];
        reader.read_exact(&mut bytes)?;
        for (n, value) in bytes.chunks(sample as usize).enumerate() {
            let signal = pulse.amplitude * self.value(value);
            if !(signal.re.is_finite() && signal.im.is_finite()) {
                return Err(ReadError::Sample {
                    channel: self.channel.name.clone(),
                    vector: pulse.number,
                    sample: band.first + n,
                });
            }
            let signal = if self.is_conjugate {
                signal.conj()
            } else {
                signal
            };
            let cycles = band.frequency.hz(n) * pulse.srp_delay_s;
            spectrum.push(signal * Complex64::cis(-TAU * cycles));
        }
        Ok(())
    }

    fn value(&self, bytes: &[u8]) -> Complex64 {
        match (self.format, bytes) {
            (SampleFormat::Ci2, [re, im]) => {
                Complex64::new(f64::from(*re as i8), f64::from(*im as i8))
            }
            (SampleFormat::Ci4, [a, b, c, d]) => {
                let half = |bytes| f64::from(i16::from_be_bytes(bytes));
                Complex64::new(half([*a, *b]), half([*c, *d]))
            }
            (SampleFormat::Cf8, [a, b, c, d, e, f, g, h]) => {
                let half = |bytes| f64::from(f32::from_be_bytes(bytes));
                Complex64::new(half([*a, *b, *c, *d]), half([*e, *f, *g, *h]))
            }
            _ => Complex64::new(f64::NAN, f64::NAN),
        }
    }
}
