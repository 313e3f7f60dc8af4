//! Cells: the shortest stretches of a fine and of a coarse grid that repeat together.

/// A cell along an axis: `pixels` of the fine grid are as long as `samples` of the coarse grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell {
    pub pixels: usize,
    pub samples: usize,
}

impl Cell {
    /// Fine pixels in a coarse interval.
    pub fn interval(self) -> f64 {
        self.pixels as f64 / self.samples as f64
    }

    /// The sample at or before a pixel of the cell, counted from the cell's first sample.
    pub fn sample_before(self, pixel: usize) -> usize {
        pixel * self.samples / self.pixels
    }

    /// Distance of a pixel from the sample at or before it, in coarse intervals.
    pub fn fraction(self, pixel: usize) -> f64 {
        (pixel * self.samples % self.pixels) as f64 / self.pixels as f64
    }

    /// All candidate cells of at most `most_samples` samples, the shortest intervals first. Intervals are
    /// fractions of pixels only where whole numbers are relatively far apart.
    pub fn all(most_samples: usize) -> Vec<Self> {
        let of = |samples: usize| {
            let most = if samples == 1 {
                COARSEST
            } else {
                LONGEST_FRACTION * samples
            };
            let has_no_shorter = move |pixels: &usize| gcd(*pixels, samples) == 1;
            (samples..=most)
                .filter(has_no_shorter)
                .map(move |pixels| Self { pixels, samples })
        };
        let mut cells: Vec<Self> = (1..=most_samples).flat_map(of).collect();
        cells.sort_by(|a, b| a.interval().total_cmp(&b.interval()));
        cells
    }
}

/// Greatest number of fine pixels in a coarse interval.
const COARSEST: usize = 64;
/// Greatest coarse interval, in fine pixels, that may be a fraction of pixels.
const LONGEST_FRACTION: usize = 6;

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_stand_behind_their_samples() {
        for cell in Cell::all(3) {
            for pixel in 0..cell.pixels {
                let at = cell.sample_before(pixel) as f64 + cell.fraction(pixel);
                assert!((at * cell.interval() - pixel as f64).abs() < 1e-9);
                assert!((0.0..1.0).contains(&cell.fraction(pixel)));
            }
        }
        let intervals: Vec<f64> = Cell::all(3).into_iter().map(Cell::interval).collect();
        assert!(intervals.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(intervals[..4], [1.0, 4.0 / 3.0, 1.5, 5.0 / 3.0]);
        assert_eq!(intervals[intervals.len() - 1], 64.0);
        assert!(Cell::all(1).iter().all(|cell| cell.samples == 1));
    }
}
