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

const GTX_HEADER_BYTES: usize = 40;

/// The layout that a `.gtx` header states, if its `file_bytes` bytes hold such a grid.
fn gtx_layout(head: &[u8], file_bytes: u64) -> Option<Layout> {
    let real = |at: usize| {
        let field: [u8; 8] = head.get(at..at + 8)?.try_into().ok()?;
        Some(f64::from_be_bytes(field)).filter(|v| v.is_finite())
    };
    let count = |at: usize| {
        let field: [u8; 4] = head.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(i32::from_be_bytes(field)).ok()
    };
    let (rows, columns) = (count(32)?, count(36)?);
    let cells_bytes = rows.checked_mul(columns)?.checked_mul(4)?;
    let expected = cells_bytes.checked_add(GTX_HEADER_BYTES)?;
    if expected as u64 != file_bytes || rows < 2 || columns < 2 {
        return None;
    }
    Some(Layout {
        south: real(0)?,
        west: real(8)?,
        steps: [real(16)?, real(24)?],
        rows,
        columns,
    })
}

/// Whether a file of this beginning and length is a `.gtx` grid.
pub(super) fn is_gtx(head: &[u8], file_bytes: u64) -> bool {
    gtx_layout(head, file_bytes).is_some()
}

pub(super) fn gtx(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let layout =
        gtx_layout(bytes, bytes.len() as u64).ok_or(GeoidError::Unknown { bytes: bytes.len() })?;
    let heights = bytes[GTX_HEADER_BYTES..]
        .chunks_exact(4)
        .map(|b| f32::from_be_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    GeoidGrid::new(&layout, heights, ".gtx")
}
