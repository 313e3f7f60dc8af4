//! Modelling of the echoes of an image.

use acerra_chain::Control;
use acerra_imaging::{
    Complex32, Complex64, Forward, PulseArrays, Pulses, SurfaceGrid, TiltedGrid, reference,
};
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::arrays::{matrix, values};
use crate::errors::Failure;
use crate::grid::{Grid, Plane, Surface, Tilted, Volume};
use crate::pulses::{Antennas, Settings};
use crate::work;

/// Adds modelling to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(forward, module)?)
}

/// The spectra `[pulses, frequencies]` that an image of `grid` would have given.
#[pyfunction]
fn forward<'py>(
    py: Python<'py>,
    grid: Grid,
    image: PyReadonlyArray1<'py, Complex32>,
    antennas: Antennas<'py>,
    settings: Settings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let echoes = Modelled {
        position_m: antennas.position_m()?,
        frequency_hz: antennas.frequency_hz()?,
        weight: antennas.weight()?,
        settings,
    };
    let image = values(&image)?;
    let spectra = work::run(py, progress.as_ref(), |control| {
        echoes.of(&grid, image, control)
    })?;
    matrix(py, spectra, echoes.frequency_hz.len())
}

/// Where and at which frequencies echoes are modelled.
struct Modelled<'a> {
    position_m: &'a [[f64; 3]],
    frequency_hz: &'a [f64],
    weight: &'a [f64],
    settings: Settings,
}

impl Modelled<'_> {
    fn of(
        &self,
        grid: &Grid,
        image: &[Complex32],
        control: &Control<'_>,
    ) -> Result<Vec<Complex64>, Failure> {
        let none = vec![Complex64::ZERO; self.position_m.len() * self.frequency_hz.len()];
        let pulses = Pulses::new(PulseArrays {
            position_m: self.position_m,
            frequency_hz: self.frequency_hz,
            spectrum: &none,
            weight: self.weight,
            light_speed_m_s: self.settings.light_speed_m_s,
        })?;
        let control = control.operation();
        let plan = &self.settings.plan;
        let of_plane = |plane: TiltedGrid, image: &[Complex32]| {
            let operator = Forward::with_control(pulses, plane, plan, control)?;
            let mut spectra = none.clone();
            operator.run(image, &mut spectra, control)?;
            Ok::<_, Failure>(spectra)
        };
        match grid {
            Grid::Plane(Plane(plane)) => of_plane((*plane).into(), image),
            Grid::Tilted(Tilted(plane)) => of_plane(*plane, image),
            Grid::Volume(Volume(volume)) => {
                let expected = volume.nz * volume.base.len();
                if image.len() != expected {
                    let found = image.len();
                    return Err(Failure::imaging(format!(
                        "image: expected {expected} voxels, found {found}"
                    )));
                }
                let mut sum = none.clone();
                for (k, slice) in image.chunks(volume.base.len()).enumerate() {
                    let spectra = of_plane(volume.slice(k).into(), slice)?;
                    sum.iter_mut().zip(spectra).for_each(|(s, v)| *s += v);
                }
                Ok(sum)
            }
            Grid::Surface(Surface(surface)) => self.of_surface(surface, image),
        }
    }

    /// Uneven ground by the double-precision sum: the engines model planes.
    fn of_surface(
        &self,
        surface: &SurfaceGrid,
        image: &[Complex32],
    ) -> Result<Vec<Complex64>, Failure> {
        if image.len() != surface.len() {
            let (expected, found) = (surface.len(), image.len());
            return Err(Failure::imaging(format!(
                "image: expected {expected} pixels, found {found}"
            )));
        }
        let scatterers: Vec<_> = image
            .iter()
            .enumerate()
            .filter(|(_, v)| **v != Complex32::ZERO)
            .map(|(k, v)| reference::Scatterer {
                position_m: surface.point_m(k),
                reflectivity: Complex64::new(v.re.into(), v.im.into()),
            })
            .collect();
        let mut spectra = reference::forward(
            self.position_m,
            self.frequency_hz,
            &scatterers,
            self.settings.light_speed_m_s,
            self.settings.plan.spreading,
        )?;
        let rows = spectra.chunks_mut(self.frequency_hz.len());
        for (row, weight) in rows.zip(self.weight) {
            row.iter_mut().for_each(|v| *v *= *weight);
        }
        Ok(spectra)
    }
}
