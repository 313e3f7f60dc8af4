//! Spectra of points and noise, with the places where they were measured: nothing but the image is left to do.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use acerra_imaging::{Complex64, SPEED_OF_LIGHT_M_S, Spreading, reference};
use acerra_radar::Spectrum;
use acerra_radar::npz::{NeutralContent, write_npz};

/// Pulses along 8 m, and frequencies of 8 MHz about 3.95 GHz.
const PULSES: u32 = 331;
const FREQUENCIES: usize = 213;

/// A square image of pixels of 1 cm, seen along 8 m from a height of 5 m under a Hann window.
pub struct Spectra {
    pixels: u32,
    position_m: Vec<[f64; 3]>,
    spectrum: Spectrum,
}

impl Spectra {
    /// `pixels`² of them with so many points.
    pub fn new(pixels: u32, points: usize) -> Self {
        let position_m: Vec<[f64; 3]> = (0..PULSES)
            .map(|m| {
                let s = f64::from(m) / f64::from(PULSES - 1);
                [
                    0.05 * (9.0 * s).sin(),
                    8.0 * s - 4.0,
                    5.0 + 0.05 * (7.0 * s).cos(),
                ]
            })
            .collect();
        let frequency_hz: Vec<f64> = (0..FREQUENCIES)
            .map(|n| 3.95e9 + 8e6 * (n as f64 - 0.5 * (FREQUENCIES - 1) as f64))
            .collect();
        let mut random = Random(2020);
        let half_m = 0.005 * f64::from(pixels) - 1.0;
        let scene: Vec<_> = (0..points)
            .map(|_| reference::Scatterer {
                position_m: [
                    half_m * (2.0 * random.uniform() - 1.0),
                    half_m * (2.0 * random.uniform() - 1.0),
                    0.0,
                ],
                reflectivity: random.complex(),
            })
            .collect();
        let none = Spreading::None;
        let mut values =
            reference::forward(&position_m, &frequency_hz, &scene, SPEED_OF_LIGHT_M_S, none)
                .unwrap();
        for row in values.chunks_mut(FREQUENCIES) {
            for (n, e) in row.iter_mut().enumerate() {
                let noise = random.complex() * (0.3 / 2f64.sqrt());
                *e = (*e + noise) * (0.5 - 0.5 * (TAU * n as f64 / 212.0).cos());
            }
        }
        let spectrum = Spectrum {
            time_s: (0..PULSES).map(|m| 0.02 * f64::from(m)).collect(),
            frequency_hz,
            values,
        };
        Self {
            pixels,
            position_m,
            spectrum,
        }
    }

    /// Writes them with their campaign; the campaign's file.
    pub fn write(self, folder: &Path) -> PathBuf {
        let file = std::fs::File::create(folder.join("spectra.npz")).unwrap();
        let content = NeutralContent::Spectrum(self.spectrum);
        write_npz(file, &content, Some(&self.position_m)).unwrap();
        let half_m = 0.005 * f64::from(self.pixels);
        let [from_m, to_m] = [-half_m, half_m - 0.01];
        let campaign = folder.join("campaign.toml");
        let text = format!(
            "[radar]\nfile = \"spectra.npz\"\n\
             [image]\nx_m = [{from_m}, {to_m}]\ny_m = [{from_m}, {to_m}]\npixel_m = 0.01\n"
        );
        std::fs::write(&campaign, text).unwrap();
        campaign
    }
}

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

    fn complex(&mut self) -> Complex64 {
        let mut normal = || (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos();
        Complex64::new(normal(), normal())
    }
}
