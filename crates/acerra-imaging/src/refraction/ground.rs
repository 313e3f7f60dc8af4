//! The ground that rays enter: its surface and soils.

use super::crossing::Stack;
use super::ray::{MAX_LAYERS, Ray};
use super::relief::{Relief, Search};
use super::soil::Soil;
use crate::checks::check_positive;
use crate::error::ImagingError;
use num_complex::Complex64;

/// Height above the surface below which an antenna is taken to touch it, m.
const LEAST_HEIGHT_M: f64 = 1e-3;

/// A layer of soil, parallel to a level surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Soil of the layer.
    pub soil: Soil,
    /// Thickness of the layer, m; infinite for the last layer.
    pub thickness_m: f64,
}

impl Layer {
    /// A last layer of infinite thickness.
    #[must_use]
    pub fn below_all(soil: Soil) -> Self {
        Self {
            soil,
            thickness_m: f64::INFINITY,
        }
    }
}

/// The surface of the ground.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// A level surface.
    Level {
        /// Height of the surface, m.
        z_m: f64,
    },
    /// An uneven surface.
    Relief(Relief),
}

impl Surface {
    /// Height at `[x, y]`, m.
    #[must_use]
    pub fn height_m(&self, [x_m, y_m]: [f64; 2]) -> f64 {
        match self {
            Self::Level { z_m } => *z_m,
            Self::Relief(relief) => relief.height_m([x_m, y_m]),
        }
    }

    /// Least and greatest height, m.
    #[must_use]
    pub fn span_m(&self) -> [f64; 2] {
        match self {
            Self::Level { z_m } => [*z_m; 2],
            Self::Relief(relief) => relief.span_m(),
        }
    }
}

/// A ground of one soil, or of level layers below a level surface.
///
/// Rays are traced with the real refractive indices at one frequency, the middle of the band. Since their
/// optical length is stationary, dispersion moves them to second order only; phases and absorption at every
/// frequency are those of the complex indices there, along these rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    surface: Surface,
    layers: Vec<Layer>,
    /// Refractive index of each layer at [`Ground::ray_frequency_hz`].
    index: Vec<f64>,
    ray_frequency_hz: f64,
}

impl Ground {
    /// A ground of `layers` from the top, whose rays are traced at `ray_frequency_hz`.
    ///
    /// # Errors
    /// No layer or more than [`MAX_LAYERS`], a layer without positive thickness, a last layer with a
    /// thickness, layers below an uneven surface, an invalid soil, a frequency or height that is not finite.
    pub fn new(
        surface: Surface,
        layers: &[Layer],
        ray_frequency_hz: f64,
    ) -> Result<Self, ImagingError> {
        check_positive("ray_frequency_hz", "above 0 Hz", ray_frequency_hz)?;
        let out_of_range = |what, expected, found| {
            Err(ImagingError::OutOfRange {
                what,
                expected,
                found,
            })
        };
        let Some((last, above)) = layers.split_last() else {
            return Err(ImagingError::Empty { what: "layers" });
        };
        if layers.len() > MAX_LAYERS {
            return out_of_range("number of layers", "at most 8", layers.len() as f64);
        }
        for layer in above {
            check_positive("thickness_m", "above 0 m", layer.thickness_m)?;
        }
        if last.thickness_m != f64::INFINITY {
            let expected = "infinite in the last layer";
            return out_of_range("thickness_m", expected, last.thickness_m);
        }
        match &surface {
            Surface::Level { z_m } if !z_m.is_finite() => {
                return out_of_range("z_m", "a finite height", *z_m);
            }
            Surface::Relief(_) if layers.len() > 1 => {
                let expected = "1 below an uneven surface";
                return out_of_range("number of layers", expected, layers.len() as f64);
            }
            _ => {}
        }
        for layer in layers {
            layer.soil.checked()?;
        }
        let index = |layer: &Layer| layer.soil.refractive_index(ray_frequency_hz).re;
        Ok(Self {
            index: layers.iter().map(index).collect(),
            surface,
            layers: layers.to_vec(),
            ray_frequency_hz,
        })
    }

    /// The surface of the ground.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The layers of soil, from the top.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Frequency at which rays are traced, Hz.
    #[must_use]
    pub fn ray_frequency_hz(&self) -> f64 {
        self.ray_frequency_hz
    }

    /// Height of a level surface, m; `None` for an uneven one.
    #[must_use]
    pub fn level_m(&self) -> Option<f64> {
        match self.surface {
            Surface::Level { z_m } => Some(z_m),
            Surface::Relief(_) => None,
        }
    }

    /// The search for the crossing of a ray to a point below the surface; `None` where the surface is level.
    pub(crate) fn crossings(&self, antenna_m: [f64; 3], point_m: [f64; 3]) -> Option<Search<'_>> {
        match &self.surface {
            Surface::Relief(relief) => Some(relief.search(self.index[0], antenna_m, point_m)),
            Surface::Level { .. } => None,
        }
    }

    /// Whether phases or amplitudes depend on frequency otherwise than by the optical length.
    #[must_use]
    pub fn is_lossy(&self) -> bool {
        self.layers.iter().any(|l| l.soil.conductivity_s_m > 0.0)
    }

    /// Largest refractive index of the layers.
    #[must_use]
    pub fn largest_index(&self) -> f64 {
        self.index.iter().copied().fold(1.0, f64::max)
    }

    /// Depth of a point below the surface, m; negative above it.
    #[must_use]
    pub fn depth_m(&self, point_m: [f64; 3]) -> f64 {
        self.surface.height_m([point_m[0], point_m[1]]) - point_m[2]
    }

    /// Refuses an antenna that is not above the surface.
    pub(crate) fn check_antenna(&self, antenna_m: [f64; 3]) -> Result<(), ImagingError> {
        let found = -self.depth_m(antenna_m);
        if found >= LEAST_HEIGHT_M {
            return Ok(());
        }
        Err(ImagingError::OutOfRange {
            what: "height of an antenna above the ground (m)",
            expected: "at least 0.001",
            found,
        })
    }

    /// The media that a vertical from `height_m` above the surface to `depth_m` below it crosses.
    pub(crate) fn stack(&self, height_m: f64, depth_m: f64) -> Stack {
        let mut stack = Stack {
            height_m,
            depth_m: [0.0; MAX_LAYERS],
            index: [1.0; MAX_LAYERS],
            layers: 0,
        };
        let mut left_m = depth_m;
        for (layer, index) in self.layers.iter().zip(&self.index) {
            let k = stack.layers;
            stack.depth_m[k] = left_m.min(layer.thickness_m);
            stack.index[k] = *index;
            stack.layers = k + 1;
            left_m -= layer.thickness_m;
            if left_m <= 0.0 {
                break;
            }
        }
        stack
    }

    /// The earliest ray from an antenna above the surface to a point above or below it.
    #[must_use]
    pub fn ray(&self, antenna_m: [f64; 3], point_m: [f64; 3]) -> Ray {
        let depth_m = self.depth_m(point_m);
        if depth_m.is_nan() || depth_m <= 0.0 {
            return Ray::straight(antenna_m, point_m);
        }
        match &self.surface {
            Surface::Level { z_m } => self.level_ray(*z_m, antenna_m, point_m),
            Surface::Relief(relief) => relief.ray(self.index[0], antenna_m, point_m),
        }
    }

    fn level_ray(&self, z_m: f64, antenna_m: [f64; 3], point_m: [f64; 3]) -> Ray {
        let height_m = (antenna_m[2] - z_m).max(LEAST_HEIGHT_M);
        let along = [point_m[0] - antenna_m[0], point_m[1] - antenna_m[1]];
        let distance_m = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let ray = self.stack(height_m, z_m - point_m[2]).ray(distance_m);
        let sine_per_m = ray.sine / distance_m.max(f64::MIN_POSITIVE);
        Ray {
            optical_m: ray.optical_m,
            soil_m: ray.soil_m,
            departure: [along[0] * sine_per_m, along[1] * sine_per_m, -ray.cosine],
            // The horizontal part is the same as in air, by Snell's law.
            gradient: [
                along[0] * sine_per_m,
                along[1] * sine_per_m,
                -ray.last_cosine_index,
            ],
            amplitude: ray.amplitude,
        }
    }

    /// Contribution of the lengths in the layers to the optical length at a frequency, complex, m: the
    /// dispersion, and with a negative imaginary part the absorption.
    #[must_use]
    pub fn dispersion_m(&self, frequency_hz: f64, soil_m: &[f64; MAX_LAYERS]) -> Complex64 {
        (self.layers.iter().zip(&self.index).zip(soil_m))
            .map(|((layer, n), length)| (layer.soil.refractive_index(frequency_hz) - n) * *length)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAND: Soil = Soil {
        relative_permittivity: 4.0,
        conductivity_s_m: 0.0,
    };

    #[test]
    fn rays_are_continuous_through_the_surface_and_through_layers() {
        let wet = Soil {
            relative_permittivity: 16.0,
            ..SAND
        };
        let top = Layer {
            soil: SAND,
            thickness_m: 0.3,
        };
        let layers = [top, Layer::below_all(wet)];
        let ground = Ground::new(Surface::Level { z_m: 1.0 }, &layers, 1e9).unwrap();
        let antenna = [0.2, -0.4, 3.0];
        for depth in [0.0, 0.3] {
            let at = |d: f64| ground.ray(antenna, [1.3, 0.5, 1.0 - depth - d]);
            let (above, below) = (at(-1e-9), at(1e-9));
            assert!((above.optical_m - below.optical_m).abs() < 1e-7);
        }
        assert_eq!(
            ground.ray(antenna, [1.0, 1.0, 1.0]).soil_m,
            [0.0; MAX_LAYERS]
        );
        let deep = ground.ray(antenna, [1.3, 0.5, 0.4]);
        assert!(deep.soil_m[0] > 0.3 && deep.soil_m[1] > 0.3 && deep.soil_m[2] == 0.0);
        assert!(ground.check_antenna([0.0, 0.0, 1.0]).is_err());
        assert!(ground.check_antenna(antenna).is_ok());
    }

    #[test]
    fn ground_that_is_none_is_refused() {
        let level = || Surface::Level { z_m: 0.0 };
        assert!(Ground::new(level(), &[], 1e9).is_err());
        let ends = Layer {
            soil: SAND,
            thickness_m: 1.0,
        };
        assert!(Ground::new(level(), &[ends], 1e9).is_err());
        assert!(Ground::new(level(), &[Layer::below_all(SAND); 2], 1e9).is_err());
        assert!(Ground::new(level(), &[Layer::below_all(SAND)], f64::NAN).is_err());
    }
}
