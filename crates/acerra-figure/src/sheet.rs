//! Drawings in rows and columns.

use super::drawing::{DEFAULT_SCALE, Drawing, Item};

/// Rows of drawings as one drawing: the drawings of a row are side by side, rows are below each other,
/// and every column begins right of the widest drawing of the column before.
///
/// ```
/// use acerra_figure::{ImageDb, PixelValues, sheet};
///
/// let amplitude = vec![0.5_f32; 20 * 20];
/// let panel = || ImageDb::new("", PixelValues::Amplitude(&amplitude), 20, 20).draw();
/// let alone = panel()?;
/// let pair = sheet(vec![vec![panel()?, panel()?]]);
/// assert_eq!(pair.width_px, 2 * alone.width_px);
/// assert_eq!(pair.height_px, alone.height_px);
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[must_use]
pub fn sheet(rows: Vec<Vec<Drawing>>) -> Drawing {
    let left_px = column_starts_px(&rows);
    let mut whole = Drawing {
        width_px: left_px.last().copied().unwrap_or(0),
        height_px: 0,
        scale: DEFAULT_SCALE,
        description: String::new(),
        items: Vec::new(),
    };
    for row in rows {
        let top_px = whole.height_px;
        for (drawing, left_px) in row.into_iter().zip(&left_px) {
            let by = [*left_px as f32, top_px as f32];
            let moved = |item: Item| item.moved(by);
            whole.items.extend(drawing.items.into_iter().map(moved));
            whole.height_px = whole.height_px.max(top_px + drawing.height_px);
            if !whole.description.is_empty() {
                whole.description.push_str("; ");
            }
            whole.description.push_str(&drawing.description);
        }
    }
    whole
}

/// Left edge of every column, and the right edge of the last.
fn column_starts_px(rows: &[Vec<Drawing>]) -> Vec<u32> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width_px = |column: usize| {
        let drawings = rows.iter().filter_map(|row| row.get(column));
        drawings.map(|drawing| drawing.width_px).max().unwrap_or(0)
    };
    let mut starts = vec![0];
    for column in 0..columns {
        starts.push(starts[column] + width_px(column));
    }
    starts
}
