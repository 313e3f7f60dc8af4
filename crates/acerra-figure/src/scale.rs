//! From values to pixels along one axis.

/// The map from values to pixels along one axis.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub from: [f64; 2],
    pub to: [f32; 2],
    pub log: bool,
}

impl Scale {
    pub fn at(&self, value: f64) -> f32 {
        let fraction = if self.log {
            (value / self.from[0]).ln() / (self.from[1] / self.from[0]).ln()
        } else {
            (value - self.from[0]) / (self.from[1] - self.from[0])
        };
        // Far outside is as good as just outside, and keeps the rasteriser's numbers small.
        let fraction = fraction.clamp(-20.0, 21.0);
        self.to[0] + fraction as f32 * (self.to[1] - self.to[0])
    }
}
