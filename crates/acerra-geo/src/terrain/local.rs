//! Terrain seen from a local frame.

use std::ops::Range;

use super::crs::Projection;
use super::raster::{Header, Window};
use super::{Crs, TerrainError};
use crate::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic, geodetic_from_ecef};
use crate::trajectory::Frame;

/// Distance of the lattice's nodes, m: between them the transformation from the frame to the raster departs
/// from bilinear by s²/8R, 8 µm.
const STEP_M: f64 = 20.0;
/// Most nodes on a side.
const MOST_NODES: usize = 1024;

/// The transformation from the frame to the raster on a lattice of nodes: column, row, and the frame's height
/// less the raster's.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    origin_m: [f64; 2],
    step_m: [f64; 2],
    count: [usize; 2],
    node: Vec<[f64; 3]>,
}

impl Lattice {
    pub fn new(
        header: &Header,
        crs: Crs,
        frame: &Frame,
        offset_m: f64,
        x_m: [f64; 2],
        y_m: [f64; 2],
    ) -> Result<Self, TerrainError> {
        let sides = [x_m, y_m];
        let count = sides.map(|[from, to]| {
            let nodes = ((to - from) / STEP_M).ceil();
            (nodes.clamp(1.0, (MOST_NODES - 1) as f64) as usize) + 1
        });
        // A rectangle without width has all its nodes on one line.
        let step_m = [0, 1].map(|a| (sides[a][1] - sides[a][0]) / (count[a] - 1) as f64);
        let mut lattice = Self {
            origin_m: [x_m[0], y_m[0]],
            step_m,
            count,
            node: Vec::with_capacity(count[0] * count[1]),
        };
        let projection = Projection::of(crs)?;
        let middle = header.placement.coordinates([
            0.5 * (header.columns - 1) as f64,
            0.5 * (header.rows - 1) as f64,
        ]);
        for j in 0..count[1] {
            for i in 0..count[0] {
                let x = x_m[0] + i as f64 * step_m[0];
                let y = y_m[0] + j as f64 * step_m[1];
                let (at, above) = match (&projection, frame) {
                    (None, _) => ([x, y], offset_m),
                    (Some(projection), Frame::Enu(frame)) => {
                        let (place, above) = on_earth(frame, offset_m, x, y);
                        (projection.coordinates(&place, middle[0])?, above)
                    }
                    (Some(_), Frame::Local) => {
                        return Err(TerrainError::Frame {
                            terrain: crs.to_string(),
                            frame: "at no known place on the Earth",
                            remedy: "give the trajectory an origin, or terrain in its own \
                                     coordinates",
                        });
                    }
                };
                let [column, row] = header.placement.place(at);
                lattice.node.push([column, row, above]);
            }
        }
        Ok(lattice)
    }

    /// Column, row and height difference at (x, y).
    fn at(&self, x_m: f64, y_m: f64) -> [f64; 3] {
        let place = |axis: usize, at: f64| {
            let from = at - self.origin_m[axis];
            let t = if self.step_m[axis] > 0.0 {
                from / self.step_m[axis]
            } else {
                0.0
            };
            let low = (t.max(0.0) as usize).min(self.count[axis] - 2);
            (low, t - low as f64)
        };
        let ((i, u), (j, v)) = (place(0, x_m), place(1, y_m));
        let node = |i: usize, j: usize| self.node[j * self.count[0] + i];
        std::array::from_fn(|k| {
            let low = node(i, j)[k] + u * (node(i + 1, j)[k] - node(i, j)[k]);
            let high = node(i, j + 1)[k] + u * (node(i + 1, j + 1)[k] - node(i, j + 1)[k]);
            low + v * (high - low)
        })
    }

    /// The cells that the rectangle needs.
    ///
    /// # Errors
    /// The corner that lies beyond the raster.
    pub fn cells(&self, header: &Header) -> Result<(Range<usize>, Range<usize>), TerrainError> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for (k, [column, row, _]) in self.node.iter().enumerate() {
            let x_m = self.origin_m[0] + (k % self.count[0]) as f64 * self.step_m[0];
            let y_m = self.origin_m[1] + (k / self.count[0]) as f64 * self.step_m[1];
            check_inside([*column, *row], [x_m, y_m], [header.columns, header.rows])?;
            for (axis, value) in [*column, *row].into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        let range = |axis: usize, count: usize| {
            let first = (low[axis].floor() - 1.0).max(0.0) as usize;
            let end = (high[axis].ceil() + 2.0).min(count as f64) as usize;
            first.min(count - 1)..end.max(first + 1).min(count)
        };
        Ok((range(0, header.columns), range(1, header.rows)))
    }
}

/// Half a millionth of a cell: a place on the edge may fall outside by rounding alone.
const EDGE_CELLS: f64 = 5e-7;

fn check_inside(
    [column, row]: [f64; 2],
    [x_m, y_m]: [f64; 2],
    [columns, rows]: [usize; 2],
) -> Result<(), TerrainError> {
    let inside =
        |at: f64, count: usize| (-EDGE_CELLS..=(count - 1) as f64 + EDGE_CELLS).contains(&at);
    if inside(column, columns) && inside(row, rows) {
        return Ok(());
    }
    Err(TerrainError::Outside {
        x_m,
        y_m,
        column,
        row,
        columns,
        rows,
    })
}

/// The place on the Earth below (x, y) of a frame, and the frame's height less the raster's there.
fn on_earth(frame: &EnuFrame, offset_m: f64, x: f64, y: f64) -> (Geodetic, f64) {
    // The frame's vertical is the ellipsoid's within 0.2 mrad a kilometre: the place is found at
    // the origin's height, and heights are carried over one to one.
    let place = geodetic_from_ecef(frame.ecef_from_enu([x, y, 0.0]));
    let mut level = place;
    level.height_m = frame.origin().height_m;
    let z = frame.enu_from_ecef(ecef_from_geodetic(&level))[2];
    (place, z - level.height_m + offset_m)
}

/// Heights of the ground in a local frame.
///
/// ```
/// use acerra_geo::terrain::{TerrainFile, TerrainOptions};
/// use acerra_geo::trajectory::Frame;
/// let grid = "0 0 1.0\n1 0 1.5\n0 1 2.0\n1 1 2.5\n"; // x, y, z in the frame's own metres
/// let file = TerrainFile::open(std::io::Cursor::new(grid), &TerrainOptions::default())?;
/// let terrain = file.in_frame(&Frame::Local, [0.0, 1.0], [0.0, 1.0])?;
/// assert_eq!(terrain.height_m(0.5, 0.5)?, 1.75);
/// # Ok::<(), acerra_geo::terrain::TerrainError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LocalTerrain {
    lattice: Lattice,
    window: Window,
    size: [usize; 2],
}

impl LocalTerrain {
    pub(super) fn new(lattice: Lattice, window: Window, size: [usize; 2]) -> Self {
        Self {
            lattice,
            window,
            size,
        }
    }

    /// Height above the frame's plane at (x, y), cubic between cells, with continuous slopes, m. Bilinear
    /// heights would have kinks along the cells' edges, and miss ground that curves by 0.1/m by 12 mm in
    /// cells of a metre.
    ///
    /// # Errors
    /// A place outside the raster, or without data.
    pub fn height_m(&self, x_m: f64, y_m: f64) -> Result<f64, TerrainError> {
        let [column, row, above] = self.lattice.at(x_m, y_m);
        check_inside([column, row], [x_m, y_m], self.size)?;
        match self.window.height_m(column, row) {
            Some(height_m) => Ok(height_m + above),
            None => Err(TerrainError::Hole {
                x_m,
                y_m,
                column,
                row,
            }),
        }
    }
}
