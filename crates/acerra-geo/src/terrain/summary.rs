//! Summary of a raster of heights.

use std::io::{Read, Seek};

use super::{Content, TerrainError, TerrainFile};

/// Heights of a whole raster, in metres as the file counts them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightSummary {
    /// Lowest height (m); NaN without any.
    pub lowest_m: f64,
    /// Mean height (m); NaN without any.
    pub mean_m: f64,
    /// Highest height (m); NaN without any.
    pub highest_m: f64,
    /// Cells without data.
    pub without_data: usize,
}

impl<R: Read + Seek> TerrainFile<R> {
    /// The coordinates of the centres of the first and the last cell, in the raster's system.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 2] {
        let last = [self.header.columns - 1, self.header.rows - 1].map(|k| k as f64);
        [[0.0; 2], last].map(|cell| self.header.placement.coordinates(cell))
    }

    /// Purpose of the grid by GDAL's metadata (`TYPE`), in a GeoTIFF that has it.
    #[must_use]
    pub fn grid_type(&self) -> Option<&str> {
        match &self.content {
            Content::GeoTiff(tiff) => tiff.grid_type.as_deref(),
            Content::Whole(_) => None,
        }
    }

    /// Reads all heights: scales, offsets, units and masks of the file applied, no offset of the options.
    ///
    /// # Errors
    /// More cells than `limit`, and a file that is broken.
    pub fn heights(&mut self, limit: usize) -> Result<HeightSummary, TerrainError> {
        let [columns, rows] = self.size();
        let window = match &mut self.content {
            Content::GeoTiff(tiff) => &tiff.window(0..columns, 0..rows, limit)?,
            Content::Whole(window) => window,
        };
        let known = window
            .height_m
            .iter()
            .copied()
            .map(f64::from)
            .filter(|h| h.is_finite());
        let (count, sum, lowest_m, highest_m) = known.fold(
            (0_usize, 0.0, f64::NAN, f64::NAN),
            |(count, sum, low, high): (usize, f64, f64, f64), h| {
                (count + 1, sum + h, low.min(h), high.max(h))
            },
        );
        Ok(HeightSummary {
            lowest_m,
            mean_m: sum / count as f64,
            highest_m,
            without_data: window.height_m.len() - count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::TerrainOptions;

    #[test]
    fn heights_and_holes_of_a_grid_are_counted() {
        let text = "ncols 3\nnrows 2\nxllcenter 10\nyllcenter 20\ncellsize 2\nnodata_value -9\n1 2 -9\n4 5 6.5\n";
        let mut file =
            TerrainFile::open(std::io::Cursor::new(text), &TerrainOptions::default()).unwrap();
        assert_eq!(file.corners(), [[10.0, 22.0], [14.0, 20.0]]);
        let heights = file.heights(100).unwrap();
        assert_eq!((heights.lowest_m, heights.highest_m), (1.0, 6.5));
        assert_eq!((heights.mean_m, heights.without_data), (3.7, 1));
        let none =
            "ncols 1\nnrows 1\nxllcenter 10\nyllcenter 20\ncellsize 2\nnodata_value -9\n-9\n";
        let mut file =
            TerrainFile::open(std::io::Cursor::new(none), &TerrainOptions::default()).unwrap();
        let heights = file.heights(100).unwrap();
        assert!(heights.lowest_m.is_nan() && heights.mean_m.is_nan() && heights.without_data == 1);
    }
}
