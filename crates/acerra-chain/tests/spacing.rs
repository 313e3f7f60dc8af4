//! The spacing of traces between stated ends of a line, by the shapes of the echoes of buried points.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;
use std::fs::File;
use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::findings::{Finding, Verdict, weigh_image};
use acerra_chain::{Control, Journal, MemorySink};
use acerra_formats::segy::{SegyTraces, write_segy};
use acerra_imaging::refraction::{Ground, Layer, Soil, Surface};

const TRACES: usize = 121;
const SPACING_M: f64 = 0.02;
const SAMPLES: usize = 400;
const STEP_S: f64 = 50e-12;
const LIGHT_M_S: f64 = 299_792_458.0;

/// A survey with one antenna along a straight line above soil in which points lie.
struct Line {
    height_m: f64,
    permittivity: f64,
    /// Along the line, and below the surface (m).
    points_m: Vec<[f64; 2]>,
}

impl Line {
    /// Writes the traces: a pulse of 0.6 to 2.4 GHz from the surface and from every point, and noise.
    fn write(&self, path: &Path) {
        let soil = Soil {
            relative_permittivity: self.permittivity,
            conductivity_s_m: 0.0,
        };
        let layers = [Layer::below_all(soil)];
        let ground = Ground::new(Surface::Level { z_m: 0.0 }, &layers, 1.5e9).unwrap();
        let mut state = 7_u64;
        let mut uniform = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut values = Vec::with_capacity(TRACES * SAMPLES);
        for trace in 0..TRACES {
            let antenna_m = [SPACING_M * trace as f64, 0.0, self.height_m];
            let mut echoes = vec![(self.height_m, 3.0 / self.height_m)];
            for [x_m, depth_m] in &self.points_m {
                let ray = ground.ray(antenna_m, [*x_m, 0.0, -depth_m]);
                echoes.push((ray.optical_m, ray.amplitude.powi(2)));
            }
            values.extend((0..SAMPLES).map(|k| {
                let at = |(path_m, amplitude): &(f64, f64)| {
                    let t = STEP_S * k as f64 - 2.0 * path_m / LIGHT_M_S;
                    amplitude * (-(t / 0.35e-9).powi(2)).exp() * (TAU * 1.5e9 * t).cos()
                };
                (echoes.iter().map(at).sum::<f64>() + 0.02 * uniform()) as f32
            }));
        }
        let traces = SegyTraces {
            values: &values,
            samples: SAMPLES,
            step_s: STEP_S,
            start_s: 0.0,
            positions: None,
            antennas_m: None,
            text: &[],
        };
        write_segy(&mut File::create(path).unwrap(), &traces).unwrap();
    }

    /// Findings on an image by a spacing that is `stretch` times too large, and a permittivity.
    fn findings(&self, stretch: f64, permittivity: f64) -> Vec<Finding> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line.sgy");
        self.write(&path);
        let length_m = stretch * SPACING_M * (TRACES - 1) as f64;
        let campaign = Campaign::parse(&format!(
            "[radar]\nfile = '{}'\ndelay_ns = 0\nline_start_m = [0, 0, {height_m}]\n\
             line_end_m = [{length_m}, 0, {height_m}]\n[preprocess]\ngate_ns = 'none'\n\
             [image]\nband_ghz = [0.6, 2.4]\nfrequencies = 31\nx_m = [0, {length_m}]\ny_m = [0, 0]\n\
             z_m = [-0.5, -0.04]\npixel_m = 0.04\npixel_z_m = 0.02\n\
             [ground]\nrelative_permittivity = {permittivity}\n",
            path.display(),
            height_m = self.height_m,
        ))
        .unwrap();
        let prepared = (campaign.survey())
            .prepare(&mut Journal::default(), &Control::default())
            .unwrap();
        let request = campaign.image_request(prepared.scene.pixels.clone());
        let mut sink = MemorySink::default();
        let focused = (prepared.image(&request, &mut sink, &Control::default())).unwrap();
        weigh_image(&prepared, &focused, &Control::default()).unwrap()
    }

    fn spacing(&self, stretch: f64, permittivity: f64) -> Option<Finding> {
        let mut found = self.findings(stretch, permittivity).into_iter();
        found.find(|finding| finding.name == "trace_spacing")
    }
}

/// Lines on the ground and above it.
fn lines() -> [Line; 2] {
    let points_m = vec![[0.5, 0.15], [1.2, 0.3], [1.9, 0.2]];
    [(0.02, 5.0), (0.5, 9.0)].map(|(height_m, permittivity)| Line {
        height_m,
        permittivity,
        points_m: points_m.clone(),
    })
}

#[test]
fn a_right_spacing_agrees() {
    for line in lines() {
        let found = line.spacing(1.0, line.permittivity).unwrap();
        assert_eq!(found.verdict, Verdict::Agrees, "{}", found.explanation);
        assert!(
            (found.value.unwrap() / SPACING_M - 1.0).abs() < 0.15,
            "{found:?}"
        );
    }
}

#[test]
fn a_spacing_off_by_two_and_a_half_is_doubtful_either_way() {
    for line in lines() {
        for stretch in [2.5, 0.4] {
            let found = line.spacing(stretch, line.permittivity).unwrap();
            assert_eq!(found.verdict, Verdict::Doubtful, "{}", found.explanation);
            assert!(
                (found.value.unwrap() / SPACING_M - 1.0).abs() < 0.25,
                "{found:?}"
            );
            assert!((found.expected.unwrap() / (stretch * SPACING_M) - 1.0).abs() < 1e-3);
        }
    }
}

/// Permittivities as soils' tables give them are no reason to doubt the spacing.
#[test]
fn a_permittivity_from_a_table_does_not_doubt_the_spacing() {
    for line in lines() {
        for permittivity in [0.6 * line.permittivity, 1.6 * line.permittivity] {
            if let Some(found) = line.spacing(1.0, permittivity) {
                assert_eq!(found.verdict, Verdict::Agrees, "{}", found.explanation);
            }
        }
    }
}
