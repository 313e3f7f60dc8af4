//! Several tracks, volumes and live images: what the geometry must give.
#![allow(clippy::unwrap_used)]

use acerra_imaging::{
    Complex32, Complex64, Control, ImagingError, LiveImage, PlanOptions, PlaneGrid, PulseArrays,
    Pulses, SPEED_OF_LIGHT_M_S, SimdLevel, Spreading, VolumeGrid, image, image_volume,
    image_volume_planned_once, reference,
};

struct Data {
    position_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
    weight: Vec<f64>,
}

impl Data {
    /// Tracks along y at the given x, 5 m up, over one target.
    fn tracks(x_m: &[f64], target_m: [f64; 3]) -> Self {
        let position_m: Vec<_> = x_m
            .iter()
            .flat_map(|&x| (0..101).map(move |m| [x, -2.0 + 0.04 * f64::from(m), 5.0]))
            .collect();
        let frequency_hz: Vec<f64> = (0..69).map(|n| 3.1e9 + 2.5e7 * f64::from(n)).collect();
        let scene = [reference::Scatterer {
            position_m: target_m,
            reflectivity: Complex64::ONE,
        }];
        let spectrum = reference::forward(
            &position_m,
            &frequency_hz,
            &scene,
            SPEED_OF_LIGHT_M_S,
            Spreading::InverseSquare,
        )
        .unwrap();
        let weight = vec![1.0; position_m.len()];
        Self {
            position_m,
            frequency_hz,
            spectrum,
            weight,
        }
    }

    /// What a target gives at these positions.
    fn echoes(&self, target_m: [f64; 3]) -> Vec<Complex64> {
        let scene = [reference::Scatterer {
            position_m: target_m,
            reflectivity: Complex64::ONE,
        }];
        let (position_m, frequency_hz) = (&self.position_m, &self.frequency_hz);
        let spreading = Spreading::InverseSquare;
        let c = SPEED_OF_LIGHT_M_S;
        reference::forward(position_m, frequency_hz, &scene, c, spreading).unwrap()
    }

    fn pulses(&self) -> Pulses<'_> {
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

fn peak(image: &[Complex32]) -> f32 {
    image.iter().map(|v| v.norm()).fold(0.0, f32::max)
}

#[test]
fn parallel_tracks_suppress_the_ghost() {
    let target = [2.0, 0.0, 0.0];
    let at = |x: f64| PlaneGrid::new([x - 0.3, -0.3, 0.0], 0.02, [31, 31]).unwrap();
    let level_db = |tracks: &[f64]| {
        let data = Data::tracks(tracks, target);
        let options = PlanOptions::default();
        // Mirrored at the middle track, x = 0.
        let ghost = peak(&image(data.pulses(), at(-2.0), &options, Control::default()).unwrap());
        let there = peak(&image(data.pulses(), at(2.0), &options, Control::default()).unwrap());
        20.0 * (ghost / there).log10()
    };
    let one = level_db(&[0.0]);
    let five = level_db(&[-2.0, -1.0, 0.0, 1.0, 2.0]);
    assert!(
        one.abs() < 0.1,
        "a straight track cannot tell left from right: {one} dB"
    );
    assert!(five < one - 12.0, "{five} dB for {one} dB");
}

#[test]
fn a_volume_shows_the_height_of_a_target() {
    let target = [2.0, 0.1, 0.43];
    let data = Data::tracks(&[-2.0, -1.0, 0.0, 1.0, 2.0], target);
    let base = PlaneGrid::new([1.0, -0.1, 0.0], 0.02, [101, 21]).unwrap();
    let volume = VolumeGrid::new(base, 0.02, 51).unwrap();
    let mut best = (0.0, [0.0; 3]);
    let options = PlanOptions::default();
    let take = |_: usize, grid: &PlaneGrid, slice: &[Complex32]| {
        for (k, v) in slice.iter().enumerate() {
            if v.norm() > best.0 {
                best = (v.norm(), grid.point_m(k));
            }
        }
        Ok::<(), ImagingError>(())
    };
    image_volume(&volume, data.pulses(), &options, Control::default(), take).unwrap();
    for (found, truth) in best.1.iter().zip(target) {
        assert!((found - truth).abs() < 0.03, "{:?}", best.1);
    }
}

/// Images a volume and compares every slice with the double-precision sum.
fn check_volume(data: &Data, volume: &VolumeGrid, options: &PlanOptions) {
    for once in [false, true] {
        check_volume_planned(data, volume, options, once);
    }
}

fn check_volume_planned(data: &Data, volume: &VolumeGrid, options: &PlanOptions, once: bool) {
    let pulses = data.pulses();
    let mut slices = 0;
    let take = |k: usize, grid: &PlaneGrid, slice: &[Complex32]| {
        let points: Vec<_> = grid.points_m().collect();
        let expected = reference::adjoint(&pulses, &points, options.spreading)?;
        let found: Vec<_> = slice
            .iter()
            .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
            .collect();
        let error = reference::relative_l2(&found, &expected)?;
        assert!(error <= options.accuracy, "slice {k}: {error:e}");
        assert!((grid.z_m - volume.base.z_m - k as f64 * volume.step_m).abs() < 1e-12);
        slices += 1;
        Ok::<(), ImagingError>(())
    };
    let control = Control::default();
    let run = if once {
        image_volume_planned_once(volume, pulses, options, control, take)
    } else {
        image_volume(volume, pulses, options, control, take)
    };
    let run = run.unwrap();
    assert_eq!(slices, volume.nz);
    assert!(run.memory_bytes >= volume.base.len() as u128 * 8 && !run.report.decisions.is_empty());
    assert!(run.checked_error.is_none_or(|e| e <= options.accuracy));
}

#[test]
fn degenerate_volumes_keep_the_accuracy() {
    let volume = |nx, ny, nz| {
        let base = PlaneGrid::new([1.5, -0.2, -0.05], 0.02, [nx, ny]).unwrap();
        VolumeGrid::new(base, 0.03, nz).unwrap()
    };
    for &level in SimdLevel::available() {
        let options = PlanOptions::default().with_level(level);
        let target = [1.7, 0.0, 0.02];
        let near = Data::tracks(&[0.0], target);
        let mut far = Data::tracks(&[-2000.0], target);
        for p in &mut far.position_m {
            p[2] = 2200.0;
        }
        far.spectrum = Data::echoes(&far, target);
        let mut one = Data::tracks(&[0.0], target);
        one.position_m.truncate(1);
        one.weight.truncate(1);
        one.spectrum.truncate(one.frequency_hz.len());
        let mut standing = Data::tracks(&[1.6], target);
        standing.position_m.fill([1.71, 0.015, 3.0]); // above a pixel, half a pixel off
        standing.spectrum = Data::echoes(&standing, target);
        for data in [&near, &far, &one, &standing] {
            for grid in [
                volume(17, 9, 4),
                volume(1, 40, 3),
                volume(40, 1, 2),
                volume(1, 1, 5),
            ] {
                check_volume(data, &grid, &options);
            }
        }
        // Through the slices, between their pixels.
        let mut inside = Data::tracks(&[1.61], target);
        for (m, p) in inside.position_m.iter_mut().enumerate() {
            p[1] = -0.211 + 0.0043 * m as f64;
            p[2] = 0.01;
        }
        inside.spectrum = Data::echoes(&inside, target);
        check_volume(&inside, &volume(17, 9, 4), &options);
    }
}

#[test]
fn a_live_image_is_the_image_of_all_pulses() {
    let data = Data::tracks(&[0.0], [1.5, 0.2, 0.0]);
    let pulses = data.pulses();
    let grid = PlaneGrid::new([1.0, -0.3, 0.0], 0.02, [51, 31]).unwrap();
    let options = PlanOptions::default().with_accuracy(1e-4);
    let mut live = LiveImage::new(grid, options);
    for part in [0..40, 40..41, 41..101] {
        live.push(pulses.slice(part).unwrap(), Control::default())
            .unwrap();
    }
    assert_eq!(live.pulses(), 101);
    let whole = image(pulses, grid, &options, Control::default()).unwrap();
    let difference: f64 = live
        .image()
        .iter()
        .zip(&whole)
        .map(|(a, b)| f64::from((a - b).norm_sqr()))
        .sum();
    let power: f64 = whole.iter().map(|v| f64::from(v.norm_sqr())).sum();
    assert!((difference / power).sqrt() < 3e-4);
}

#[test]
fn impossible_volumes_are_refused() {
    let base = PlaneGrid::new([0.0, 0.0, 0.0], 0.1, [3, 3]).unwrap();
    assert!(VolumeGrid::new(base, 0.1, 0).is_err());
    assert!(VolumeGrid::new(base, 0.0, 3).is_err());
    assert_eq!(VolumeGrid::new(base, 0.1, 3).unwrap().slice(2).z_m, 0.2);
}
