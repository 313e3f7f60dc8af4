//! Test whether the angles of view determine the delay.

use acerra_imaging::PlaneGrid;

/// Error of the delay that must defocus some pixel (s).
const ERROR_S: f64 = 1e-9;

/// Pixels of an image, and the positions from which they are seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub position_m: &'a [[f64; 3]],
    pub grid: PlaneGrid,
    pub middle_hz: f64,
    pub light_speed_m_s: f64,
}

impl View<'_> {
    /// Whether some pixel is seen under angles so different that an error [`ERROR_S`] of the delay defocuses
    /// the pixel: ranges ΔR too long bend the pixel's echoes by ΔR(1 − R₀/R₁) from the nearest range R₀ to
    /// the farthest R₁, and a bend of λ/8 is a quarter of a turn.
    pub fn determines_delay(&self) -> bool {
        let wavelength_m = self.light_speed_m_s / self.middle_hz;
        let error_m = 0.5 * self.light_speed_m_s * ERROR_S;
        let along = |count: usize| (0..=8).map(move |k| count.saturating_sub(1) * k / 8);
        along(self.grid.ny)
            .flat_map(|iy| along(self.grid.nx).map(move |ix| [ix, iy]))
            .any(|[ix, iy]| {
                let pixel = [self.grid.x_m(ix), self.grid.y_m(iy), self.grid.z_m];
                let range_m = |p: &[f64; 3]| {
                    let square: f64 = (0..3).map(|i| (p[i] - pixel[i]).powi(2)).sum();
                    square.sqrt()
                };
                let ranges = self.position_m.iter().map(range_m);
                let (near, far) = ranges
                    .fold((f64::INFINITY, 0.0), |(near, far): (f64, f64), r| {
                        (near.min(r), far.max(r))
                    });
                far > 0.0 && error_m * (1.0 - near / far) >= wavelength_m / 8.0
            })
    }
}

/// The middle of a band (Hz).
pub(super) fn middle_hz(frequency_hz: &[f64]) -> f64 {
    0.5 * (frequency_hz.first().unwrap_or(&0.0) + frequency_hz.last().unwrap_or(&0.0))
}
