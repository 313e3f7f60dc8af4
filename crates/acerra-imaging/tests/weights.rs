//! Antenna pattern and incidence limits against the weighted double-precision sum.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;
use common::{C, Campaign, band};

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingError, ImagingPlan, IncidenceWeight,
    PlanOptions, PlaneGrid, PulseArrays, Pulses, SimdLevel, Spreading, SurfaceGrid, TiltedGrid,
    reference,
};

at_every_level!(
    weighted_images_match_the_weighted_sum,
    tilted_patterns_match_the_weighted_sum,
    tilted_forward_is_the_adjoint
);

/// Thirty pulses 3 m above a patch that reaches from nadir to 60° off.
fn campaign() -> Campaign {
    let position: Vec<_> = (0..30)
        .map(|m| [0.02 * f64::from(m % 5), 0.05 * f64::from(m) - 0.7, 3.0])
        .collect();
    Campaign::new(position, band(40), &[[0.5, 0.1, 0.0], [3.0, 0.3, 0.0]], 21)
}

/// Eq. (3) with every pulse's data weighted at a pixel by the angle from the vertical.
fn expected(c: &Campaign, point_m: [f64; 3], weight: IncidenceWeight) -> Complex64 {
    let n = c.frequency_hz.len();
    (0..c.position_m.len())
        .map(|m| {
            let p = c.position_m[m];
            let range_m = reference::range_m(p, point_m);
            let angle_rad = ((p[2] - point_m[2]) / range_m).acos();
            let one = Pulses::new(PulseArrays {
                position_m: &c.position_m[m..=m],
                frequency_hz: &c.frequency_hz,
                spectrum: &c.spectrum[m * n..(m + 1) * n],
                weight: &c.weight[m..=m],
                light_speed_m_s: C,
            })
            .unwrap();
            let image = reference::adjoint(&one, &[point_m], Spreading::InverseSquare).unwrap();
            image[0] * weight.at(angle_rad)
        })
        .sum()
}

fn weighted_images_match_the_weighted_sum(level: SimdLevel) {
    let c = campaign();
    let grid = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [250, 60]).unwrap();
    for (weight, engine, accuracy) in [
        (limit(35.0, 8.0, 0.0), Engine::Direct, 1e-3),
        (limit(35.0, 8.0, 0.0), Engine::Factorized, 2e-3),
        (limit(90.0, 5.0, 4.0), Engine::Auto, 1e-4),
        (limit(50.0, 10.0, 2.0), Engine::Auto, 1e-3),
    ] {
        let options = PlanOptions::default()
            .with_incidence(Some(weight))
            .with_accuracy(accuracy)
            .with_engine(engine)
            .with_level(level);
        let plan = ImagingPlan::new(c.pulses(), grid, &options).unwrap();
        assert_ne!(plan.engine(), Engine::Reference, "{plan}");
        let mut image = vec![Complex32::ZERO; grid.len()];
        plan.run(&mut image, Control::default()).unwrap();
        let chosen: Vec<usize> = (0..grid.len()).step_by(13).collect();
        let found: Vec<_> = chosen
            .iter()
            .map(|&k| Complex64::new(f64::from(image[k].re), f64::from(image[k].im)))
            .collect();
        let wanted: Vec<_> = chosen
            .iter()
            .map(|&k| expected(&c, grid.point_m(k), weight))
            .collect();
        let error = reference::relative_l2(&found, &wanted).unwrap();
        assert!(error <= accuracy, "{error:e} {weight:?}\n{plan}");
        // 4.2 m away at a height of 3 m, 54° off: outside the limit of 35°.
        if weight.max_rad < 0.7 {
            let outside = image[30 * grid.nx + 249];
            assert!(outside.norm() < 1e-3 * image[30 * grid.nx + 40].norm());
        }
    }
}

/// Boresights that roll and pitch by up to 25° from pulse to pulse.
fn boresights(c: &Campaign) -> Vec<[f64; 3]> {
    (0..c.position_m.len())
        .map(|m| {
            let phase = 0.7 * m as f64;
            let [x, y] = [0.35 * phase.sin(), 0.28 * (1.3 * phase).cos()];
            let z = -(1.0 - x * x - y * y).sqrt();
            [x, y, z]
        })
        .collect()
}

/// Eq. (3) with every pulse's data weighted at a pixel by the limit from the vertical and the pattern from
/// the boresight.
fn expected_tilted(
    c: &Campaign,
    boresight: &[[f64; 3]],
    point_m: [f64; 3],
    weight: IncidenceWeight,
) -> Complex64 {
    let limit_alone = IncidenceWeight {
        cosine_power: 0.0,
        ..weight
    };
    let n = c.frequency_hz.len();
    (0..c.position_m.len())
        .map(|m| {
            let p = c.position_m[m];
            let range_m = reference::range_m(p, point_m);
            let along: f64 = (0..3).map(|a| boresight[m][a] * (point_m[a] - p[a])).sum();
            let pattern = (along / range_m).max(0.0).powf(weight.cosine_power);
            let one = Pulses::new(PulseArrays {
                position_m: &c.position_m[m..=m],
                frequency_hz: &c.frequency_hz,
                spectrum: &c.spectrum[m * n..(m + 1) * n],
                weight: &c.weight[m..=m],
                light_speed_m_s: C,
            })
            .unwrap();
            let image = reference::adjoint(&one, &[point_m], Spreading::InverseSquare).unwrap();
            let vertical_rad = ((p[2] - point_m[2]) / range_m).acos();
            image[0] * pattern * limit_alone.at(vertical_rad)
        })
        .sum()
}

fn tilted_patterns_match_the_weighted_sum(level: SimdLevel) {
    let c = campaign();
    let looks = boresights(&c);
    let pulses = c.pulses().with_boresight(&looks).unwrap();
    let fine = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [250, 60]).unwrap();
    // Pixels whose range bins no window of registers holds.
    let coarse = PlaneGrid::new([-4.0, -4.0, 0.0], 0.12, [70, 70]).unwrap();
    for (grid, weight, engine, accuracy) in [
        (fine, limit(90.0, 5.0, 2.0), Engine::Direct, 1e-3),
        (fine, limit(90.0, 5.0, 2.0), Engine::Direct, 1e-5),
        (fine, limit(50.0, 10.0, 1.5), Engine::Direct, 1e-4),
        (coarse, limit(90.0, 5.0, 3.0), Engine::Direct, 1e-4),
        (fine, limit(90.0, 5.0, 4.0), Engine::Factorized, 2e-3),
        (fine, limit(90.0, 5.0, 0.3), Engine::Auto, 1e-3),
        (coarse, limit(60.0, 5.0, 2.0), Engine::Auto, 1e-6),
        (coarse, limit(60.0, 5.0, 2.0), Engine::Reference, 1e-9),
    ] {
        let options = PlanOptions::default()
            .with_incidence(Some(weight))
            .with_accuracy(accuracy)
            .with_engine(engine)
            .with_level(level);
        let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
        if engine != Engine::Reference {
            assert_ne!(plan.engine(), Engine::Reference, "{plan}");
        }
        let mut image = vec![Complex32::ZERO; grid.len()];
        plan.run(&mut image, Control::default()).unwrap();
        let chosen: Vec<usize> = (0..grid.len()).step_by(13).collect();
        let found: Vec<_> = chosen
            .iter()
            .map(|&k| Complex64::new(f64::from(image[k].re), f64::from(image[k].im)))
            .collect();
        let of = |looks: &[[f64; 3]]| -> Vec<Complex64> {
            let at = |&k: &usize| expected_tilted(&c, looks, grid.point_m(k), weight);
            chosen.iter().map(at).collect()
        };
        let error = reference::relative_l2(&found, &of(&looks)).unwrap();
        // The reference comes in single precision.
        assert!(error <= accuracy.max(1e-6), "{error:e} {weight:?}\n{plan}");
        // An antenna that looks straight down gives another image: the tilt is what is tested.
        let down = vec![[0.0, 0.0, -1.0]; looks.len()];
        let difference = reference::relative_l2(&of(&down), &of(&looks)).unwrap();
        assert!(difference > 3.0 * accuracy, "{difference:e}");
    }
}

fn tilted_forward_is_the_adjoint(level: SimdLevel) {
    let c = campaign();
    let looks = boresights(&c);
    let pulses = c.pulses().with_boresight(&looks).unwrap();
    let grid = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [120, 60]).unwrap();
    for (engine, cosine_power) in [
        (Engine::Direct, 2.0),
        (Engine::Factorized, 2.0),
        (Engine::Reference, 2.0),
        (Engine::Direct, 1.5),
    ] {
        let options = PlanOptions::default()
            .with_incidence(Some(limit(60.0, 8.0, cosine_power)))
            .with_level(level)
            .with_engine(engine);
        let mut image = vec![Complex32::ZERO; grid.len()];
        ImagingPlan::new(pulses, grid, &options)
            .unwrap()
            .run(&mut image, Control::default())
            .unwrap();
        let mut echo = vec![Complex64::ZERO; c.spectrum.len()];
        Forward::new(pulses, grid, &options)
            .unwrap()
            .run(&image, &mut echo, Control::default())
            .unwrap();
        // ⟨L L⁺d, d⟩ = ‖L⁺d‖².
        let pairs = echo.iter().zip(&c.spectrum);
        let left: Complex64 = pairs.map(|(e, d)| e * d.conj()).sum();
        let right: f64 = image.iter().map(|v| f64::from(v.norm_sqr())).sum();
        assert!(
            (left.re / right - 1.0).abs() < 1e-3,
            "{engine:?} {left} {right}"
        );
        assert!(left.im.abs() < 1e-3 * right);
    }
}

#[test]
fn pieces_of_the_aperture_keep_their_boresights() {
    let c = campaign();
    let looks = boresights(&c);
    let pulses = c.pulses().with_boresight(&looks).unwrap();
    let grid = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [60, 40]).unwrap();
    let options = PlanOptions::default().with_incidence(Some(limit(90.0, 5.0, 3.0)));
    let image = |pulses| {
        let mut image = vec![Complex32::ZERO; grid.len()];
        let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
        plan.run(&mut image, Control::default()).unwrap();
        image
    };
    let whole = image(pulses);
    let halves = [0..13, 13..30].map(|range| image(pulses.slice(range).unwrap()));
    let wide = |v: &Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
    let sum: Vec<_> = (halves[0].iter().zip(&halves[1]))
        .map(|(a, b)| wide(a) + wide(b))
        .collect();
    let whole: Vec<_> = whole.iter().map(wide).collect();
    assert!(reference::relative_l2(&sum, &whole).unwrap() < 2e-3);
}

#[test]
fn boresights_that_are_none_are_refused() {
    let c = campaign();
    let mut looks = boresights(&c);
    assert!(c.pulses().with_boresight(&looks[1..]).is_err());
    for bad in [[0.0; 3], [0.0, 0.0, -1.1], [f64::NAN, 0.0, -1.0]] {
        looks[7] = bad;
        assert!(c.pulses().with_boresight(&looks).is_err(), "{bad:?}");
    }
}

fn limit(max_deg: f64, taper_deg: f64, cosine_power: f64) -> IncidenceWeight {
    IncidenceWeight {
        max_rad: f64::to_radians(max_deg),
        taper_rad: f64::to_radians(taper_deg),
        cosine_power,
    }
}

#[test]
fn weighted_forward_and_adjoint_are_adjoint() {
    let c = campaign();
    let grid = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [120, 60]).unwrap();
    let options = PlanOptions::default().with_incidence(Some(limit(40.0, 8.0, 2.0)));
    let mut image = vec![Complex32::ZERO; grid.len()];
    ImagingPlan::new(c.pulses(), grid, &options)
        .unwrap()
        .run(&mut image, Control::default())
        .unwrap();
    let mut echo = vec![Complex64::ZERO; c.spectrum.len()];
    Forward::new(c.pulses(), grid, &options)
        .unwrap()
        .run(&image, &mut echo, Control::default())
        .unwrap();
    // ⟨L L⁺d, d⟩ = ‖L⁺d‖².
    let left: Complex64 = echo
        .iter()
        .zip(&c.spectrum)
        .map(|(e, d)| e * d.conj())
        .sum();
    let right: f64 = image.iter().map(|v| f64::from(v.norm_sqr())).sum();
    assert!((left.re / right - 1.0).abs() < 1e-3, "{left} {right}");
    assert!(left.im.abs() < 1e-3 * right);
}

#[test]
fn uneven_ground_and_impossible_angles_are_refused() {
    let c = campaign();
    let base = PlaneGrid::new([-0.5, -0.4, 0.0], 0.02, [50, 60]).unwrap();
    let options = |weight| PlanOptions::default().with_incidence(Some(weight));
    let good = options(limit(40.0, 8.0, 0.0));
    let ground = SurfaceGrid::from_fn(base, |x, _| Ok::<_, ImagingError>(0.1 * x)).unwrap();
    assert_eq!(
        ImagingPlan::new(c.pulses(), &ground, &good).err(),
        Some(ImagingError::NotLevel)
    );
    let tilted = TiltedGrid::new([0.0; 3], [0.01, 0.0, 0.001], [0.0, 0.01, 0.0], 20, 20).unwrap();
    assert_eq!(
        ImagingPlan::new(c.pulses(), tilted, &good).err(),
        Some(ImagingError::NotLevel)
    );
    for bad in [
        limit(0.0, 5.0, 0.0),
        limit(91.0, 5.0, 0.0),
        limit(f64::NAN, 5.0, 0.0),
        limit(40.0, 0.0, 0.0),
        limit(40.0, 5.0, -1.0),
    ] {
        assert!(
            ImagingPlan::new(c.pulses(), base, &options(bad)).is_err(),
            "{bad:?}"
        );
    }
}
