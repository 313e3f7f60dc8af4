//! The frequencies that the pulses of a channel share.

use crate::error::ReadError;
use crate::layout::ChannelLayout;
use crate::model::EvenFrequencies;
use crate::pulse::Pulse;

/// Largest phase difference between a pulse's frequencies and the first pulse's frequencies (cycles).
const MAX_PHASE_CYCLES: f64 = 1e-3;

/// The frequencies that all pulses hold.
pub(crate) struct CommonBand {
    /// Number of the first sample taken.
    pub first: usize,
    pub frequency: EvenFrequencies,
}

impl CommonBand {
    /// The band within which every pulse of `vectors` has its samples.
    ///
    /// # Errors
    /// Pulses with different frequencies and no common band.
    pub fn of(vectors: &[Pulse], channel: &ChannelLayout) -> Result<Self, ReadError> {
        let normal = || vectors.iter().filter(|v| v.is_normal);
        let Some(model) = normal().next() else {
            return Err(ReadError::Empty {
                channel: channel.name.clone(),
            });
        };
        let wrong = |vector: &Pulse, parameter, expected, found: String| ReadError::Parameter {
            channel: channel.name.clone(),
            vector: vector.number,
            parameter,
            expected,
            found,
        };
        for vector in normal() {
            let first_hz = (vector.first_hz - model.first_hz).abs();
            let last_hz = (vector.step_hz - model.step_hz).abs() * channel.samples as f64;
            let latest_s = vector.swath_s.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
            let is_same = (first_hz + last_hz) * latest_s <= MAX_PHASE_CYCLES;
            if !is_same {
                return Err(wrong(
                    vector,
                    "SC0, SCSS",
                    "the frequencies of the first vector: resample the signals to common ones",
                    format!("{} Hz, {} Hz", vector.first_hz, vector.step_hz),
                ));
            }
        }
        // Half a step of tolerance for limits that were rounded.
        let sample = |hz: f64| (hz - model.first_hz) / model.step_hz;
        let band = normal().fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], v| {
            [low.max(v.band_hz[0]), high.min(v.band_hz[1])]
        });
        let last = channel.samples.saturating_sub(1) as f64;
        let from = (sample(band[0]) - 0.5).ceil().clamp(0.0, last);
        let to = (sample(band[1]) + 0.5).floor().clamp(0.0, last);
        // A band that is no number holds none.
        if to <= from || (to - from).is_nan() {
            return Err(wrong(
                model,
                "FX1, FX2",
                "a band of two samples or more that all vectors share",
                format!("{} Hz to {} Hz", band[0], band[1]),
            ));
        }
        let first = from as usize;
        Ok(Self {
            first,
            frequency: EvenFrequencies {
                first_hz: model.first_hz + from * model.step_hz,
                step_hz: model.step_hz,
                count: to as usize - first + 1,
            },
        })
    }
}
