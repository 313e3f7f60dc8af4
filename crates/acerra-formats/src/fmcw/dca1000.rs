//! Raw samples of a DCA1000: integers of 16 bits without any header.

use std::io::Read;

use num_complex::Complex64;

use super::deramp::{Chirp, deramp};
use super::npz::describe;
use super::settings::{FmcwSettings, Layout};
use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::traces::records;

/// Reads `length_bytes` of raw samples by their settings. Receivers become channels, chirps traces.
///
/// # Errors
/// Samples that make no whole chirp, more than `limits` admit.
pub fn read_dca1000(
    mut reader: impl Read,
    length_bytes: u64,
    settings: &FmcwSettings,
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let (samples, receivers) = (settings.samples, settings.receivers);
    limits.check_trace(Place::field("[fmcw] samples"), samples as u64)?;
    let words = samples * receivers * if settings.complex { 2 } else { 1 };
    let mut beats: Vec<Vec<Complex64>> = vec![Vec::new(); receivers];
    let mut peak = 0i16;
    let (chirps, left) = records(
        &mut reader,
        length_bytes,
        [2 * words, samples * receivers],
        limits,
        |_, bytes| {
            let word = |i: usize| i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]);
            for (r, beat) in beats.iter_mut().enumerate() {
                beat.extend((0..samples).map(|k| {
                    let [re, im] = place(settings, r, k);
                    let at = |i: usize| {
                        let value = word(i);
                        peak = peak.max(value.saturating_abs());
                        f64::from(value)
                    };
                    let mut at = at;
                    let re = at(re);
                    Complex64::new(re, if settings.complex { at(im) } else { 0.0 })
                }));
            }
            Ok(())
        },
    )?;
    if chirps == 0 {
        return Err(FormatError::content(
            Place::Byte(0),
            format!("a chirp of {} bytes", 2 * words),
            format!("the end of the file after {left}"),
        ));
    }
    let chirp = Chirp {
        start_frequency_hz: settings.start_frequency_hz,
        slope_hz_per_s: settings.slope_hz_per_s,
        sample_rate_hz: settings.sample_rate_hz,
        is_conjugate: settings.conjugate,
    };
    let mut recording = Recording::new(Format::Fmcw);
    recording.skipped_bytes = left;
    describe(&mut recording, &chirp, samples);
    if peak == i16::MAX {
        recording
            .remarks
            .push("samples reach the limit of 16 bits".to_owned());
    }
    let active_s = samples as f64 / settings.sample_rate_hz;
    if active_s > settings.chirp_interval_s {
        recording.compare(
            "duration of a chirp: chirp_interval_s, samples / sample_rate_hz",
            [settings.chirp_interval_s, active_s],
            "s",
            0.0,
        );
    }
    let time_s: Vec<f64> = (0..chirps)
        .map(
            |i| match (settings.chirps_per_frame, settings.frame_interval_s) {
                (Some(n), Some(frame_s)) => {
                    (i / n) as f64 * frame_s + (i % n) as f64 * settings.chirp_interval_s
                }
                _ => i as f64 * settings.chirp_interval_s,
            },
        )
        .collect();
    for (r, beat) in beats.into_iter().enumerate() {
        let spectra = deramp(&beat, samples, &chirp);
        let axis = Axis::Frequency(chirp.frequency_hz(samples));
        let name = (r + 1).to_string();
        let mut channel = Channel::new(name, chirps, axis, Values::Complex(spectra));
        channel.time_s = Some(time_s.clone());
        recording.channels.push(channel);
    }
    recording.checked()
}

/// Words of the real and imaginary part of sample `k` of receiver `r` in a chirp.
fn place(s: &FmcwSettings, r: usize, k: usize) -> [usize; 2] {
    if !s.complex {
        let at = match s.layout {
            Layout::Interleaved => k * s.receivers + r,
            Layout::Paired => r * s.samples + k,
        };
        return [at, at];
    }
    match s.layout {
        Layout::Interleaved => {
            let at = 2 * s.receivers * k + r;
            [at, at + s.receivers]
        }
        Layout::Paired => {
            let at = 2 * r * s.samples + 4 * (k / 2) + k % 2;
            [at, at + 2]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(more: &str) -> FmcwSettings {
        let text = format!(
            "[fmcw]\nfile = \"adc.bin\"\nstart_frequency_hz = 77e9\nslope_hz_per_s = 60e12\n\
             sample_rate_hz = 10e6\nsamples = 4\nreceivers = 2\nchirp_interval_s = 1e-4\n{more}"
        );
        FmcwSettings::parse(&text).unwrap()
    }

    #[test]
    fn layouts_are_those_of_swra581() {
        let paired = settings("");
        // Receiver 1 after receiver 0; I0 I1 Q0 Q1 I2 I3 Q2 Q3.
        assert_eq!(place(&paired, 0, 0), [0, 2]);
        assert_eq!(place(&paired, 0, 1), [1, 3]);
        assert_eq!(place(&paired, 0, 2), [4, 6]);
        assert_eq!(place(&paired, 1, 3), [13, 15]);
        let interleaved = settings("layout = \"interleaved\"");
        assert_eq!(place(&interleaved, 1, 0), [1, 3]);
        assert_eq!(place(&interleaved, 0, 1), [4, 6]);
        let real = settings("complex = false");
        assert_eq!(place(&real, 1, 2), [6, 6]);
    }

    #[test]
    fn chirps_of_frames_have_times() {
        let s = settings("chirps_per_frame = 2\nframe_interval_s = 0.05");
        let bytes = vec![1u8; 2 * 16 * 3 + 5];
        let read = read_dca1000(bytes.as_slice(), 101, &s, &Limits::default()).unwrap();
        assert_eq!(read.channels.len(), 2);
        assert_eq!(read.skipped_bytes, 5);
        assert_eq!(read.channels[1].time_s, Some(vec![0.0, 1e-4, 0.05]));
    }
}
