//! Binary grids of fixed layout: NGA's `.DAC` and NOAA's `.gtx`.

use super::GeoidError;
use super::grid::{GeoidGrid, Layout, northwards};

/// Bytes of NGA's EGM96 grid of a quarter of a degree.
pub(super) const DAC_BYTES: usize = 721 * 1440 * 2;

pub(super) fn dac(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let heights: Vec<f32> = bytes
        .chunks_exact(2)
        .map(|b| f32::from(i16::from_be_bytes([b[0], b[1]])) * 0.01)
        .collect();
    let layout = Layout {
        south: -90.0,
        west: 0.0,
        steps: [0.25, 0.25],
        rows: 721,
        columns: 1440,
    };
    GeoidGrid::new(&layout, northwards(&heights, 1440), "EGM96 .DAC")
}

pub(super) fn gtx(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    const HEADER_BYTES: usize = 40;
    let unknown = || GeoidError::Unknown { bytes: bytes.len() };
    let real = |at: usize| {
        let field: Option<[u8; 8]> = bytes.get(at..at + 8)?.try_into().ok();
        field.map(f64::from_be_bytes).filter(|v| v.is_finite())
    };
    let count = |at: usize| {
        let field: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(i32::from_be_bytes(field)).ok()
    };
    let header = || {
        Some((
            real(0)?,
            real(8)?,
            [real(16)?, real(24)?],
            count(32)?,
            count(36)?,
        ))
    };
    let (south, west, steps, rows, columns) = header().ok_or_else(unknown)?;
    let expected = rows
        .checked_mul(columns)
        .and_then(|n| n.checked_mul(4)?.checked_add(HEADER_BYTES));
    if expected != Some(bytes.len()) || rows < 2 || columns < 2 {
        return Err(unknown());
    }
    let heights = bytes[HEADER_BYTES..]
        .chunks_exact(4)
        .map(|b| f32::from_be_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    let layout = Layout {
        south,
        west,
        steps,
        rows,
        columns,
    };
    GeoidGrid::new(&layout, heights, ".gtx")
}
