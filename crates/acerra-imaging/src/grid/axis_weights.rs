//! Interpolation of heights along an axis.

/// Weights of pixels along an axis for a place between pixels or beyond the last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisWeights {
    pixels: [(usize, f64); Self::MOST],
    count: usize,
}

impl AxisWeights {
    /// Four pixels, each with its reflection.
    const MOST: usize = 8;
    /// Distance from a pixel's centre within which a place counts as the centre, pixels.
    const SAME: f64 = 1e-6;

    /// Weights at `t` pixels from the first of `count` pixels, by cubic convolution (Keys 1981, a = −½).
    pub fn at(t: f64, count: usize) -> Self {
        let mut weights = Self {
            pixels: [(0, 0.0); Self::MOST],
            count: 0,
        };
        let nearest = t.round();
        if (t - nearest).abs() < Self::SAME {
            weights.add(nearest as i64, 1.0, count);
            return weights;
        }
        let (first, u) = (t.floor() as i64, t - t.floor());
        let cubic = [
            u * (-0.5 + u * (1.0 - 0.5 * u)),
            1.0 + u * u * (-2.5 + 1.5 * u),
            u * (0.5 + u * (2.0 - 1.5 * u)),
            u * u * (-0.5 + 0.5 * u),
        ];
        for (pixel, weight) in (first - 1..).zip(cubic) {
            weights.add(pixel, weight, count);
        }
        weights
    }

    /// Adds a pixel; a pixel beyond the last is continued by point reflection at the last pixel.
    fn add(&mut self, pixel: i64, weight: f64, count: usize) {
        let last = count as i64 - 1;
        let edge = pixel.clamp(0, last);
        if pixel == edge {
            self.push(edge, weight);
        } else {
            self.push(edge, 2.0 * weight);
            self.push((2 * edge - pixel).clamp(0, last), -weight);
        }
    }

    fn push(&mut self, pixel: i64, weight: f64) {
        self.pixels[self.count] = (pixel as usize, weight);
        self.count += 1;
    }

    /// The weighted sum of heights along the axis.
    pub fn of<T: Copy + Into<f64>>(&self, heights: &[T]) -> f64 {
        self.taken().map(|(i, w)| w * heights[i].into()).sum()
    }

    pub fn taken(&self) -> impl Iterator<Item = (usize, f64)> {
        self.pixels[..self.count].iter().copied()
    }
}
