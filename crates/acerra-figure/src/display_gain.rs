//! A gain that varies over an image, for display.

/// A gain in dB that is added to an image's levels for display alone, given on a regular grid of
/// nodes from edge to edge of the image along both axes, and bilinear between them.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayGain {
    /// Caption for the colour bar.
    pub name: String,
    gain_db: Vec<f64>,
}

/// Nodes along each axis.
const NODES: usize = 129;

impl DisplayGain {
    /// Samples `gain_db(x, y)` over an image whose edges are at `x` and `y`. Values that are not
    /// finite count as 0 dB.
    pub fn sample(
        name: impl Into<String>,
        x: [f64; 2],
        y: [f64; 2],
        gain_db: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let place = |[from, to]: [f64; 2], i: usize| from + (to - from) * i as f64 / LAST;
        let node = |i: usize| {
            let gain = gain_db(place(x, i % NODES), place(y, i / NODES));
            if gain.is_finite() { gain } else { 0.0 }
        };
        Self {
            name: name.into(),
            gain_db: (0..NODES * NODES).map(node).collect(),
        }
    }

    /// Largest less smallest gain, in dB.
    #[must_use]
    pub fn span_db(&self) -> f64 {
        let extreme = |pick: fn(f64, f64) -> f64| {
            let gains = self.gain_db.iter().copied();
            gains.reduce(pick).unwrap_or(0.0)
        };
        extreme(f64::max) - extreme(f64::min)
    }

    /// The gain at fractions of the way from edge to edge along x and y.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let split = |fraction: f64| {
            let place = fraction.clamp(0.0, 1.0) * LAST;
            let cell = (place as usize).min(NODES - 2);
            (cell, place - cell as f64)
        };
        let ((column, u), (row, v)) = (split(x), split(y));
        let node = |c: usize, r: usize| self.gain_db[r * NODES + c];
        let low = node(column, row) * (1.0 - u) + node(column + 1, row) * u;
        let high = node(column, row + 1) * (1.0 - u) + node(column + 1, row + 1) * u;
        low * (1.0 - v) + high * v
    }
}

const LAST: f64 = (NODES - 1) as f64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bilinear_gain_is_kept_exactly() {
        let gain = DisplayGain::sample("", [-2.0, 4.0], [1.0, 3.0], |x, y| {
            2.0 * x - y + 0.5 * x * y
        });
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (0.123, 0.77), (0.5, 0.01)] {
            let (x, y) = (-2.0 + 6.0 * u, 1.0 + 2.0 * v);
            assert!((gain.at(u, v) - (2.0 * x - y + 0.5 * x * y)).abs() < 1e-9);
        }
        assert!(gain.span_db() > 0.0);
    }
}
