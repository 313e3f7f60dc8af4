//! Map coordinates of the pixels of a local east-north grid.

use acerra_geo::geodesy::EnuFrame;

use crate::crs::MapCrs;
use crate::error::MapError;

/// Square pixels at one height of a local frame: columns eastwards, rows northwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalGrid {
    /// East of the centres of the first column (m).
    pub x0_m: f64,
    /// North of the centres of the first row (m).
    pub y0_m: f64,
    /// Height (m).
    pub z_m: f64,
    /// Side of a pixel (m).
    pub pixel_m: f64,
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
}

impl LocalGrid {
    /// East and north (m) of a place counted in pixels from the centre of the first.
    fn place_m(&self, column: f64, row: f64) -> [f64; 2] {
        [
            self.x0_m + column * self.pixel_m,
            self.y0_m + row * self.pixel_m,
        ]
    }
}

/// Map coordinates of pixels: of the centre of the first column's northernmost pixel, and the steps to
/// the next column and to the next row southwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Map coordinates of the centre of the north-western pixel.
    pub first: [f64; 2],
    /// Step to the next column.
    pub column: [f64; 2],
    /// Step to the next row, southwards.
    pub row: [f64; 2],
    /// Largest distance of a pixel from its exact place (m).
    pub residual_m: f64,
}

/// Largest distance of a pixel from its exact place, in pixels.
const MOST_RESIDUAL_PIXELS: f64 = 0.5;

impl Placement {
    /// The straight grid on the map that fits best to a grid in a local frame (least squares over the
    /// corners, the middles of the sides and the centre). The map is turned against the local frame by
    /// the meridian convergence.
    ///
    /// # Errors
    /// A place outside the system, pixels that no straight grid places to half a pixel.
    pub fn fit(frame: &EnuFrame, grid: &LocalGrid, crs: &MapCrs) -> Result<Self, MapError> {
        let last = [grid.nx.max(1) - 1, grid.ny.max(1) - 1].map(|n| n as f64);
        let middle = last.map(|n| 0.5 * n);
        // Coordinates about the middle, so that the normal equations are diagonal.
        let half = last.map(|n| (0.5 * n).max(0.5));
        let exact = |u: f64, v: f64| {
            let [x_m, y_m] = grid.place_m(middle[0] + u * half[0], middle[1] + v * half[1]);
            crs.map_from_geodetic(&frame.geodetic_from_enu([x_m, y_m, grid.z_m]))
        };
        const NODES: [f64; 3] = [-1.0, 0.0, 1.0];
        let mut places = Vec::new();
        for u in NODES {
            for v in NODES {
                places.push((u, v, exact(u, v)?));
            }
        }
        let mean = |weight: fn(f64, f64) -> f64, k: usize| {
            let power: f64 = places.iter().map(|(u, v, _)| weight(*u, *v).powi(2)).sum();
            let sum: f64 = places.iter().map(|(u, v, p)| weight(*u, *v) * p[k]).sum();
            sum / power
        };
        let of = |weight: fn(f64, f64) -> f64| [mean(weight, 0), mean(weight, 1)];
        let (centre, east, north) = (of(|_, _| 1.0), of(|u, _| u), of(|_, v| v));
        let column = [0, 1].map(|k| east[k] / half[0]);
        let north_row = [0, 1].map(|k| north[k] / half[1]);
        let first = [0, 1].map(|k| centre[k] - middle[0] * column[k] + middle[1] * north_row[k]);

        // Metres per unit of the map, from the pixels themselves.
        let unit_m = [column, north_row].map(|step| step[0].hypot(step[1]) / grid.pixel_m);
        let unit_m = 1.0 / unit_m[0].min(unit_m[1]);
        let off = |(u, v, p): &(f64, f64, [f64; 2])| {
            let fitted = [0, 1].map(|k| centre[k] + u * east[k] + v * north[k]);
            (fitted[0] - p[0]).hypot(fitted[1] - p[1]) * unit_m
        };
        let residual_m = places.iter().map(off).fold(0.0, f64::max);
        if residual_m > MOST_RESIDUAL_PIXELS * grid.pixel_m {
            return Err(MapError::NotStraight {
                code: crs.epsg().into(),
                pixel_m: grid.pixel_m,
                residual_m,
            });
        }
        Ok(Self {
            first,
            column,
            row: north_row.map(|step| -step),
            residual_m,
        })
    }

    /// In the local frame itself, where that has no place on the Earth.
    #[must_use]
    pub fn local(grid: &LocalGrid) -> Self {
        Self {
            first: grid.place_m(0.0, grid.ny.max(1) as f64 - 1.0),
            column: [grid.pixel_m, 0.0],
            row: [0.0, -grid.pixel_m],
            residual_m: 0.0,
        }
    }

    /// Map coordinates at a column and a row counted from the north-western pixel's centre.
    #[must_use]
    pub fn at(&self, column: f64, row: f64) -> [f64; 2] {
        [0, 1].map(|k| self.first[k] + column * self.column[k] + row * self.row[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::Geodetic;

    fn frame() -> EnuFrame {
        EnuFrame::new(Geodetic::from_degrees(40.9596, 14.3696, 75.0))
    }

    const GRID: LocalGrid = LocalGrid {
        x0_m: -20.0,
        y0_m: -9.0,
        z_m: -1.5,
        pixel_m: 0.01,
        nx: 5001,
        ny: 1801,
    };

    #[test]
    fn corners_stand_where_the_earth_puts_them() {
        let crs = MapCrs::utm_about(frame().origin());
        let placement = Placement::fit(&frame(), &GRID, &crs).unwrap();
        assert!(placement.residual_m < 1e-4, "{placement:?}");
        for (column, row, x_m, y_m) in [
            (0.0, 0.0, -20.0, 9.0),
            (5000.0, 0.0, 30.0, 9.0),
            (0.0, 1800.0, -20.0, -9.0),
            (5000.0, 1800.0, 30.0, -9.0),
        ] {
            let place = frame().geodetic_from_enu([x_m, y_m, -1.5]);
            let exact = crs.map_from_geodetic(&place).unwrap();
            let found = placement.at(column, row);
            let off_m = (found[0] - exact[0]).hypot(found[1] - exact[1]);
            assert!(off_m < 1e-4, "{off_m}");
        }
        // The meridian convergence there, (λ − λ₀) sin φ: west of the zone's meridian true north leans
        // to the east.
        let convergence = (placement.column[1] / placement.column[0]).atan();
        let expected = (14.3696_f64 - 15.0).to_radians() * 40.9596_f64.to_radians().sin();
        assert!(
            (convergence - expected).abs() < 1e-5,
            "{convergence} {expected}"
        );
    }

    #[test]
    fn a_grid_that_bends_more_than_its_pixels_is_refused() {
        let wide = LocalGrid {
            nx: 400_001,
            ny: 400_001,
            ..GRID
        };
        let crs = MapCrs::from_epsg(4326).unwrap();
        let error = Placement::fit(&frame(), &wide, &crs).unwrap_err();
        assert!(matches!(error, MapError::NotStraight { .. }), "{error}");
        assert!(Placement::fit(&frame(), &GRID, &crs).is_ok());
    }

    #[test]
    fn a_local_frame_keeps_its_metres() {
        let placement = Placement::local(&GRID);
        assert_eq!(placement.at(0.0, 0.0), [-20.0, 9.0]);
        let south_east = placement.at(5000.0, 1800.0);
        assert!((south_east[0] - 30.0).abs() < 1e-9 && (south_east[1] + 9.0).abs() < 1e-9);
    }
}
