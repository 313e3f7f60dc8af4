//! Echoes of random volumes by the forward operator, slice by slice.

use crate::found::Found;
use crate::scene::{Random, Scene, draw};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ForwardVolume, PlanOptions, PlaneGrid,
    SPEED_OF_LIGHT_M_S, SimdLevel, VolumeGrid, reference,
};

/// A volume under the track of a random scene: what it models of one slice, and of all.
pub fn try_volume(number: u64) -> Vec<Found> {
    let mut random = Random::of(number);
    let scene = draw(&mut random);
    let volume = volume(&scene, &mut random);
    let accuracy = random.log_within(1e-5, 1e-2);
    let engine = [
        Engine::Auto,
        Engine::Auto,
        Engine::Direct,
        Engine::Factorized,
    ][random.below(4)];
    let bright = random.below(volume.nz);
    let slices = match random.below(3) {
        0 => 0..volume.nz,
        _ => bright..bright + 1,
    };
    let images: Vec<Vec<Complex32>> = (0..volume.nz)
        .map(|k| {
            let value = |_| match slices.contains(&k) {
                true => {
                    let value = random.complex();
                    Complex32::new(value.re as f32, value.im as f32)
                }
                false => Complex32::ZERO,
            };
            (0..volume.base.len()).map(value).collect()
        })
        .collect();
    let scatterers = scatterers(&volume, &images);
    let expected = exact(&scene, &scatterers);
    let power = independent_power(&scene, &scatterers);
    let of_level = |level: &SimdLevel| {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_spreading(scene.spreading)
            .with_level(*level)
            .with_engine(engine);
        let control = Control::default();
        let forward = ForwardVolume::new(&volume, scene.pulses(), &options, control).unwrap();
        let mut echo = vec![Complex64::ZERO; expected.len()];
        let give = |k: usize, image: &mut [Complex32]| image.copy_from_slice(&images[k]);
        forward.run(give, &mut echo, control).unwrap();
        Found {
            number,
            level: *level,
            kind: format!(
                "{} slices, {:.2} m apart; {}",
                volume.nz, volume.step_m, scene.kind
            ),
            engine: match forward.reports().next().unwrap().engine {
                Engine::Direct => "direct",
                Engine::Factorized => "factorized",
                _ => "reference",
            },
            accuracy,
            error: ((echo.iter().zip(&expected))
                .map(|(a, b)| (a - b).norm_sqr())
                .sum::<f64>()
                / power)
                .sqrt(),
            worst: format!(
                "slices {slices:?} of {:?}",
                forward.plans().collect::<Vec<_>>()
            ),
            report: forward
                .reports()
                .map(|report| format!("{report}\n"))
                .collect(),
        }
    };
    SimdLevel::available().iter().map(of_level).collect()
}

/// Two to five slices that end below the antennas.
fn volume(scene: &Scene, random: &mut Random) -> VolumeGrid {
    let pixel_m = scene.plane.u_m.map(|u| u * u).iter().sum::<f64>().sqrt();
    let size = [scene.plane.columns.min(70), scene.plane.rows.min(70)];
    let lowest_m = scene
        .position_m
        .iter()
        .map(|p| p[2])
        .fold(f64::INFINITY, f64::min);
    let nz = 2 + random.below(4);
    let top_m = random.within(0.1, 0.95) * lowest_m;
    let step_m = (top_m / nz as f64)
        .min(pixel_m * random.log_within(0.5, 20.0))
        .max(1e-3);
    let corner_m = size.map(|n| -0.5 * pixel_m * n as f64);
    let base = PlaneGrid::new([corner_m[0], corner_m[1], 0.0], pixel_m, size).unwrap();
    VolumeGrid::new(base, step_m, nz).unwrap()
}

/// The voxels that are not dark.
fn scatterers(volume: &VolumeGrid, images: &[Vec<Complex32>]) -> Vec<reference::Scatterer> {
    (images.iter().enumerate())
        .flat_map(|(k, image)| {
            let grid = volume.slice(k);
            let bright = image.iter().enumerate();
            let bright = bright.filter(|(_, v)| **v != Complex32::ZERO);
            bright.map(move |(i, v)| reference::Scatterer {
                position_m: [grid.x_m(i % grid.nx), grid.y_m(i / grid.nx), grid.z_m],
                reflectivity: Complex64::new(v.re.into(), v.im.into()),
            })
        })
        .collect()
}

/// Eq. (1) summed plainly, times the weights of the pulses.
fn exact(scene: &Scene, scatterers: &[reference::Scatterer]) -> Vec<Complex64> {
    let (light, spread) = (SPEED_OF_LIGHT_M_S, scene.spreading);
    let (places, frequencies) = (&scene.position_m, &scene.frequency_hz);
    let mut echo = reference::forward(places, frequencies, scatterers, light, spread).unwrap();
    for (row, w) in echo.chunks_mut(frequencies.len()).zip(&scene.weight) {
        row.iter_mut().for_each(|e| *e *= w);
    }
    echo
}

/// The mean power of the echoes if the voxels' phases were drawn again and again, to which the promise is relative:
/// where a scene is no larger than a resolution cell, those of one draw may cancel.
fn independent_power(scene: &Scene, scatterers: &[reference::Scatterer]) -> f64 {
    let of_pulse = |(place, weight): (&[f64; 3], &f64)| -> f64 {
        let echo = |s: &reference::Scatterer| {
            let range_m = reference::range_m(*place, s.position_m);
            s.reflectivity.norm_sqr() * scene.spreading.weight(range_m).powi(2)
        };
        weight * weight * scatterers.iter().map(echo).sum::<f64>()
    };
    let pulses = scene.position_m.iter().zip(&scene.weight);
    scene.frequency_hz.len() as f64 * pulses.map(of_pulse).sum::<f64>()
}
