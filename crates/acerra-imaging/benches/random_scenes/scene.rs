//! Random scenes: tracks, frequencies, grids and echoes.

use acerra_imaging::{
    Complex64, PlaneGrid, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading, SurfaceGrid,
    TiltedGrid, reference,
};
use std::f64::consts::TAU;

/// Terms of the double-precision sum that a scene may cost.
const MOST_TERMS: f64 = 1.5e8;

/// Reproducible numbers.
pub struct Random(u64);

impl Random {
    /// The numbers of scene `number`.
    pub fn of(number: u64) -> Self {
        let mut random = Self(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678);
        for _ in 0..8 {
            random.uniform();
        }
        random
    }
    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let x = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((x ^ (x >> 32)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }
    pub fn log_within(&mut self, from: f64, to: f64) -> f64 {
        self.within(from.ln(), to.ln()).exp()
    }
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (self.uniform() + 1e-18).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
    pub fn complex(&mut self) -> Complex64 {
        Complex64::new(self.normal(), self.normal())
    }
}

pub struct Scene {
    pub position_m: Vec<[f64; 3]>,
    pub frequency_hz: Vec<f64>,
    pub spectrum: Vec<Complex64>,
    pub weight: Vec<f64>,
    pub plane: TiltedGrid,
    pub surface: Option<SurfaceGrid>,
    pub spreading: Spreading,
    pub kind: String,
}

impl Scene {
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
}

pub fn draw(random: &mut Random) -> Scene {
    let range_m = random.log_within(1.0, 3000.0);
    let frequency_hz = frequencies(random);
    let pixel_m = random.log_within(0.005, 0.3);
    let (columns, rows) = (4 + random.below(140), 4 + random.below(140));
    let extent_m = pixel_m * columns.max(rows) as f64;
    let most = MOST_TERMS / (columns * rows * frequency_hz.len()) as f64;
    let pulses = (random.log_within(1.0, 1500.0).min(most) as usize).max(1);
    let (position_m, track) = track(random, pulses, range_m, extent_m);
    let (plane, surface, ground) = ground(random, pixel_m, [columns, rows], range_m);
    let spreading = [Spreading::None, Spreading::InverseSquare][random.below(2)];
    let targets = [0, 1, 12][random.below(3)];
    let scatterers: Vec<_> = (0..targets)
        .map(|_| {
            let (i, j) = (random.uniform(), random.uniform());
            reference::Scatterer {
                position_m: plane.point_m(i * (columns - 1) as f64, j * (rows - 1) as f64),
                reflectivity: random.complex(),
            }
        })
        .collect();
    let (light, spread) = (SPEED_OF_LIGHT_M_S, spreading);
    let mut spectrum =
        reference::forward(&position_m, &frequency_hz, &scatterers, light, spread).unwrap();
    let power: f64 = spectrum.iter().map(|e| e.norm_sqr()).sum();
    let rms = (power / spectrum.len() as f64).sqrt();
    let noise = if targets == 0 {
        1.0
    } else {
        rms * random.log_within(1e-3, 1.0)
    };
    let scale = random.log_within(1e-6, 1e6);
    for e in &mut spectrum {
        *e = (*e + random.complex() * noise) * scale;
    }
    Scene {
        weight: (0..pulses).map(|_| random.within(0.0, 2.0)).collect(),
        kind: format!(
            "{track}, {ground}, {columns} × {rows} pixels of {:.1} cm, {pulses} pulses at {range_m:.1} m, {} frequencies, {targets} targets, {spreading:?}",
            100.0 * pixel_m,
            frequency_hz.len()
        ),
        position_m,
        frequency_hz,
        spectrum,
        plane,
        surface,
        spreading,
    }
}

fn frequencies(random: &mut Random) -> Vec<f64> {
    let [low, high] = [[3.1e9, 4.8e9], [0.4e9, 1.2e9], [9.2e9, 10.2e9]][random.below(3)];
    let n = 2 + random.below(100);
    let uneven = random.below(4) == 0;
    let step = (high - low) / n as f64;
    (0..n)
        .map(|k| {
            let jitter = if uneven { random.within(0.0, 0.9) } else { 0.0 };
            low + step * (k as f64 + jitter)
        })
        .collect()
}

/// Antenna positions `range_m` from the middle of the image or nearer, and their name.
fn track(
    random: &mut Random,
    pulses: usize,
    range_m: f64,
    extent_m: f64,
) -> (Vec<[f64; 3]>, &'static str) {
    let kind = random.below(5);
    let height_m = range_m * random.within(0.2, 1.0);
    let beside_m = (range_m * range_m - height_m * height_m).sqrt();
    let turn = random.within(0.0, TAU);
    let length_m = match kind {
        // A track many times as long as it is far.
        1 => range_m.min(100.0) * random.within(5.0, 40.0),
        _ => extent_m.max(0.3 * range_m.min(50.0)) * random.within(0.2, 3.0),
    };
    let wander_m = random.log_within(1e-4, 0.2);
    let rates = [0; 3].map(|_| random.within(1.0, 30.0));
    let position_m = (0..pulses)
        .map(|m| {
            let s = if pulses > 1 {
                m as f64 / (pulses - 1) as f64
            } else {
                0.5
            };
            let w = rates.map(|rate| wander_m * (rate * s).sin());
            let (x, y) = match kind {
                2 => {
                    let angle = TAU * s;
                    (beside_m * angle.cos(), beside_m * angle.sin())
                }
                3 => (
                    -beside_m + random.within(-0.5, 0.5) * extent_m,
                    random.within(-0.5, 0.5) * length_m,
                ),
                4 if m % 2 == 0 => (-beside_m - 0.1 * extent_m, (s - 0.5) * length_m),
                _ => (-beside_m, (s - 0.5) * length_m),
            };
            let (x, y) = (x + w[0], y + w[1]);
            [
                x * turn.cos() - y * turn.sin(),
                x * turn.sin() + y * turn.cos(),
                height_m + w[2],
            ]
        })
        .collect();
    let name = [
        "line",
        "long line",
        "circle",
        "scattered",
        "two tracks by turns",
    ][kind];
    (position_m, name)
}

/// A level or tilted plane, or uneven ground on a level one, and its name.
fn ground(
    random: &mut Random,
    pixel_m: f64,
    [columns, rows]: [usize; 2],
    range_m: f64,
) -> (TiltedGrid, Option<SurfaceGrid>, &'static str) {
    let origin_m = [
        -0.5 * pixel_m * columns as f64,
        -0.5 * pixel_m * rows as f64,
        0.0,
    ];
    let level = PlaneGrid::new(origin_m, pixel_m, [columns, rows]).unwrap();
    match random.below(3) {
        0 => (level.into(), None, "level plane"),
        1 => {
            let [a, b, c] = [0; 3].map(|_| random.within(-0.5, 0.5) * pixel_m);
            let stretch = random.within(0.5, 2.0);
            let (u_m, v_m) = ([pixel_m, a, 0.3 * b], [c, pixel_m * stretch, 0.3 * a]);
            let tilted = TiltedGrid::new(origin_m, u_m, v_m, columns, rows).unwrap();
            (tilted, None, "tilted plane")
        }
        _ => {
            let relief_m = 0.1 * range_m.min(10.0) * random.uniform();
            let per_m = random.log_within(0.02, 2.0);
            let height = |x: f64, y: f64| {
                let z = relief_m * ((per_m * x).sin() + (0.7 * per_m * y).cos());
                Ok::<_, acerra_imaging::ImagingError>(z)
            };
            let surface = SurfaceGrid::from_fn(level, height).unwrap();
            (level.into(), Some(surface), "uneven ground")
        }
    }
}
