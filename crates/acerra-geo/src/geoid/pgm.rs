//! GeographicLib's `.pgm` grids.

use super::GeoidError;
use super::grid::{GeoidGrid, Layout, northwards};

pub(super) fn read(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let wrong = |expected: &str, found: String| GeoidError::Format {
        format: ".pgm",
        expected: expected.to_owned(),
        found,
    };
    let (mut offset, mut scale) = (None, None);
    let mut numbers = Vec::new();
    let mut at = 2;
    // Width, height and greatest value, among comments; one blank ends the header.
    while numbers.len() < 3 {
        match bytes.get(at) {
            Some(b'#') => {
                let end = bytes[at..].iter().position(|&b| b == b'\n').unwrap_or(0);
                let comment = String::from_utf8_lossy(&bytes[at..at + end]).into_owned();
                let mut words = comment.trim_start_matches('#').split_whitespace();
                let (key, value) = (words.next(), words.next().and_then(|v| v.parse().ok()));
                match key {
                    Some("Offset") => offset = value,
                    Some("Scale") => scale = value,
                    _ => {}
                }
                at += end.max(1);
            }
            Some(b) if b.is_ascii_whitespace() => at += 1,
            Some(b'0'..=b'9') => {
                let digits = bytes[at..]
                    .iter()
                    .take_while(|b| b.is_ascii_digit())
                    .count();
                let text = String::from_utf8_lossy(&bytes[at..at + digits]).into_owned();
                let number = text.parse::<usize>();
                numbers.push(number.map_err(|_| wrong("a width, height or depth", text))?);
                at += digits;
            }
            Some(&other) => return Err(wrong("a number", format!("{:?}", char::from(other)))),
            None => return Err(wrong("width, height and depth", "the end".to_owned())),
        }
    }
    let (columns, rows) = (numbers[0], numbers[1]);
    let (offset, scale): (f64, f64) = offset
        .zip(scale)
        .ok_or_else(|| wrong("# Offset and # Scale", "neither or one".to_owned()))?;
    let pixels = bytes.get(at + 1..).unwrap_or(&[]);
    let needed = rows.checked_mul(columns).and_then(|n| n.checked_mul(2));
    if needed != Some(pixels.len()) || numbers[2] != 65_535 || rows < 3 || columns < 2 {
        let expected = format!("{columns} × {rows} values of 16 bits");
        return Err(wrong(&expected, format!("{} bytes", pixels.len())));
    }
    let heights: Vec<f32> = pixels
        .chunks_exact(2)
        .map(|b| (offset + scale * f64::from(u16::from_be_bytes([b[0], b[1]]))) as f32)
        .collect();
    let layout = Layout {
        south: -90.0,
        west: 0.0,
        steps: [180.0 / (rows - 1) as f64, 360.0 / columns as f64],
        rows,
        columns,
    };
    GeoidGrid::new(&layout, northwards(&heights, columns), ".pgm")
}
