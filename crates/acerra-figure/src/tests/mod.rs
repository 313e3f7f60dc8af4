//! Tests of the figures, read back from their pixels.

mod gallery;
mod images;
mod plots;
mod radargrams;

use super::frame::{Frame, FrameSpec, Size};
use super::*;
use num_complex::Complex32;

struct Picture {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
    scale: u32,
}

impl Picture {
    fn of(name: &str, drawing: &Drawing) -> Self {
        // For looking at: ACERRA_FIGURES=/some/dir cargo test -p acerra figure
        if let Ok(dir) = std::env::var("ACERRA_FIGURES") {
            std::fs::write(format!("{dir}/{name}.png"), drawing.to_png().unwrap()).unwrap();
            std::fs::write(format!("{dir}/{name}.svg"), drawing.to_svg()).unwrap();
        }
        let (width, height, rgb) = drawing.to_rgb().unwrap();
        assert_eq!(
            (width, height),
            (
                drawing.width_px * drawing.scale,
                drawing.height_px * drawing.scale
            )
        );
        Self {
            width,
            height,
            rgb,
            scale: drawing.scale,
        }
    }

    /// The colour at CSS pixel (x, y).
    fn at(&self, x: f32, y: f32) -> [u8; 3] {
        let (x, y) = (
            (x * self.scale as f32) as usize,
            (y * self.scale as f32) as usize,
        );
        let i = 3 * (y * self.width as usize + x);
        [self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]
    }

    /// The CSS pixels (mean place) whose colour `wanted` accepts, and their number.
    fn find(&self, wanted: impl Fn([u8; 3]) -> bool) -> (f32, f32, usize) {
        let (mut x, mut y, mut n) = (0.0, 0.0, 0usize);
        for row in 0..self.height as usize {
            for column in 0..self.width as usize {
                let i = 3 * (row * self.width as usize + column);
                if wanted([self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]) {
                    x += column as f64 + 0.5;
                    y += row as f64 + 0.5;
                    n += 1;
                }
            }
        }
        let unit = n as f64 * f64::from(self.scale);
        ((x / unit) as f32, (y / unit) as f32, n)
    }
}

fn near(a: [u8; 3], b: [u8; 3], tolerance: u8) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= tolerance)
}

/// The plot rectangle of an image without title, legend and marks, found from its raster.
fn plot_of(drawing: &Drawing) -> drawing::Rect {
    drawing
        .items
        .iter()
        .find_map(|item| match item {
            drawing::Item::Raster { rect, .. } => Some(*rect),
            _ => None,
        })
        .expect("the image's raster comes first")
}
