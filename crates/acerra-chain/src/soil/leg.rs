//! Vertical legs through the layers of a ground.

use acerra_imaging::refraction::Ground;

/// Contribution of a vertical leg into the ground: to the delay, and to the distance of the hyperbola's
/// centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertical {
    /// Optical length Σ n t (m).
    pub delay_m: f64,
    /// Σ t/n (m).
    pub curvature_m: f64,
    /// Refractive index where it ends.
    pub index: f64,
}

/// The vertical leg to a depth below the surface.
pub(crate) fn vertical(ground: &Ground, depth_m: f64) -> Vertical {
    let mut leg = Vertical {
        delay_m: 0.0,
        curvature_m: 0.0,
        index: 1.0,
    };
    let mut left_m = depth_m;
    for layer in ground.layers() {
        let index = layer.soil.refractive_index(ground.ray_frequency_hz()).re;
        let within_m = left_m.min(layer.thickness_m);
        leg.delay_m += index * within_m;
        leg.curvature_m += within_m / index;
        leg.index = index;
        left_m -= within_m;
        if left_m <= 0.0 {
            break;
        }
    }
    leg
}

/// Depth below the surface at a delay straight down (m).
pub(crate) fn depth_at(ground: &Ground, delay_m: f64) -> f64 {
    let (mut left_m, mut depth_m) = (delay_m, 0.0);
    for layer in ground.layers() {
        let index = layer.soil.refractive_index(ground.ray_frequency_hz()).re;
        let within_m = (left_m / index).min(layer.thickness_m);
        depth_m += within_m;
        left_m -= index * within_m;
        if left_m <= 0.0 {
            break;
        }
    }
    depth_m
}

#[cfg(test)]
mod tests {
    use acerra_imaging::refraction::{Layer, Soil, Surface};

    use super::*;

    #[test]
    fn depths_and_delays_of_layers_are_inverse() {
        let soil = |relative_permittivity| Soil {
            relative_permittivity,
            conductivity_s_m: 0.0,
        };
        let top = Layer {
            soil: soil(4.0),
            thickness_m: 0.1,
        };
        let layers = [top, Layer::below_all(soil(9.0))];
        let ground = Ground::new(Surface::Level { z_m: 0.0 }, &layers, 1e9).unwrap();
        let leg = vertical(&ground, 0.3);
        assert!((leg.delay_m - (0.2 + 0.6)).abs() < 1e-12);
        assert!((leg.curvature_m - (0.05 + 0.2 / 3.0)).abs() < 1e-12);
        assert_eq!(leg.index, 3.0);
        assert!((depth_at(&ground, leg.delay_m) - 0.3).abs() < 1e-12);
    }
}
