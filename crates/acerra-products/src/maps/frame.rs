//! Frame of the image: on the Earth, with a coordinate reference system; or a local frame.

use std::ops::Range;

use acerra_chain::Track;
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_maps::crs::MapCrs;
use acerra_maps::placement::{LocalGrid, Placement};
use anyhow::Context;

use crate::outcome::Outcome;

/// Frame of an image's pixels.
pub(super) struct MapFrame {
    /// The frame on the Earth and the system of coordinates of its maps.
    known: Option<(EnuFrame, MapCrs)>,
    /// Places of the pixels on the map, or in the local frame.
    pub placement: Placement,
    grid: LocalGrid,
}

/// An image on the Earth.
#[derive(Clone, Copy)]
pub(super) struct OnEarth<'a> {
    pub frame: &'a EnuFrame,
    pub grid: &'a LocalGrid,
}

impl MapFrame {
    pub fn of(outcome: &Outcome) -> anyhow::Result<Self> {
        let pixels = &outcome.focused.pixels;
        let plane = &pixels.grid;
        let grid = LocalGrid {
            x0_m: plane.x0_m,
            y0_m: plane.y0_m,
            z_m: pixels.middle_m(),
            pixel_m: plane.pixel_m,
            nx: plane.nx,
            ny: plane.ny,
        };
        let Some(frame) = outcome.prepared.first().positions.earth_frame() else {
            return Ok(Self {
                known: None,
                placement: Placement::local(&grid),
                grid,
            });
        };
        let middle_m = [0.5 * (grid.nx as f64), 0.5 * (grid.ny as f64)].map(|n| n * grid.pixel_m);
        let middle = [grid.x0_m + middle_m[0], grid.y0_m + middle_m[1], grid.z_m];
        let crs = match outcome.campaign.products.epsg {
            Some(code) => MapCrs::from_epsg(code),
            None => Ok(MapCrs::utm_about(&frame.geodetic_from_enu(middle))),
        }
        .context("[products] epsg")?;
        let placement = Placement::fit(&frame, &grid, &crs).context("[products] epsg")?;
        Ok(Self {
            known: Some((frame, crs)),
            placement,
            grid,
        })
    }

    pub fn crs(&self) -> Option<&MapCrs> {
        self.known.as_ref().map(|(_, crs)| crs)
    }

    pub fn earth(&self) -> Option<OnEarth<'_>> {
        self.known.as_ref().map(|(frame, _)| OnEarth {
            frame,
            grid: &self.grid,
        })
    }
}

impl OnEarth<'_> {
    /// The outer corners of the image: south-west, south-east, north-east, north-west.
    pub fn corners(&self) -> [Geodetic; 4] {
        let grid = self.grid;
        let half_m = 0.5 * grid.pixel_m;
        let west_m = grid.x0_m - half_m;
        let south_m = grid.y0_m - half_m;
        let east_m = west_m + grid.nx as f64 * grid.pixel_m;
        let north_m = south_m + grid.ny as f64 * grid.pixel_m;
        [
            [west_m, south_m],
            [east_m, south_m],
            [east_m, north_m],
            [west_m, north_m],
        ]
        .map(|[x_m, y_m]| self.frame.geodetic_from_enu([x_m, y_m, grid.z_m]))
    }

    /// The places of a track, line by line in order, `most` at most but for the ends of lines.
    pub fn lines(&self, outcome: &Outcome, track: &Track, most: usize) -> Vec<Vec<Geodetic>> {
        let aligned = &outcome.prepared.aligned;
        let places = &aligned.position_m[track.range.clone()];
        let step = places.len().div_ceil(most).max(1);
        let sampled = |line: Range<usize>| {
            let line = &places[line];
            let last = line.len().saturating_sub(1);
            let kept = (0..line.len()).filter(|k| k % step == 0 || *k == last);
            kept.map(|k| self.frame.geodetic_from_enu(line[k]))
                .collect()
        };
        let lines = aligned.lines(track.range.clone()).into_iter();
        lines.map(sampled).collect()
    }
}
