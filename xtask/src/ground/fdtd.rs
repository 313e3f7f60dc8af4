//! Maxwell's equations in a plane, electric field across it (TM), by Yee's scheme of second order with convolutional
//! perfectly matched layers around (Roden & Gedney, Microwave Opt. Technol. Lett. 27 (2000) 334).

use std::f64::consts::PI;

/// Side of a cell, m: a tenth of the wavelength at 2.5 GHz in soil of permittivity 9.
pub const CELL_M: f64 = 0.004;
/// Steps from one sample that is kept to the next: 75 ps.
pub const STEPS_PER_SAMPLE: usize = 8;
/// Cells of the absorbing layers.
const LAYER: usize = 12;
/// Middle frequency of the current, a Ricker pulse, Hz.
const PULSE_HZ: f64 = 1.3e9;
const LIGHT_M_S: f64 = 299_792_458.0;
const VACUUM_H_M: f64 = 4e-7 * PI;
const VACUUM_F_M: f64 = 1.0 / (VACUUM_H_M * LIGHT_M_S * LIGHT_M_S);

/// A step of time, s: the longest stable one.
#[must_use]
pub fn step_s() -> f64 {
    CELL_M / LIGHT_M_S / f64::sqrt(2.0)
}

/// Time of the current's maximum, s: the fast time at which range is zero.
#[must_use]
pub fn pulse_s() -> f64 {
    f64::sqrt(2.0) / PULSE_HZ
}

/// Materials of the cells, row by row from the lowest.
#[derive(Clone, Debug)]
pub struct Material {
    /// Cells along x.
    pub columns: usize,
    /// Cells along z.
    pub rows: usize,
    /// Relative permittivity and conductivity (S/m); none: metal.
    pub cells: Vec<Option<[f64; 2]>>,
}

impl Material {
    /// Nothing but air.
    #[must_use]
    pub fn air(columns: usize, rows: usize) -> Self {
        Self {
            columns,
            rows,
            cells: vec![Some([1.0, 0.0]); columns * rows],
        }
    }
}

/// Coefficients of an absorbing layer along an axis: memory and gain at each cell, none between the layers.
struct Layer {
    at_cells: Vec<[f32; 2]>,
    between_cells: Vec<[f32; 2]>,
}

impl Layer {
    fn new(cells: usize) -> Self {
        let at = |place: f64| {
            let edge = LAYER as f64;
            let depth = ((edge - place).max(place - (cells as f64 - 1.0 - edge)) / edge).min(1.0);
            if depth <= 0.0 {
                return [0.0; 2];
            }
            // Graded by the cube; 2: a permittivity between those of air and soil.
            let conductivity = 0.8 * 4.0 / (377.0 * CELL_M * f64::sqrt(2.0)) * depth.powi(3);
            let shift = 0.05 * (1.0 - depth);
            let memory = (-(conductivity + shift) / VACUUM_F_M * step_s()).exp();
            [
                memory,
                conductivity / (conductivity + shift) * (memory - 1.0),
            ]
            .map(|v| v as f32)
        };
        Self {
            at_cells: (0..cells).map(|k| at(k as f64)).collect(),
            between_cells: (0..cells).map(|k| at(k as f64 + 0.5)).collect(),
        }
    }
}

/// Fields of a domain and their update coefficients.
pub struct Fields {
    columns: usize,
    rows: usize,
    /// For the electric field: the factor of its old value, and that of the magnetic field's curl.
    keep: Vec<f32>,
    gain: Vec<f32>,
    along: Layer,
    up: Layer,
    electric: Vec<f32>,
    /// Magnetic field along x and along z, and the layers' memories of all derivatives.
    magnetic: [Vec<f32>; 2],
    electric_memory: [Vec<f32>; 2],
    magnetic_memory: [Vec<f32>; 2],
}

impl Fields {
    /// Empty fields in `material`.
    #[must_use]
    pub fn new(material: &Material) -> Self {
        let (columns, rows) = (material.columns, material.rows);
        let factors = material.cells.iter().map(|cell| {
            cell.map_or([0.0; 2], |[permittivity, conductivity_s_m]| {
                let farad_m = VACUUM_F_M * permittivity;
                let loss = conductivity_s_m * step_s() / (2.0 * farad_m);
                [
                    (1.0 - loss) / (1.0 + loss),
                    step_s() / farad_m / (1.0 + loss) / CELL_M,
                ]
                .map(|v| v as f32)
            })
        });
        let (keep, gain) = factors.map(|[keep, gain]| (keep, gain)).unzip();
        let empty = || vec![0.0; columns * rows];
        Self {
            columns,
            rows,
            keep,
            gain,
            along: Layer::new(columns),
            up: Layer::new(rows),
            electric: empty(),
            magnetic: [empty(), empty()],
            electric_memory: [empty(), empty()],
            magnetic_memory: [empty(), empty()],
        }
    }

    /// The electric field at the cell `receiver` (column, row) by a line current in the cell `transmitter`, V/m, one
    /// sample every [`STEPS_PER_SAMPLE`] steps.
    pub fn trace(
        &mut self,
        transmitter: [usize; 2],
        receiver: [usize; 2],
        steps: usize,
    ) -> Vec<f32> {
        let pairs = [
            &mut self.magnetic,
            &mut self.electric_memory,
            &mut self.magnetic_memory,
        ];
        for field in pairs.into_iter().flatten().chain([&mut self.electric]) {
            field.fill(0.0);
        }
        let [from, to] = [transmitter, receiver].map(|[column, row]| row * self.columns + column);
        let mut samples = Vec::with_capacity(steps.div_ceil(STEPS_PER_SAMPLE));
        for step in 0..steps {
            if step % STEPS_PER_SAMPLE == 0 {
                samples.push(self.electric[to]);
            }
            self.step_magnetic();
            self.step_electric();
            let time_s = (step as f64 + 0.5) * step_s() - pulse_s();
            let phase = (PI * PULSE_HZ * time_s).powi(2);
            let current_a = (1.0 - 2.0 * phase) * (-phase).exp();
            self.electric[from] -= self.gain[from] / CELL_M as f32 * current_a as f32;
        }
        samples
    }

    fn step_magnetic(&mut self) {
        let n = self.columns;
        let factor = (step_s() / VACUUM_H_M / CELL_M) as f32;
        let [hx, hz] = &mut self.magnetic;
        let [memory_x, memory_z] = &mut self.magnetic_memory;
        for row in 0..self.rows - 1 {
            let (here, above) = self.electric[row * n..(row + 2) * n].split_at(n);
            let [hx, hz, mx, mz] = [&mut *hx, &mut *hz, &mut *memory_x, &mut *memory_z]
                .map(|f| &mut f[row * n..][..n]);
            for k in 0..n - 1 {
                hx[k] -= factor * (above[k] - here[k]);
                hz[k] += factor * (here[k + 1] - here[k]);
            }
            let [memory, gain] = self.up.between_cells[row];
            if gain != 0.0 {
                for k in 0..n - 1 {
                    mx[k] = memory * mx[k] + gain * (above[k] - here[k]);
                    hx[k] -= factor * mx[k];
                }
            }
            for k in (0..=LAYER).chain(n - LAYER - 2..n - 1) {
                let [memory, gain] = self.along.between_cells[k];
                mz[k] = memory * mz[k] + gain * (here[k + 1] - here[k]);
                hz[k] += factor * mz[k];
            }
        }
    }

    fn step_electric(&mut self) {
        let n = self.columns;
        let [hx, hz] = &self.magnetic;
        let [memory_x, memory_z] = &mut self.electric_memory;
        for row in 1..self.rows - 1 {
            let here = row * n..(row + 1) * n;
            let (hx_here, hx_below, hz) = (
                &hx[here.clone()],
                &hx[(row - 1) * n..row * n],
                &hz[here.clone()],
            );
            let (keep, gain_e) = (&self.keep[here.clone()], &self.gain[here.clone()]);
            let electric = &mut self.electric[here.clone()];
            let (mx, mz) = (&mut memory_x[here.clone()], &mut memory_z[here]);
            for k in 1..n - 1 {
                let curl = (hz[k] - hz[k - 1]) - (hx_here[k] - hx_below[k]);
                electric[k] = keep[k] * electric[k] + gain_e[k] * curl;
            }
            let [memory, gain] = self.up.at_cells[row];
            if gain != 0.0 {
                for k in 1..n - 1 {
                    mz[k] = memory * mz[k] + gain * (hx_here[k] - hx_below[k]);
                    electric[k] -= gain_e[k] * mz[k];
                }
            }
            for k in (1..=LAYER).chain(n - LAYER - 2..n - 1) {
                let [memory, gain] = self.along.at_cells[k];
                mx[k] = memory * mx[k] + gain * (hz[k] - hz[k - 1]);
                electric[k] += gain_e[k] * mx[k];
            }
        }
    }
}
