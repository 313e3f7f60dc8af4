//! A scene: layers of soil below a surface, buried cylinders, and the antennas' places.

use std::path::Path;

use anyhow::{Context, ensure};
use serde::Deserialize;

use super::fdtd::{CELL_M, Material};

/// Width of the domain, m.
const WIDTH_M: f64 = 2.4;
/// Depth of the domain below z = 0, m.
const DEPTH_M: f64 = 0.56;
/// Height of the domain above z = 0, m.
const HEIGHT_M: f64 = 1.04;
/// Cells from the transmitter to the receiver: 6 cm.
pub const RECEIVER_CELLS: usize = 15;
/// Relative permittivity of the buried plastic, without losses.
const PLASTIC: f64 = 2.5;

/// Content of a scene's file. Coordinates in metres: x along the flight, z upwards.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Layers from the top; the last goes on downwards.
    pub soil: Vec<Soil>,
    /// What is buried.
    pub targets: Vec<Target>,
    /// The surface through these points; level at z = 0 without them.
    #[serde(default)]
    pub surface_x_m: Vec<f64>,
    /// Its heights.
    #[serde(default)]
    pub surface_z_m: Vec<f64>,
    /// Of the transmitter in each trace.
    pub transmitter_x_m: Vec<f64>,
    /// Of the transmitter in each trace.
    pub transmitter_z_m: Vec<f64>,
}

/// A layer of soil.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soil {
    /// From z = 0 or the interface above; the last layer has none.
    pub thickness_m: Option<f64>,
    /// Real part.
    pub relative_permittivity: f64,
    /// At all frequencies.
    pub conductivity_s_m: f64,
}

/// A buried cylinder across the plane of the flight.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// `metal` or `plastic`.
    pub material: String,
    /// Of the axis.
    pub x_m: f64,
    /// Of the axis.
    pub z_m: f64,
    /// Of the cylinder.
    pub radius_m: f64,
}

impl Scene {
    /// Reads a scene's file.
    ///
    /// # Errors
    /// If the file cannot be read, or states no scene.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let scene: Self =
            serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        ensure!(!scene.soil.is_empty(), "{}: no soil", path.display());
        let pairs = [
            (scene.surface_x_m.len(), scene.surface_z_m.len()),
            (scene.transmitter_x_m.len(), scene.transmitter_z_m.len()),
        ];
        ensure!(
            pairs.iter().all(|(x, z)| x == z),
            "{}: other numbers of x than of z",
            path.display()
        );
        Ok(scene)
    }

    /// Names of the scenes of a folder, in order.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn names(folder: &Path) -> anyhow::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.extension().is_some_and(|e| e == "json") {
                names.extend(
                    path.file_stem()
                        .map(|stem| stem.to_string_lossy().into_owned()),
                );
            }
        }
        names.sort();
        Ok(names)
    }

    /// Height of the surface at x, m.
    #[must_use]
    pub fn surface_m(&self, x_m: f64) -> f64 {
        let (xs, zs) = (&self.surface_x_m, &self.surface_z_m);
        let Some(last) = xs.len().checked_sub(1) else {
            return 0.0;
        };
        let after = xs.partition_point(|x| *x <= x_m);
        if after == 0 || after > last {
            return zs[after.min(last)];
        }
        let share = (x_m - xs[after - 1]) / (xs[after] - xs[after - 1]);
        zs[after - 1] + share * (zs[after] - zs[after - 1])
    }

    /// Material of each cell.
    #[must_use]
    pub fn materials(&self) -> Material {
        let cells = |length_m: f64| (length_m / CELL_M).round() as usize + 1;
        let (columns, rows) = (cells(WIDTH_M), cells(DEPTH_M + HEIGHT_M));
        let mut material = Material::air(columns, rows);
        for row in 0..rows {
            let z_m = row as f64 * CELL_M - DEPTH_M;
            for column in 0..columns {
                let x_m = column as f64 * CELL_M;
                let below_m = self.surface_m(x_m) - z_m;
                let cell = &mut material.cells[row * columns + column];
                if below_m.abs() < CELL_M / 2.0 {
                    // The interface runs through the cell.
                    *cell = Some([(1.0 + self.soil[0].relative_permittivity) / 2.0, 0.0]);
                } else if below_m > 0.0 {
                    let soil = self.soil_at(z_m);
                    *cell = Some([soil.relative_permittivity, soil.conductivity_s_m]);
                }
                for target in &self.targets {
                    if (x_m - target.x_m).hypot(z_m - target.z_m) <= target.radius_m {
                        *cell = (target.material == "plastic").then_some([PLASTIC, 0.0]);
                    }
                }
            }
        }
        material
    }

    /// The layer at z: interfaces below the surface are level.
    fn soil_at(&self, z_m: f64) -> &Soil {
        let mut bottom_m = 0.0;
        for soil in &self.soil {
            bottom_m -= soil.thickness_m.unwrap_or(f64::INFINITY);
            if z_m >= bottom_m {
                return soil;
            }
        }
        &self.soil[self.soil.len() - 1]
    }

    /// Cells of the transmitter, column and row, in each trace.
    ///
    /// # Errors
    /// If one lies outside the domain.
    pub fn transmitter_cells(&self) -> anyhow::Result<Vec<[usize; 2]>> {
        let places = self.transmitter_x_m.iter().zip(&self.transmitter_z_m);
        let cell = |(x_m, z_m): (&f64, &f64)| -> anyhow::Result<[usize; 2]> {
            let inside = (0.1..WIDTH_M - 0.2).contains(x_m) && (0.0..HEIGHT_M - 0.06).contains(z_m);
            ensure!(inside, "transmitter at ({x_m}, {z_m}): outside the domain");
            Ok([x_m / CELL_M, (z_m + DEPTH_M) / CELL_M].map(|cells| cells.round() as usize))
        };
        places.map(cell).collect()
    }

    /// Places of transmitters and receivers, m.
    pub(super) fn antennas_m(&self) -> [Vec<[f64; 3]>; 2] {
        let apart_m = RECEIVER_CELLS as f64 * CELL_M;
        [0.0, apart_m].map(|ahead_m| {
            let places = self.transmitter_x_m.iter().zip(&self.transmitter_z_m);
            places
                .map(|(x_m, z_m)| [x_m + ahead_m, 0.0, *z_m])
                .collect()
        })
    }
}
