//! Comment lines of an RTKLIB solution.

use super::error::quoted;
use super::lines::Line;
use super::{ReadError, ReadReport};
use crate::geodesy::{Geodetic, ecef_from_geodetic};
use crate::matrix::{Vector3, norm};

/// Format of the positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    Degrees,
    DegreesMinutesSeconds,
    Ecef,
    Baseline,
}

/// Time scale of the times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Gpst,
    Utc,
    Jst,
}

/// Splits a line at whatever separates its columns: blanks, tabs, commas, semicolons, and before a sign that follows
/// a digit, as fixed columns leave no blank before a western longitude.
pub(super) fn words(text: &str) -> Vec<&str> {
    let mut words = Vec::new();
    for mut word in text
        .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
        .filter(|w| !w.is_empty())
    {
        let glued = |w: &str| {
            w.as_bytes()
                .windows(2)
                .position(|pair| pair[0].is_ascii_digit() && pair[1] == b'-')
        };
        while let Some(at) = glued(word) {
            words.push(&word[..=at]);
            word = &word[at + 1..];
        }
        words.push(word);
    }
    words
}

/// Content of the header so far.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub layout: Option<Layout>,
    pub scale: Option<Scale>,
    /// Position of the base, ECEF.
    pub base_m: Option<Vector3>,
    /// Whether heights count from the sea.
    pub geoid_heights: bool,
}

impl Header {
    /// Takes one line that begins with `%`.
    pub fn take(&mut self, line: &Line<'_>, report: &mut ReadReport) -> Result<(), ReadError> {
        let text = line.text.trim_start_matches('%').trim();
        if let Some((key, value)) = text.split_once(':') {
            // Entries are written as "name   : value"; dates and file names contain colons too.
            let (key, value) = (key.trim(), value.trim());
            match key {
                "ref pos" => self.base_m = base_position(line, value)?,
                "program" | "inp file" | "obs start" | "obs end" | "pos mode" | "solution"
                | "navi sys" | "amb res" => report.about(key, value),
                _ => {}
            }
        }
        if text.starts_with('(') && text.contains("=Tokyo") {
            return Err(ReadError::Header {
                line: line.number,
                problem: "positions are in the Tokyo datum, only WGS84 is read".to_owned(),
            });
        }
        if text.starts_with("(lat/lon/height") && text.contains("/geodetic") {
            self.geoid_heights = true;
        }
        if let Some((scale, layout)) = column_line(&line.text) {
            for (same, what) in [
                (self.layout.is_none_or(|l| l == layout), "columns"),
                (self.scale.is_none_or(|s| s == scale), "time scale"),
            ] {
                if !same {
                    return Err(ReadError::Header {
                        line: line.number,
                        problem: format!("the {what} change here: two solutions in one file"),
                    });
                }
            }
            self.layout = Some(layout);
            self.scale = Some(scale);
        }
        Ok(())
    }
}

/// Time scale and layout out of the line that names the columns.
pub(super) fn column_line(text: &str) -> Option<(Scale, Layout)> {
    let mut words = text
        .strip_prefix('%')?
        .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
        .filter(|w| !w.is_empty());
    let scale = match words.next()? {
        "GPST" => Scale::Gpst,
        "UTC" => Scale::Utc,
        "JST" => Scale::Jst,
        _ => return None,
    };
    let first = words.next()?;
    let layout = match first {
        "latitude(deg)" => Layout::Degrees,
        _ if first.starts_with("latitude(d'") => Layout::DegreesMinutesSeconds,
        "x-ecef(m)" => Layout::Ecef,
        "e-baseline(m)" => Layout::Baseline,
        _ => return None,
    };
    Some((scale, layout))
}

/// `ref pos`: latitude, longitude, height in degrees or in d-m-s, or ECEF. Zeros mean unknown.
fn base_position(line: &Line<'_>, value: &str) -> Result<Option<Vector3>, ReadError> {
    let words = words(value);
    let mut n = [0.0; 7];
    if words.len() != 3 && words.len() != 7 {
        return Err(line.malformed("a base position of 3 or 7 numbers", quoted(value)));
    }
    for (n, word) in n.iter_mut().zip(&words) {
        *n = line.metres("base position", word)?;
    }
    let three = [n[0], n[1], n[2]];
    let position = if words.len() == 7 {
        let latitude = degrees(words[0], n[0], n[1], n[2]);
        let longitude = degrees(words[3], n[3], n[4], n[5]);
        ecef_from_geodetic(&Geodetic::from_degrees(latitude, longitude, n[6]))
    } else if norm(three) == 0.0 {
        return Ok(None);
    } else if norm(three) > 6e6 {
        three
    } else {
        ecef_from_geodetic(&Geodetic::from_degrees(n[0], n[1], n[2]))
    };
    Ok(Some(position))
}

/// Degrees from degrees, minutes, seconds; the sign is the first word's, −0 included.
pub(super) fn degrees(first_word: &str, d: f64, m: f64, s: f64) -> f64 {
    let size = d.abs() + m / 60.0 + s / 3600.0;
    if first_word.trim_start().starts_with('-') {
        -size
    } else {
        size
    }
}
