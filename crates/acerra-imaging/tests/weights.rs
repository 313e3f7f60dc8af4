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

at_every_level!(weighted_images_match_the_weighted_sum);

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
