//! Echoes, the pixels to image them on, and the targets in them.

use std::ops::Range;

use acerra_chain::echoes::Echoes;
use acerra_chain::focus::focus;
use acerra_chain::focus::inversion::Method;
use acerra_chain::focus::inversion::image::{InversionInput, invert};
use acerra_chain::focus::plan::ImageError;
use acerra_chain::position::aligned::Aligned;
use acerra_chain::{Control, FocusOptions, Focused, ImageRequest, MemorySink, Pixels};
use acerra_imaging::{Complex64, PulseArrays, Pulses};
use acerra_invert::Flight;
use acerra_radar::Spectrum;

/// A point whose image is measured.
pub struct Target {
    pub name: String,
    pub place_m: [f64; 3],
}

pub struct Scene {
    pub name: String,
    pub spectrum: Spectrum,
    pub aligned: Aligned,
    pub light_speed_m_s: f64,
    /// The traces of each track.
    pub tracks: Vec<Range<usize>>,
    /// Nearest and farthest range that the data of each trace hold (m).
    pub held_m: Vec<[f64; 2]>,
    pub pixels: Pixels,
    pub options: FocusOptions,
    pub targets: Vec<Target>,
}

impl Scene {
    /// The image by `method`; `max_iterations` of it where stated. The response to a single point, which takes
    /// as long again, is not asked for.
    pub fn image(
        &self,
        method: Method,
        max_iterations: Option<usize>,
        control: &Control<'_>,
    ) -> Result<Focused, ImageError> {
        let mut request = ImageRequest::on(self.pixels.clone());
        request.options = self.options;
        request.options.inversion.method = method;
        request.options.inversion.parameters.resolution_points = 0;
        request.options.inversion.parameters.max_iterations = max_iterations;
        let echoes = Echoes {
            spectrum: &self.spectrum,
            aligned: &self.aligned,
            light_speed_m_s: self.light_speed_m_s,
        };
        let sink = &mut MemorySink::default();
        if method == Method::Adjoint {
            return focus(echoes, &self.tracks, &request, sink, control);
        }
        let input = InversionInput {
            echoes,
            parts: &self.tracks,
            held_m: &self.held_m,
        };
        invert(input, &request, sink, control)
    }
}

/// What a simulated radar of the paper's band flies past.
pub struct Simulated {
    /// Where the pulses are sent, track after track.
    pub tracks_m: Vec<Vec<[f64; 3]>>,
    pub light_speed_m_s: f64,
    /// Unit points.
    pub points_m: Vec<[f64; 3]>,
    /// Noise in the adjoint's image against the first point, dB.
    pub noise_db: f64,
}

impl Simulated {
    /// The scene with echoes and noise at 341 frequencies from 3.1 GHz to 4.8 GHz.
    pub fn scene(&self, name: &str, pixels: Pixels) -> Scene {
        let position_m = self.tracks_m.concat();
        let frequency_hz: Vec<f64> = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
        let mut values = vec![Complex64::ZERO; position_m.len() * frequency_hz.len()];
        let flight = self.flight(&position_m, &frequency_hz, &values);
        for point_m in &self.points_m {
            flight.add_echo(*point_m, Complex64::ONE, &mut values);
        }
        let sigma = flight.column_norm(self.points_m[0]) * 10f64.powf(self.noise_db / 20.0);
        let mut random = Random(17);
        values
            .iter_mut()
            .for_each(|v| *v += random.complex() * sigma);
        let time_s: Vec<f64> = (0..position_m.len()).map(|m| 0.1 * m as f64).collect();
        let mut end = 0;
        let mut range_of = |track: &Vec<[f64; 3]>| {
            end += track.len();
            end - track.len()..end
        };
        Scene {
            name: name.to_owned(),
            spectrum: Spectrum::new(frequency_hz, values, time_s.clone()).unwrap(),
            tracks: self.tracks_m.iter().map(&mut range_of).collect(),
            held_m: vec![[0.0, f64::INFINITY]; position_m.len()],
            aligned: Aligned {
                traces: (0..position_m.len()).collect(),
                time_s,
                height_m: position_m.iter().map(|p| p[2]).collect(),
                position_m,
                ..Aligned::default()
            },
            light_speed_m_s: self.light_speed_m_s,
            pixels,
            options: FocusOptions::default(),
            targets: Vec::new(),
        }
    }

    fn flight(
        &self,
        position_m: &[[f64; 3]],
        frequency_hz: &[f64],
        spectrum: &[Complex64],
    ) -> Flight {
        let weight = vec![1.0; position_m.len()];
        let pulses = Pulses::new(PulseArrays {
            position_m,
            frequency_hz,
            spectrum,
            weight: &weight,
            light_speed_m_s: self.light_speed_m_s,
        });
        Flight::of(&pulses.unwrap()).unwrap()
    }
}

/// Random numbers (SplitMix64).
struct Random(u64);

impl Random {
    /// Uniform in (0, 1].
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 1.0) * 2f64.powi(-53)
    }

    /// Circular Gaussian of unit power.
    fn complex(&mut self) -> Complex64 {
        let modulus = (-self.uniform().ln()).sqrt();
        Complex64::from_polar(modulus, std::f64::consts::TAU * self.uniform())
    }
}
