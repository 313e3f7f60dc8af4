//! Pixels: a plane, a tilted plane, a surface, a volume.

use std::ops::Range;
use std::sync::Arc;

use acerra_chain::Pixels;
use acerra_imaging::{PlaneGrid, SurfaceGrid, TiltedGrid, VolumeGrid};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{matrix, shape2};
use crate::errors::Failure;

/// A horizontal rectangle of square pixels.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Plane(pub PlaneGrid);

#[pymethods]
impl Plane {
    #[new]
    #[pyo3(signature = (x_m, y_m, *, z_m = 0.0, pixel_m))]
    fn new(x_m: [f64; 2], y_m: [f64; 2], z_m: f64, pixel_m: f64) -> Result<Self, Failure> {
        Ok(Self(PlaneGrid::from_ranges(x_m, y_m, z_m, pixel_m)?))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, &self.0)
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, &self.0)
    }

    /// Height of the plane, m.
    #[getter]
    fn z_m(&self) -> f64 {
        self.0.z_m
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.pixel_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.ny, self.0.nx)
    }

    /// What `pickle` makes it from.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("z_m", g.z_m)?;
        keywords.set_item("pixel_m", g.pixel_m)?;
        Ok((ranges(g).into_pyobject(py)?.into_any(), keywords))
    }

    fn __repr__(&self) -> String {
        let g = &self.0;
        format!(
            "Plane({} × {} pixels of {} m from ({}, {}) m at z = {} m)",
            g.ny, g.nx, g.pixel_m, g.x0_m, g.y0_m, g.z_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

/// A parallelogram of pixels in space.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Tilted(pub TiltedGrid);

#[pymethods]
impl Tilted {
    #[new]
    #[pyo3(signature = (origin_m, u_m, v_m, *, shape))]
    fn new(
        origin_m: [f64; 3],
        u_m: [f64; 3],
        v_m: [f64; 3],
        shape: (usize, usize),
    ) -> Result<Self, Failure> {
        let (rows, columns) = shape;
        Ok(Self(TiltedGrid::new(origin_m, u_m, v_m, columns, rows)?))
    }

    /// Centre of pixel (0, 0), m.
    #[getter]
    fn origin_m(&self) -> [f64; 3] {
        self.0.origin_m
    }

    /// Step from one column to the next, m.
    #[getter]
    fn u_m(&self) -> [f64; 3] {
        self.0.u_m
    }

    /// Step from one row to the next, m.
    #[getter]
    fn v_m(&self) -> [f64; 3] {
        self.0.v_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.rows, self.0.columns)
    }

    /// What `pickle` makes it from.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("shape", (g.rows, g.columns))?;
        Ok((
            (g.origin_m, g.u_m, g.v_m).into_pyobject(py)?.into_any(),
            keywords,
        ))
    }

    fn __repr__(&self) -> String {
        let g = &self.0;
        format!(
            "Tilted({} × {} pixels from {:?} m, columns by {:?} m, rows by {:?} m)",
            g.rows, g.columns, g.origin_m, g.u_m, g.v_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

/// Pixels on uneven ground over a horizontal rectangle.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Surface(pub Arc<SurfaceGrid>);

#[pymethods]
impl Surface {
    #[new]
    #[pyo3(signature = (x_m, y_m, heights_m, *, pixel_m))]
    fn new(
        x_m: [f64; 2],
        y_m: [f64; 2],
        heights_m: PyReadonlyArray2<'_, f64>,
        pixel_m: f64,
    ) -> PyResult<Self> {
        let base = PlaneGrid::from_ranges(x_m, y_m, 0.0, pixel_m).map_err(Failure::from)?;
        let found = shape2(&heights_m);
        if found != [base.ny, base.nx] {
            return Err(PyValueError::new_err(format!(
                "heights_m: expected shape [{}, {}], found {found:?}",
                base.ny, base.nx
            )));
        }
        let surface = SurfaceGrid::new(base, heights_m.as_slice()?).map_err(Failure::from)?;
        Ok(Self(Arc::new(surface)))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, self.0.base())
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, self.0.base())
    }

    /// Heights of the pixels `[rows, columns]`, m.
    #[getter]
    fn z_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let heights = (0..self.0.len()).map(|k| self.0.z_m(k)).collect();
        matrix(py, heights, self.0.base().nx)
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.base().pixel_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.base().ny, self.0.base().nx)
    }

    /// What `pickle` makes it from.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let keywords = PyDict::new(py);
        keywords.set_item("pixel_m", self.0.base().pixel_m)?;
        let (x_m, y_m) = ranges(self.0.base());
        Ok((
            (x_m, y_m, self.z_m(py)?).into_pyobject(py)?.into_any(),
            keywords,
        ))
    }

    fn __repr__(&self) -> String {
        let (g, [low, high]) = (self.0.base(), self.0.span_m());
        format!(
            "Surface({} × {} pixels of {} m from ({}, {}) m, z = {low} to {high} m)",
            g.ny, g.nx, g.pixel_m, g.x0_m, g.y0_m
        )
    }
}

/// A plane repeated at even heights.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Volume(pub VolumeGrid);

#[pymethods]
impl Volume {
    #[new]
    #[pyo3(signature = (x_m, y_m, z_m, *, pixel_m, step_m = None))]
    fn new(
        x_m: [f64; 2],
        y_m: [f64; 2],
        z_m: [f64; 2],
        pixel_m: f64,
        step_m: Option<f64>,
    ) -> PyResult<Self> {
        let step_m = step_m.unwrap_or(pixel_m);
        let base = PlaneGrid::from_ranges(x_m, y_m, z_m[0], pixel_m).map_err(Failure::from)?;
        let steps = (z_m[1] - z_m[0]) / step_m;
        if !(0.0..1e6).contains(&steps) {
            return Err(PyValueError::new_err(format!(
                "z_m: expected a range upwards of at most a million slices, found {z_m:?} m by {step_m} m"
            )));
        }
        // The end is kept where it falls on a slice, as the ends of columns and rows are.
        let slices = (steps + 1e-6).floor() as usize + 1;
        Ok(Self(
            VolumeGrid::new(base, step_m, slices).map_err(Failure::from)?,
        ))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, &self.0.base)
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, &self.0.base)
    }

    /// Heights of the slices, m.
    #[getter]
    fn z_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..self.0.nz).map(|k| self.0.slice(k).z_m))
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.base.pixel_m
    }

    /// Slices, rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        (self.0.nz, self.0.base.ny, self.0.base.nx)
    }

    /// The plane of slice `index`.
    fn slice(&self, index: usize) -> PyResult<Plane> {
        if index >= self.0.nz {
            return Err(PyValueError::new_err(format!(
                "slice: expected 0 to {}, found {index}",
                self.0.nz - 1
            )));
        }
        Ok(Plane(self.0.slice(index)))
    }

    /// What `pickle` makes it from.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("pixel_m", g.base.pixel_m)?;
        keywords.set_item("step_m", g.step_m)?;
        let (x_m, y_m) = ranges(&g.base);
        let z_m = [g.base.z_m, g.slice(g.nz - 1).z_m];
        Ok(((x_m, y_m, z_m).into_pyobject(py)?.into_any(), keywords))
    }

    fn __repr__(&self) -> String {
        let (g, v) = (&self.0.base, &self.0);
        format!(
            "Volume({} × {} × {} voxels of {} m, slices by {} m, from ({}, {}, {}) m)",
            v.nz, g.ny, g.nx, g.pixel_m, v.step_m, g.x0_m, g.y0_m, g.z_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

/// Any of them, as an argument.
#[derive(FromPyObject)]
pub enum Grid {
    /// A horizontal plane.
    Plane(Plane),
    /// A tilted plane.
    Tilted(Tilted),
    /// Uneven ground.
    Surface(Surface),
    /// A volume.
    Volume(Volume),
}

impl Grid {
    /// Slices, where there are several, rows and columns.
    pub fn shape(&self) -> Vec<usize> {
        match self {
            Self::Plane(Plane(g)) => vec![g.ny, g.nx],
            Self::Tilted(Tilted(g)) => vec![g.rows, g.columns],
            Self::Surface(Surface(g)) => vec![g.base().ny, g.base().nx],
            Self::Volume(Volume(g)) => vec![g.nz, g.base.ny, g.base.nx],
        }
    }

    /// Number of pixels or voxels.
    pub fn points(&self) -> u64 {
        self.shape().iter().map(|n| *n as u64).product()
    }

    /// The pixels as the chain takes them; it images no tilted planes.
    pub fn pixels(self) -> Result<Pixels, Failure> {
        match self {
            Self::Plane(plane) => Ok(plane.0.into()),
            Self::Surface(surface) => Ok(Pixels::surface(surface.0)),
            Self::Volume(volume) => Ok(volume.0.into()),
            Self::Tilted(_) => Err(Failure::imaging(
                "grid: expected a Plane, Surface or Volume, found a Tilted plane; image it with \
                 acerra.adjoint",
            )),
        }
    }
}

/// The part of a grid from index `start` to before `stop`, in the order of its shape.
#[pyfunction]
pub fn part_of<'py>(
    py: Python<'py>,
    grid: Grid,
    start: Vec<usize>,
    stop: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = grid.shape();
    let is_within = start.len() == shape.len()
        && stop.len() == shape.len()
        && (0..shape.len()).all(|axis| start[axis] < stop[axis] && stop[axis] <= shape[axis]);
    if !is_within {
        return Err(PyValueError::new_err(format!(
            "part: expected a part of shape {shape:?}, found {start:?} to {stop:?}"
        )));
    }
    let axes = shape.len();
    let [rows, columns] = [axes - 2, axes - 1].map(|axis| start[axis]..stop[axis]);
    Ok(match grid {
        Grid::Plane(Plane(g)) => Bound::new(py, Plane(rectangle(&g, &rows, &columns)?))?.into_any(),
        Grid::Volume(Volume(g)) => {
            let base = rectangle(&g.slice(start[0]), &rows, &columns)?;
            let part = VolumeGrid::new(base, g.step_m, stop[0] - start[0]);
            Bound::new(py, Volume(part.map_err(Failure::from)?))?.into_any()
        }
        Grid::Surface(Surface(g)) => {
            let base = rectangle(g.base(), &rows, &columns)?;
            let nx = g.base().nx;
            let heights: Vec<f64> = rows
                .flat_map(|j| columns.clone().map(move |i| j * nx + i))
                .map(|k| g.z_m(k))
                .collect();
            let part = SurfaceGrid::new(base, &heights).map_err(Failure::from)?;
            Bound::new(py, Surface(Arc::new(part)))?.into_any()
        }
        Grid::Tilted(Tilted(g)) => {
            let origin_m = g.point_m(columns.start as f64, rows.start as f64);
            let part = TiltedGrid::new(origin_m, g.u_m, g.v_m, columns.len(), rows.len());
            Bound::new(py, Tilted(part.map_err(Failure::from)?))?.into_any()
        }
    })
}

/// Some rows and columns of a plane.
fn rectangle(
    grid: &PlaneGrid,
    rows: &Range<usize>,
    columns: &Range<usize>,
) -> Result<PlaneGrid, Failure> {
    let origin_m = [grid.x_m(columns.start), grid.y_m(rows.start), grid.z_m];
    Ok(PlaneGrid::new(
        origin_m,
        grid.pixel_m,
        [columns.len(), rows.len()],
    )?)
}

/// The pixels of an image of the chain, as the grid that Python knows.
pub fn grid_of<'py>(py: Python<'py>, pixels: &Pixels) -> PyResult<Bound<'py, PyAny>> {
    Ok(match (&pixels.volume, &pixels.surface) {
        (Some(volume), _) => Bound::new(py, Volume(*volume))?.into_any(),
        (None, Some(surface)) => Bound::new(py, Surface(Arc::clone(surface)))?.into_any(),
        (None, None) => Bound::new(py, Plane(pixels.grid))?.into_any(),
    })
}

/// Positional and named arguments of a constructor.
type NewArguments<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

/// First and last centre of the columns and of the rows (m).
fn ranges(grid: &PlaneGrid) -> ([f64; 2], [f64; 2]) {
    (
        [grid.x0_m, grid.x_m(grid.nx - 1)],
        [grid.y0_m, grid.y_m(grid.ny - 1)],
    )
}

fn columns<'py>(py: Python<'py>, grid: &PlaneGrid) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, (0..grid.nx).map(|i| grid.x_m(i)))
}

fn rows<'py>(py: Python<'py>, grid: &PlaneGrid) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, (0..grid.ny).map(|j| grid.y_m(j)))
}
