//! Writes a channel's samples to standard output as single precision, least significant byte first, row by row;
//! complex ones as pairs. For comparison with other programs: `samples FILE [CHANNEL]`.

use std::io::Write;
use std::path::Path;

use acerra_formats::{Limits, Values, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, rest @ ..] = arguments.as_slice() else {
        return Err("usage: samples FILE [CHANNEL]".into());
    };
    let recording = open(Path::new(file), &Limits::default())?;
    let channel = recording.channel(rest.first().map(String::as_str))?;
    let numbers: Vec<f32> = match &channel.values {
        Values::Real(v) => v.clone(),
        Values::Complex(v) => v.iter().flat_map(|z| [z.re, z.im]).collect(),
    };
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::io::stdout().write_all(&bytes)?;
    Ok(())
}
