//! Imaging below the surface of the ground.

use acerra_imaging::ImagingError;
use acerra_imaging::refraction::{Ground, Layer, Relief, Surface};

use crate::scene::Ground as SceneGround;
use crate::scene::pixels::Pixels;

/// Largest number of nodes of a relief's lattice.
const MOST_NODES: f64 = 4e5;

/// Intervals of the lattice beyond the pixels and the antennas, for the cubic interpolation.
const MARGIN: f64 = 3.0;

/// A ground of one soil or of level layers, below a level surface or below the terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Underground {
    /// Height of a level surface (m).
    pub surface_z_m: f64,
    /// Whether the surface is uneven: the terrain of the scene, or the surface seen by the radar.
    pub is_uneven: bool,
    /// The uneven surface under antennas and pixels, once [`Underground::over`] has sampled it.
    pub relief: Option<Relief>,
    /// Whether the permittivity of the soil is found from the data; the layer's permittivity is then the
    /// start.
    pub is_open: bool,
    /// Layers from the top; the last has no end.
    pub layers: Vec<Layer>,
}

/// Least and greatest relative permittivity of a soil.
pub(crate) const PERMITTIVITIES: [f64; 2] = [1.0, 100.0];

impl Underground {
    /// One soil without losses below a level surface at zero.
    #[cfg(test)]
    pub(crate) fn of_soil(relative_permittivity: f64) -> Self {
        let soil = acerra_imaging::refraction::Soil {
            relative_permittivity,
            conductivity_s_m: 0.0,
        };
        Self {
            surface_z_m: 0.0,
            is_uneven: false,
            relief: None,
            is_open: false,
            layers: vec![Layer::below_all(soil)],
        }
    }

    /// This ground with the permittivity of every layer multiplied by one factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        for layer in &mut scaled.layers {
            let [least, most] = PERMITTIVITIES;
            let permittivity = factor * layer.soil.relative_permittivity;
            layer.soil.relative_permittivity = permittivity.clamp(least, most);
        }
        scaled
    }

    /// This ground of one soil with another permittivity.
    #[must_use]
    pub fn of_permittivity(&self, relative_permittivity: f64) -> Self {
        let mut found = self.clone();
        for layer in &mut found.layers {
            layer.soil.relative_permittivity = relative_permittivity;
        }
        found
    }

    /// Factors in a geometric series with the ratio `ratio`, including 1, by which all permittivities remain
    /// from 1 to 100.
    #[must_use]
    pub fn factors(&self, ratio: f64) -> Vec<f64> {
        let permittivities = (self.layers.iter()).map(|layer| layer.soil.relative_permittivity);
        let (least, most) = permittivities.fold((f64::INFINITY, 0.0_f64), |(least, most), p| {
            (least.min(p), most.max(p))
        });
        let steps = |span: f64| (span.ln() / ratio.ln() + 1e-9).floor() as i32;
        let [from, to] = PERMITTIVITIES;
        (-steps(least / from)..=steps(to / most))
            .map(|k| ratio.powi(k))
            .collect()
    }

    /// The ground for rays traced at the middle of a band.
    ///
    /// # Errors
    /// Invalid soils or layers.
    pub fn seen_at(&self, frequency_hz: &[f64]) -> Result<Ground, ImagingError> {
        let middle_hz = frequency_hz.iter().sum::<f64>() / frequency_hz.len().max(1) as f64;
        let level = Surface::Level {
            z_m: self.surface_z_m,
        };
        let surface = self.relief.clone().map_or(level, Surface::Relief);
        Ground::new(surface, &self.layers, middle_hz)
    }

    /// This ground with the terrain, if any, sampled under the pixels and the antennas. The lattice has the
    /// pixels' spacing, or a coarser spacing that limits the number of nodes.
    ///
    /// # Errors
    /// Heights that are not finite.
    pub fn over(
        &self,
        terrain: &SceneGround,
        pixels: &Pixels,
        position_m: &[[f64; 3]],
    ) -> Result<Self, ImagingError> {
        if !self.is_uneven {
            return Ok(self.clone());
        }
        let grid = &pixels.grid;
        let mut low = [grid.x0_m, grid.y0_m];
        let mut high = [
            grid.x_m(grid.nx.saturating_sub(1)),
            grid.y_m(grid.ny.saturating_sub(1)),
        ];
        for place in position_m {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let sides_m = [0, 1].map(|axis| high[axis] - low[axis]);
        let fewest_m = (sides_m[0] * sides_m[1] / MOST_NODES).sqrt();
        let step_m = (grid.pixel_m)
            .max(fewest_m)
            .max(sides_m[0].max(sides_m[1]) / MOST_NODES);
        let counts =
            sides_m.map(|side_m| (side_m / step_m).ceil() as usize + 1 + 2 * MARGIN as usize);
        let origin_m = low.map(|from_m| from_m - MARGIN * step_m);
        let heights_m = (0..counts[1]).flat_map(|row| {
            (0..counts[0]).map(move |column| {
                let at = |from_m: f64, k: usize| from_m + step_m * k as f64;
                terrain.below_m(at(origin_m[0], column), at(origin_m[1], row))
            })
        });
        let relief = Relief::new(origin_m, step_m, counts[0], heights_m.collect())?;
        Ok(Self {
            relief: Some(relief),
            ..self.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use acerra_imaging::refraction::Soil;
    use acerra_imaging::{PlaneGrid, SurfaceGrid};

    use super::*;

    #[test]
    fn a_relief_has_the_heights_of_the_terrain_under_pixels_and_antennas() {
        let grid = PlaneGrid::from_ranges([0.0, 2.0], [-0.5, 0.5], 0.0, 0.05).unwrap();
        let height_m = |x_m: f64| 0.03 * (3.0 * x_m).sin();
        let surface =
            SurfaceGrid::in_parallel(grid, |x_m, _| Ok::<_, ImagingError>(height_m(x_m))).unwrap();
        let terrain = SceneGround::surface(Arc::new(surface));
        let soil = Soil {
            relative_permittivity: 4.0,
            conductivity_s_m: 0.0,
        };
        let stated = Underground {
            surface_z_m: 9.0,
            is_uneven: true,
            relief: None,
            is_open: false,
            layers: vec![Layer {
                soil,
                thickness_m: f64::INFINITY,
            }],
        };
        let antennas = [[-0.4, 0.0, 1.0], [2.3, 0.0, 1.0]];
        let found = stated.over(&terrain, &grid.into(), &antennas).unwrap();
        let relief = found.relief.as_ref().unwrap();
        for x_m in [-0.4, 0.0, 0.33, 1.01, 2.0, 2.3] {
            let expected_m = terrain.below_m(x_m, 0.1);
            assert!(
                (relief.at([x_m, 0.1]).height_m - expected_m).abs() < 1e-4,
                "{x_m}"
            );
        }
        assert!(found.seen_at(&[1e9]).is_ok());
        let level = Underground {
            is_uneven: false,
            ..stated
        };
        assert_eq!(
            level.over(&terrain, &grid.into(), &antennas).unwrap(),
            level
        );
    }
}
