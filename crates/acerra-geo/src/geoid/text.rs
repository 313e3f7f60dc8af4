//! NGA's `.GRD` grids: text.

use super::GeoidError;
use super::grid::{GeoidGrid, Layout, northwards};

const FORMAT: &str = ".GRD";

/// Reads `WW15MGH.GRD`: south, north, west and east edges and the steps of latitude and longitude
/// (degrees), then heights (m) in rows from north to south, each from west to east with both edges.
pub(super) fn grd(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let unknown = || GeoidError::Unknown { bytes: bytes.len() };
    let text = std::str::from_utf8(bytes).map_err(|_| unknown())?;
    let mut words = text.split_ascii_whitespace();
    let mut header = [0.0; 6];
    for value in &mut header {
        *value = words.next().and_then(number).ok_or_else(unknown)?;
    }
    let [south, north, west, east, latitude_step, longitude_step] = header;
    let count = |first: f64, last: f64, step: f64| {
        let n = (last - first) / step;
        // A grid of a minute of arc has 21 601 columns.
        let whole = step > 0.0 && (n - n.round()).abs() < 1e-3 && (1.0..1e5).contains(&n);
        whole.then(|| n.round() as usize + 1)
    };
    let rows = count(south, north, latitude_step);
    let columns = count(west, east, longitude_step);
    let (rows, columns) = rows.zip(columns).ok_or_else(unknown)?;
    let wrong = |expected: String, found: String| GeoidError::Format {
        format: FORMAT,
        expected,
        found,
    };
    let mut heights = Vec::new();
    for word in words {
        let place = heights.len() + 1;
        let height = number(word)
            .ok_or_else(|| wrong(format!("a height at place {place}"), format!("{word:?}")))?;
        heights.push(height as f32);
    }
    if heights.len() != rows * columns {
        let expected = format!("{columns} × {rows} heights");
        return Err(wrong(expected, format!("{} of them", heights.len())));
    }
    let layout = Layout {
        south,
        west,
        steps: [latitude_step, longitude_step],
        rows,
        columns,
    };
    GeoidGrid::new(&layout, northwards(&heights, columns), FORMAT)
}

/// Whether a text begins with the edges and steps of such a grid, on one line.
pub(super) fn begins(head: &[u8]) -> bool {
    let end = head.iter().position(|b| matches!(b, b'\n' | b'\r'));
    let Ok(line) = std::str::from_utf8(&head[..end.unwrap_or(head.len()).min(200)]) else {
        return false;
    };
    let values: Option<Vec<f64>> = line.split_ascii_whitespace().map(number).collect();
    matches!(values.as_deref(), Some([south, north, west, east, latitude_step, longitude_step])
        if (-90.001..*north).contains(south) && *north < 90.001 && west < east && east - west < 360.001
            && *latitude_step > 0.0 && *longitude_step > 0.0)
}

fn number(word: &str) -> Option<f64> {
    word.parse().ok().filter(|v: &f64| v.is_finite())
}
