//! Writing CPHD 1.1.0: header, XML, per-vector parameters, signals.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::io::{self, Write};

use acerra_geo::geodesy::{EnuFrame, geodetic_from_ecef};
use acerra_geo::time::GpsTime;
use num_complex::Complex64;

use crate::document::{CLASSIFICATION, Document, RELEASE};
use crate::error::WriteError;
use crate::model::{Channel, PhaseHistory, Scene};
use crate::vectors::{Vectors, WORDS};

/// Ends the header, and the XML block.
pub(crate) const SECTION_END: &[u8] = b"\x0c\n";
/// Blocks of numbers begin at multiples of this number of bytes.
const ALIGNMENT: usize = 8;
/// Time between the start of the collection and the first pulse at least (s), so that no transmit time
/// is negative.
const LEAD_S: f64 = 1e-3;

/// Writes spectra with positions as CPHD 1.1.0: frequency domain, samples of two single-precision
/// numbers, one channel a track. The middle of `scene` is the reference point of every pulse.
///
/// Times of known origin count from a whole second of UTC before the first pulse.
///
/// # Errors
/// Arrays that do not belong together or hold numbers that are not finite, times that do not rise, a
/// platform at rest, a scene without pixels, a file that cannot be written.
pub fn write_cphd(
    mut out: impl Write,
    history: &PhaseHistory<'_>,
    scene: &Scene,
) -> Result<(), WriteError> {
    check(history, scene)?;
    let (start, moved) = from_whole_second(history);
    let middle_m = moved.frame.ecef_from_enu(scene.middle_m);
    let image_frame = EnuFrame::new(geodetic_from_ecef(middle_m));
    let srp_m = image_frame.origin_in_ecef_m();
    let vectors = moved
        .channels
        .iter()
        .map(|channel| Vectors::of(channel, &moved.frame, srp_m))
        .collect::<Result<Vec<_>, _>>()?;
    let document = Document {
        history: &moved,
        scene,
        vectors: &vectors,
        image_frame: &image_frame,
        start,
    };
    let xml = document.text();
    let pulses: usize = vectors.iter().map(|v| v.all.len()).sum();
    let samples: usize = moved.channels.iter().map(|c| c.spectrum.len()).sum();
    let blocks = Blocks::of([xml.len(), 8 * WORDS * pulses, 8 * samples]);
    out.write_all(&blocks.header)?;
    out.write_all(xml.as_bytes())?;
    out.write_all(SECTION_END)?;
    let pad = blocks.vectors_at - (blocks.header.len() + xml.len() + SECTION_END.len());
    out.write_all(&[0; ALIGNMENT][..pad])?;
    for (channel, vectors) in moved.channels.iter().zip(&vectors) {
        write_vectors(&mut out, channel, vectors)?;
    }
    for (channel, vectors) in moved.channels.iter().zip(&vectors) {
        write_signal(&mut out, channel, vectors)?;
    }
    Ok(out.flush()?)
}

/// This history with times that count from a whole second before its first pulse.
fn from_whole_second<'a>(history: &'a PhaseHistory<'_>) -> (Option<GpsTime>, PhaseHistory<'a>) {
    let first_s = history.channels.iter().filter_map(|c| c.time_s.first());
    let first_s = first_s.copied().fold(f64::INFINITY, f64::min) - LEAD_S;
    // Second zero of the file, on the history's clock.
    let (start, zero_s) = match history.start {
        Some(start) => {
            let mut whole = GpsTime::new((start + first_s).seconds(), 0.0);
            if whole.to_utc().second == 60 {
                // The format has no name for a leap second.
                whole = GpsTime::new(whole.seconds() - 1, 0.0);
            }
            (Some(whole), whole.seconds_since(start))
        }
        None => (None, first_s.min(0.0).floor()),
    };
    let channels = history.channels.iter().map(|channel| Channel {
        name: channel.name.clone(),
        time_s: channel.time_s.iter().map(|t| t - zero_s).collect(),
        position_m: channel.position_m.clone(),
        spectrum: (&*channel.spectrum).into(),
        ..*channel
    });
    let moved = PhaseHistory {
        frame: history.frame,
        start,
        channels: channels.collect(),
        description: history.description.clone(),
    };
    (start, moved)
}

/// The header, and where the block of parameters begins.
struct Blocks {
    header: Vec<u8>,
    vectors_at: usize,
}

impl Blocks {
    /// The header of a file with blocks of these sizes: XML, parameters, signals. The header's length depends
    /// on the offsets in it.
    fn of([xml, vectors, signals]: [usize; 3]) -> Self {
        let mut header_length = 0;
        loop {
            let after_xml = header_length + xml + SECTION_END.len();
            let vectors_at = after_xml.next_multiple_of(ALIGNMENT);
            let mut header = format!(
                "CPHD/1.1.0\nXML_BLOCK_SIZE := {xml}\nXML_BLOCK_BYTE_OFFSET := {header_length}\n\
                 PVP_BLOCK_SIZE := {vectors}\nPVP_BLOCK_BYTE_OFFSET := {vectors_at}\n\
                 SIGNAL_BLOCK_SIZE := {signals}\nSIGNAL_BLOCK_BYTE_OFFSET := {}\n\
                 CLASSIFICATION := {CLASSIFICATION}\nRELEASE_INFO := {RELEASE}\n",
                vectors_at + vectors
            )
            .into_bytes();
            header.extend(SECTION_END);
            if header.len() == header_length {
                return Self { header, vectors_at };
            }
            header_length = header.len();
        }
    }
}

fn write_vectors(out: &mut impl Write, channel: &Channel<'_>, vectors: &Vectors) -> io::Result<()> {
    let band = channel.frequency;
    for vector in &vectors.all {
        let [transmit_s, receive_s] = vector.time_s;
        let [transmit_m, receive_m] = vector.position_m;
        let velocity = vector.velocity_m_s;
        let mut words: Vec<f64> = Vec::with_capacity(WORDS);
        words.push(transmit_s);
        words.extend(transmit_m.iter().chain(&velocity));
        words.push(receive_s);
        words.extend(receive_m.iter().chain(&velocity).chain(&vectors.srp_m));
        words.extend([vector.doppler, 0.0, 0.0]);
        words.extend([band.first_hz, band.last_hz()]);
        words.extend(vector.toa_s);
        words.extend([0.0, band.first_hz, band.step_hz]);
        for word in words {
            out.write_all(&word.to_be_bytes())?;
        }
        out.write_all(&1_i64.to_be_bytes())?;
    }
    Ok(())
}

fn write_signal(out: &mut impl Write, channel: &Channel<'_>, vectors: &Vectors) -> io::Result<()> {
    let band = channel.frequency;
    let mut line = Vec::with_capacity(8 * band.count);
    for (vector, spectrum) in vectors.all.iter().zip(channel.spectrum.chunks(band.count)) {
        line.clear();
        for (n, value) in spectrum.iter().enumerate() {
            let turn = Complex64::cis(TAU * band.hz(n) * vector.srp_delay_s);
            let signal = value * turn;
            line.extend((signal.re as f32).to_be_bytes());
            line.extend((signal.im as f32).to_be_bytes());
        }
        out.write_all(&line)?;
    }
    Ok(())
}

fn check(history: &PhaseHistory<'_>, scene: &Scene) -> Result<(), WriteError> {
    let Scene {
        pixel_m, nx, ny, ..
    } = *scene;
    if nx == 0 || ny == 0 || !(pixel_m > 0.0 && pixel_m.is_finite()) {
        return Err(WriteError::Scene { nx, ny, pixel_m });
    }
    if history.channels.is_empty() {
        return Err(WriteError::NoChannel);
    }
    let mut names = BTreeSet::new();
    for channel in &history.channels {
        if !names.insert(&channel.name) {
            return Err(WriteError::SameName {
                name: channel.name.clone(),
            });
        }
        check_channel(channel)?;
    }
    Ok(())
}

fn check_channel(channel: &Channel<'_>) -> Result<(), WriteError> {
    let name = || channel.name.clone();
    let pulses = channel.time_s.len();
    let count = channel.frequency.count;
    for (what, found) in [("pulses", pulses), ("frequencies", count)] {
        if found < 2 {
            let name = name();
            return Err(WriteError::TooFew { name, what, found });
        }
    }
    for (what, expected, found) in [
        ("positions", pulses, channel.position_m.len()),
        (
            "values",
            pulses.saturating_mul(count),
            channel.spectrum.len(),
        ),
    ] {
        if expected != found {
            let name = name();
            return Err(WriteError::Length {
                name,
                what,
                expected,
                found,
            });
        }
    }
    let not_finite = |what, index| WriteError::NotFinite {
        name: name(),
        what,
        index,
    };
    let place = |p: &[f64; 3]| !p.iter().all(|v| v.is_finite());
    let value = |v: &Complex64| !(v.re.is_finite() && v.im.is_finite());
    if let Some(k) = channel.time_s.iter().position(|t| !t.is_finite()) {
        return Err(not_finite("time", k));
    }
    if let Some(k) = channel.position_m.iter().position(place) {
        return Err(not_finite("position", k));
    }
    if let Some(k) = channel.spectrum.iter().position(value) {
        return Err(not_finite("value", k));
    }
    match channel.time_s.windows(2).position(|w| w[1] <= w[0]) {
        Some(before) => Err(WriteError::Time {
            name: name(),
            pulse: before + 1,
            time_s: channel.time_s[before + 1],
        }),
        None => Ok(()),
    }
}
