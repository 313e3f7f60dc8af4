//! An image as a bare picture, to be laid over a map: no axes, transparent where it is dark.

use rayon::prelude::*;

use super::colour::look_up;
use super::error::{FigureError, check_len};
use super::image_db::ImageDb;
use super::raster::encode_png_rgba;
use super::resample::peak_pool;

/// Share of the window of levels over which the picture becomes opaque.
const FADE: f64 = 0.35;

impl ImageDb<'_> {
    /// The image alone as a PNG (8-bit RGBA) of at most `most_side` pixels a side, north at the top:
    /// transparent at the lowest level shown, opaque from a third of the window on. Track and marks are
    /// left out.
    ///
    /// # Errors
    /// [`FigureError::ShapeMismatch`] where the pixels do not fill `nx × ny`;
    /// [`FigureError::NothingToDraw`] for an empty grid.
    ///
    /// ```
    /// use acerra_figure::{ImageDb, PixelValues};
    /// let amplitude = [0.0_f32, 1.0, 0.5, 0.001];
    /// let image = ImageDb::new("", PixelValues::Amplitude(&amplitude), 2, 2);
    /// assert!(image.overlay_png(4096)?.starts_with(b"\x89PNG"));
    /// # Ok::<(), acerra_figure::FigureError>(())
    /// ```
    pub fn overlay_png(&self, most_side: usize) -> Result<Vec<u8>, FigureError> {
        check_len("image", self.nx.saturating_mul(self.ny), self.pixels.len())?;
        if self.nx == 0 || self.ny == 0 || most_side == 0 {
            return Err(FigureError::NothingToDraw {
                what: "overlay",
                reason: "the grid has no pixels",
            });
        }
        let shown = self.levels();
        let step = self.nx.max(self.ny).div_ceil(most_side);
        let (columns, rows) = (self.nx.div_ceil(step), self.ny.div_ceil(step));
        let strength = |i: usize| self.pixels.strength(i);
        let pooled = peak_pool(strength, |v| v, (self.nx, self.ny), (columns, rows));
        let table = self.palette.table();
        let mut rgba = vec![0; 4 * pooled.len()];
        rgba.par_chunks_exact_mut(4 * columns)
            .zip(pooled.par_chunks_exact(columns).enumerate().rev())
            .for_each(|(line, (row, strengths))| {
                for (column, (pixel, strength)) in
                    line.chunks_exact_mut(4).zip(strengths).enumerate()
                {
                    let level = self.pixels.level_db(*strength)
                        + self.gain_db((column, row), (columns, rows));
                    let fraction = 1.0 - (level - shown.reference_db) / shown.floor_db;
                    if fraction > 0.0 {
                        pixel[..3].copy_from_slice(&look_up(&table, fraction));
                        pixel[3] = (255.0 * (fraction / FADE).min(1.0)).round() as u8;
                    }
                }
            });
        encode_png_rgba(columns as u32, rows as u32, &rgba)
    }
}

#[cfg(test)]
mod tests {
    use crate::{ImageDb, PixelValues};

    #[test]
    fn the_north_is_on_top_and_the_dark_is_clear() {
        // Row 0 is the southernmost: dark, floor, bright; then the northern row.
        let amplitude = [0.0_f32, 0.01, 1.0, f32::NAN, 1.0, 0.0];
        let image = ImageDb::new("", PixelValues::Amplitude(&amplitude), 3, 2);
        let bytes = image.overlay_png(100).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgba).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        let alpha: Vec<u8> = rgba.chunks(4).map(|p| p[3]).collect();
        assert_eq!(alpha, [0, 255, 0, 0, 0, 255]);
    }
}
