//! Scenes that the benchmarks image.
#![allow(dead_code)] // not every benchmark uses everything

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, PlanOptions, PlaneGrid, PulseArrays, Pulses,
    SPEED_OF_LIGHT_M_S, Spreading, reference,
};

/// Reproducible numbers without a dependency.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
    fn complex(&mut self) -> Complex64 {
        Complex64::new(self.normal(), self.normal())
    }
}

/// Echoes of random targets and noise under a Hann window, and the grid to image them on.
pub struct Scene {
    pub name: &'static str,
    pub position_m: Vec<[f64; 3]>,
    pub frequency_hz: Vec<f64>,
    pub spectrum: Vec<Complex64>,
    pub weight: Vec<f64>,
    pub grid: PlaneGrid,
}

impl Scene {
    /// 1800 × 1800 pixels of 1 cm, 331 pulses along 8 m, 213 frequencies.
    pub fn common() -> Self {
        let position_m = (0..331)
            .map(|m| {
                let s = f64::from(m) / 330.0;
                [
                    0.05 * (9.0 * s).sin(),
                    -4.0 + 8.0 * s,
                    5.0 + 0.05 * (7.0 * s).cos(),
                ]
            })
            .collect();
        let grid = PlaneGrid::new([-9.0, -9.0, 0.0], 0.01, [1800, 1800]).unwrap();
        Self::new("common scene", position_m, grid)
    }

    /// 4000 × 4000 pixels of 1 cm, 5000 pulses on three tracks of 40 m.
    pub fn large() -> Self {
        let position_m = (0..5000)
            .map(|m| {
                let (track, s) = (m * 3 / 5000, f64::from(m * 3 % 5000) / 5000.0);
                // There and back again.
                let along = if track % 2 == 0 { s } else { 1.0 - s };
                [
                    3.0 * f64::from(track) - 3.0 + 0.05 * (40.0 * s).sin(),
                    -20.0 + 40.0 * along,
                    5.0 + 0.05 * (31.0 * s).cos(),
                ]
            })
            .collect();
        let grid = PlaneGrid::new([-20.0, -20.0, 0.0], 0.01, [4000, 4000]).unwrap();
        Self::new("large scene", position_m, grid)
    }

    /// 1000 × 1000 pixels of `pixel_m` about the track of the common scene, or another number of
    /// pulses along it.
    pub fn of_pixels(pixel_m: f64, pulses: usize) -> Self {
        let position_m = (0..pulses)
            .map(|m| {
                let s = m as f64 / (pulses - 1) as f64;
                let length_m = 8.0 * (pulses as f64 / 331.0).max(1.0);
                [
                    0.05 * (9.0 * s).sin(),
                    length_m * (s - 0.5),
                    5.0 + 0.05 * (7.0 * s).cos(),
                ]
            })
            .collect();
        let half = 500.0 * pixel_m;
        let grid = PlaneGrid::new([-half, -half, 0.0], pixel_m, [1000, 1000]).unwrap();
        Self::new("pixels", position_m, grid)
    }

    /// 1000 × 1000 pixels of `pixel_m` about the middle of a track of `track_m`.
    pub fn along(track_m: f64, pulses: usize, pixel_m: f64) -> Self {
        let position_m = (0..pulses)
            .map(|m| {
                let s = m as f64 / (pulses - 1) as f64;
                let wander = s * track_m;
                [
                    0.05 * (1.1 * wander).sin(),
                    track_m * (s - 0.5),
                    5.0 + 0.05 * (0.9 * wander).cos(),
                ]
            })
            .collect();
        let half = 500.0 * pixel_m;
        let grid = PlaneGrid::new([-half, -half, 0.0], pixel_m, [1000, 1000]).unwrap();
        Self::new("track", position_m, grid)
    }

    /// `size` × `size` pixels of 1 cm, `pulses` 2.4 cm apart, flown back and forth over the image.
    pub fn of_size(size: usize, pulses: usize) -> Self {
        let half = 0.005 * size as f64;
        let lane = 400;
        let position_m = (0..pulses)
            .map(|m| {
                let (track, k) = (m / lane, m % lane);
                let along = 0.024 * (k as f64 - 0.5 * lane.min(pulses) as f64);
                [
                    0.5 * track as f64 + 0.05 * (0.03 * k as f64).sin(),
                    if track % 2 == 0 { along } else { -along },
                    5.0 + 0.05 * (0.02 * k as f64).cos(),
                ]
            })
            .collect();
        let grid = PlaneGrid::new([-half, -half, 0.0], 0.01, [size, size]).unwrap();
        Self::new("scene", position_m, grid)
    }

    fn new(name: &'static str, position_m: Vec<[f64; 3]>, grid: PlaneGrid) -> Self {
        let mut random = Random(2020);
        let frequency_hz: Vec<f64> = (0..213)
            .map(|n| 3.95e9 + 8e6 * (f64::from(n) - 106.0))
            .collect();
        let half = 0.5 * grid.pixel_m * grid.nx as f64 - 1.0;
        let scene: Vec<_> = (0..40)
            .map(|_| reference::Scatterer {
                position_m: [
                    half * (2.0 * random.uniform() - 1.0),
                    half * (2.0 * random.uniform() - 1.0),
                    0.0,
                ],
                reflectivity: random.complex(),
            })
            .collect();
        let none = Spreading::None;
        let mut spectrum =
            reference::forward(&position_m, &frequency_hz, &scene, SPEED_OF_LIGHT_M_S, none)
                .unwrap();
        for row in spectrum.chunks_mut(213) {
            for (n, e) in row.iter_mut().enumerate() {
                let noise = random.complex() * (0.3 / 2f64.sqrt());
                let hann = 0.5 - 0.5 * (std::f64::consts::TAU * n as f64 / 212.0).cos();
                *e = (*e + noise) * hann;
            }
        }
        Self {
            name,
            weight: vec![1.0; position_m.len()],
            position_m,
            frequency_hz,
            spectrum,
            grid,
        }
    }

    pub fn pulses(&self) -> Pulses<'_> {
        Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &self.spectrum,
            weight: &self.weight,
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
        })
        .unwrap()
    }

    /// 10⁹ pixel × pulse contributions of an image.
    pub fn gbp(&self) -> f64 {
        self.grid.len() as f64 * self.position_m.len() as f64 * 1e-9
    }

    /// Every `step`th pixel in x and y in double precision; a prime number of them meets every phase of coarse
    /// grids.
    pub fn expected(&self, step: usize) -> Vec<Complex64> {
        let g = self.grid;
        let n = g.nx / step;
        let sparse =
            PlaneGrid::new([g.x0_m, g.y0_m, g.z_m], g.pixel_m * step as f64, [n, n]).unwrap();
        let options = PlanOptions::default()
            .with_engine(Engine::Reference)
            .with_spreading(Spreading::None);
        acerra_imaging::image(self.pulses(), sparse, &options, Control::default())
            .unwrap()
            .iter()
            .map(wide)
            .collect()
    }

    /// Writes positions, frequencies, spectra and `expected` as plain little-endian doubles.
    pub fn dump(&self, folder: &std::path::Path, expected: &[Complex64]) {
        let write = |name: &str, values: &mut dyn Iterator<Item = f64>| {
            let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
            std::fs::write(folder.join(name), bytes).unwrap();
        };
        let parts = |v: &Complex64| [v.re, v.im];
        write(
            "position_m.f64",
            &mut self.position_m.iter().flatten().copied(),
        );
        write("frequency_hz.f64", &mut self.frequency_hz.iter().copied());
        write("spectrum.c128", &mut self.spectrum.iter().flat_map(parts));
        write("expected.c128", &mut expected.iter().flat_map(parts));
    }

    /// Relative L2 error of an image at those pixels.
    pub fn error(&self, image: &[Complex32], step: usize, expected: &[Complex64]) -> f64 {
        let n = self.grid.nx / step;
        let found: Vec<_> = (0..n * n)
            .map(|k| wide(&image[(k / n) * step * self.grid.nx + (k % n) * step]))
            .collect();
        reference::relative_l2(&found, expected).unwrap()
    }
}

fn wide(v: &Complex32) -> Complex64 {
    Complex64::new(f64::from(v.re), f64::from(v.im))
}

/// Processor time of all threads so far, s (Linux; zero elsewhere).
pub fn processor_time_s() -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    tasks
        .flatten()
        .filter_map(|t| std::fs::read_to_string(t.path().join("schedstat")).ok())
        .filter_map(|s| s.split(' ').next()?.parse::<f64>().ok())
        .sum::<f64>()
        * 1e-9
}
