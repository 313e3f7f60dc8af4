//! XYZ grids: a point a line, on an even grid, in any order.

use std::io::BufRead;

use super::TerrainError;
use super::raster::{Header, Placement, Window};
use crate::line_end::{LineEnd, lines_of};

/// Longest line that is taken.
const MAX_LINE_BYTES: usize = 1 << 20;

/// Words of a text with their lines.
pub(super) struct Words<R> {
    reader: R,
    line: u64,
    text: String,
    at: usize,
    end: LineEnd,
}

impl<R: BufRead> Words<R> {
    pub fn new(reader: R) -> Self {
        Self {
            reader,
            line: 0,
            text: String::new(),
            at: 0,
            end: LineEnd::default(),
        }
    }

    /// Lines so far.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// The next line; false at the end.
    fn advance(&mut self) -> Result<bool, TerrainError> {
        let mut bytes = Vec::new();
        let mut some = false;
        loop {
            let chunk = self.reader.fill_buf()?;
            if chunk.is_empty() {
                break;
            }
            let piece = self.end.next_piece(chunk);
            some |= piece.ended || !piece.content.is_empty();
            let length = bytes.len() + piece.content.len();
            if length > MAX_LINE_BYTES {
                return Err(TerrainError::Limit {
                    what: "bytes in a line",
                    found: length as u128,
                    limit: MAX_LINE_BYTES as u128,
                });
            }
            bytes.extend_from_slice(&chunk[piece.content]);
            self.reader.consume(piece.consumed);
            if piece.ended {
                break;
            }
        }
        self.text = String::from_utf8_lossy(&bytes).into_owned();
        self.at = 0;
        self.line += u64::from(some);
        Ok(some)
    }

    /// The next word and its line.
    pub fn next(&mut self) -> Result<Option<(u64, String)>, TerrainError> {
        loop {
            let rest = &self.text[self.at..];
            let trimmed = rest.trim_start();
            if !trimmed.is_empty() {
                let start = self.at + rest.len() - trimmed.len();
                let length = trimmed.find(char::is_whitespace).unwrap_or(trimmed.len());
                self.at = start + length;
                return Ok(Some((
                    self.line,
                    self.text[start..start + length].to_owned(),
                )));
            }
            if !self.advance()? {
                return Ok(None);
            }
        }
    }
}

/// A finite number.
pub(super) fn number(line: u64, word: &str) -> Result<f64, TerrainError> {
    word.parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
        .ok_or_else(|| TerrainError::Line {
            line,
            expected: "a finite number",
            found: format!("{:?}", word.chars().take(40).collect::<String>()),
        })
}

/// Whether a text begins with lines of three numbers, a line of names before them or not.
pub(super) fn begins(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&start[..start.len().min(1 << 12)]);
    let is_point = |line: &str| {
        let mut fields = line
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|f| !f.is_empty());
        let is_number = |field: &str| number(0, field).is_ok();
        (&mut fields).take(3).filter(|f| is_number(f)).count() == 3 && fields.next().is_none()
    };
    // The last line may be cut off.
    let ended = text
        .rsplit_once(['\n', '\r'])
        .map_or("", |(ended, _)| ended);
    let mut lines = lines_of(ended)
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    lines.next_if(|line| !is_point(line));
    lines.peek().is_some() && lines.all(is_point)
}

/// Reads a whole grid. Columns are separated by spaces, tabs, commas or semicolons; lines that begin with
/// `#`, and a first line of words, are skipped.
pub(super) fn read(reader: impl BufRead, limit: usize) -> Result<(Header, Window), TerrainError> {
    let mut lines = Words::new(reader);
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut line_of_first = 0;
    while lines.advance()? {
        let text = lines.text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let mut fields = text
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|f| !f.is_empty());
        let [Some(x), Some(y), Some(z)] = [fields.next(), fields.next(), fields.next()] else {
            return Err(TerrainError::Line {
                line: lines.line,
                expected: "x, y and z",
                found: format!("{:?}", text.chars().take(40).collect::<String>()),
            });
        };
        if points.is_empty() && line_of_first == 0 && x.starts_with(|c: char| c.is_alphabetic()) {
            line_of_first = lines.line; // names of the columns
            continue;
        }
        let mut point = [0.0; 3];
        for (value, field) in point.iter_mut().zip([x, y, z]) {
            *value = number(lines.line, field)?;
        }
        if points.is_empty() {
            line_of_first = lines.line;
        }
        if points.len() >= limit {
            return Err(TerrainError::Limit {
                what: "points",
                found: points.len() as u128 + 1,
                limit: limit as u128,
            });
        }
        points.push(point);
    }
    let first = *points.first().ok_or(TerrainError::Empty)?;
    let axes = [0, 1].map(|a| Axis::of(points.iter().map(|p| p[a])));
    let [columns, rows] = [axes[0].count, axes[1].count];
    // A grid that is mostly holes is no grid: scattered points.
    let cells = columns as u128 * rows as u128;
    if cells > 4 * points.len() as u128 + 64 {
        return Err(TerrainError::NoGrid {
            line: line_of_first,
            x: first[0],
            y: first[1],
            step_x: axes[0].step,
            step_y: axes[1].step,
        });
    }
    let mut window = Window::empty(0..columns, 0..rows, limit.saturating_mul(4))?;
    for (k, [x, y, z]) in points.iter().enumerate() {
        let (Some(i), Some(j)) = (axes[0].index(*x), axes[1].index(*y)) else {
            return Err(TerrainError::NoGrid {
                // Lines of comments may be between: the search continues over this number of lines.
                line: line_of_first + k as u64,
                x: *x,
                y: *y,
                step_x: axes[0].step,
                step_y: axes[1].step,
            });
        };
        window.height_m[j * columns + i] = *z as f32;
    }
    let header = Header {
        columns,
        rows,
        placement: Placement::new(
            [axes[0].start, axes[1].start],
            [axes[0].step, 0.0],
            [0.0, axes[1].step],
        )?,
        crs: None,
        vertical: None,
    };
    Ok((header, window))
}

/// The even steps of one coordinate.
struct Axis {
    start: f64,
    step: f64,
    count: usize,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let (start, end) = (values[0], values[values.len() - 1]);
        let size = start.abs().max(end.abs());
        // Coordinates are printed to some decimals: distance below which two are equal.
        let same = (1e-9 * size).max((end - start) * 1e-7);
        let step = values
            .windows(2)
            .map(|w| w[1] - w[0])
            .filter(|d| *d > same)
            .fold(f64::INFINITY, f64::min);
        if !step.is_finite() {
            return Self {
                start,
                step: 1.0,
                count: 1,
            };
        }
        let steps = ((end - start) / step).round();
        let count = if steps < 1e9 {
            steps as usize + 1
        } else {
            1 << 30
        };
        Self {
            start,
            // The mean step: one difference alone carries the rounding of two decimals.
            step: (end - start) / (count - 1) as f64,
            count,
        }
    }

    fn index(&self, value: f64) -> Option<usize> {
        let at = (value - self.start) / self.step;
        let near = at.round();
        ((at - near).abs() < 0.05 && near >= 0.0 && near < self.count as f64)
            .then_some(near as usize)
    }
}
