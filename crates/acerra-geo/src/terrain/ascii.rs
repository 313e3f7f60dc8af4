//! ESRI ASCII grids: a header of keys, then heights row by row from the north.

use std::io::BufRead;

use super::TerrainError;
use super::raster::{Header, Placement, Window};
use super::xyz::{Words, number};

/// Reads a whole grid.
pub(super) fn read(reader: impl BufRead, limit: usize) -> Result<(Header, Window), TerrainError> {
    let mut words = Words::new(reader);
    let mut keys = Keys::default();
    let (mut next, first_line) = loop {
        let Some((line, word)) = words.next()? else {
            return Err(TerrainError::Line {
                line: words.line(),
                expected: "heights after the header",
                found: "the end of the file".to_owned(),
            });
        };
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) && !word.eq_ignore_ascii_case("nan")
        {
            let value = words.next()?.ok_or_else(|| TerrainError::Line {
                line,
                expected: "a number after the key",
                found: "the end of the file".to_owned(),
            })?;
            keys.set(line, &word, number_or_nan(value.0, &value.1)?)?;
        } else {
            break (Some((line, word)), line);
        }
    };
    let header = keys.header(first_line)?;
    let mut window = Window::empty(0..header.columns, 0..header.rows, limit)?;
    for k in 0..window.height_m.len() {
        let (line, word) = match next.take() {
            Some(word) => word,
            None => words.next()?.ok_or_else(|| TerrainError::Line {
                line: words.line(),
                expected: "as many heights as the header says",
                found: format!("{k}, then the end of the file"),
            })?,
        };
        let value = number_or_nan(line, &word)?;
        if Some(value) != keys.nodata {
            window.height_m[k] = value as f32;
        }
    }
    if let Some((line, word)) = words.next()? {
        return Err(TerrainError::Line {
            line,
            expected: "the end of the file after the last height",
            found: format!("{word:?}"),
        });
    }
    Ok((header, window))
}

/// Keys that a grid may begin with, in any order.
const FIRST_KEYS: [&str; 10] = [
    "ncols",
    "nrows",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
];

/// Whether a text begins with a key of such a grid.
pub(super) fn begins(start: &[u8]) -> bool {
    let word = start.split(u8::is_ascii_whitespace).find(|w| !w.is_empty());
    let is = |key: &str| word.is_some_and(|w| w.eq_ignore_ascii_case(key.as_bytes()));
    FIRST_KEYS.iter().any(|key| is(key))
}

/// A finite number, or NaN where the word is the no-data value.
fn number_or_nan(line: u64, word: &str) -> Result<f64, TerrainError> {
    if word.trim_start_matches('-').eq_ignore_ascii_case("nan") {
        return Ok(f64::NAN);
    }
    number(line, word)
}

#[derive(Default)]
struct Keys {
    columns: Option<f64>,
    rows: Option<f64>,
    /// West edge, or centre of the first column; south likewise.
    corner: [Option<f64>; 2],
    centre: [Option<f64>; 2],
    step: [Option<f64>; 2],
    nodata: Option<f64>,
}

impl Keys {
    fn set(&mut self, line: u64, key: &str, value: f64) -> Result<(), TerrainError> {
        match key.to_ascii_lowercase().as_str() {
            "ncols" => self.columns = Some(value),
            "nrows" => self.rows = Some(value),
            "xllcorner" => self.corner[0] = Some(value),
            "yllcorner" => self.corner[1] = Some(value),
            "xllcenter" => self.centre[0] = Some(value),
            "yllcenter" => self.centre[1] = Some(value),
            "cellsize" => self.step = [Some(value); 2],
            "dx" => self.step[0] = Some(value),
            "dy" => self.step[1] = Some(value),
            "nodata_value" => self.nodata = Some(value),
            _ => {
                return Err(TerrainError::Line {
                    line,
                    expected: "ncols, nrows, xllcorner, yllcorner (or center), cellsize or \
                               nodata_value",
                    found: format!("{key:?}"),
                });
            }
        }
        Ok(())
    }

    fn header(&self, line: u64) -> Result<Header, TerrainError> {
        let missing = |expected| TerrainError::Line {
            line,
            expected,
            found: "heights".to_owned(),
        };
        let count = |value: Option<f64>, key| {
            let value = value.ok_or_else(|| missing(key))?;
            if value.fract() == 0.0 && (1.0..=1e9).contains(&value) {
                Ok(value as usize)
            } else {
                Err(TerrainError::Line {
                    line,
                    expected: "whole ncols and nrows from 1 to 1e9",
                    found: format!("{value}"),
                })
            }
        };
        let columns = count(self.columns, "ncols in the header")?;
        let rows = count(self.rows, "nrows in the header")?;
        let step = [0, 1].map(|a| self.step[a].filter(|s| *s > 0.0));
        let [Some(dx), Some(dy)] = step else {
            return Err(missing("cellsize above 0 in the header"));
        };
        let first = [0, 1].map(|a| {
            let half = 0.5 * [dx, dy][a];
            self.centre[a].or(self.corner[a].map(|c| c + half))
        });
        let [Some(x0), Some(y0)] = first else {
            return Err(missing("xllcorner and yllcorner (or center) in the header"));
        };
        let north = y0 + (rows - 1) as f64 * dy;
        Ok(Header {
            columns,
            rows,
            placement: Placement::new([x0, north], [dx, 0.0], [0.0, -dy])?,
            crs: None,
            vertical: None,
        })
    }
}
