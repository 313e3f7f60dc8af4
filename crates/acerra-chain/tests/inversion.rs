//! Every method finds a reflector of a flight in memory, says how, and refuses what it does not make.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_chain::choices::Sum;
use acerra_chain::clean::CleanOptions;
use acerra_chain::findings::weigh_image;
use acerra_chain::focus::inversion::Method;
use acerra_chain::focus::looks::LookOptions;
use acerra_chain::focus::plan::ImageError;
use acerra_chain::{
    Control, ImageRequest, Journal, MemorySink, Pixels, Prepared, Recording, Scene, prepare,
};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S, SurfaceGrid, VolumeGrid};
use acerra_radar::{Radargram, Samples};
use std::sync::atomic::AtomicBool;

const TARGET_M: [f64; 3] = [0.313, 1.02, 0.0];

/// A line of flight along x at `y_m`, 4 m up, over one reflector and a little noise.
fn flight(name: &str, y_m: f64) -> Recording {
    let t_s: Vec<f64> = (0..81).map(|k| 0.05 * f64::from(k)).collect();
    let mut state = 1_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5) * 0.02
    };
    let mut samples = Vec::new();
    for t in &t_s {
        let off = [t - 2.0 - TARGET_M[0], y_m - TARGET_M[1], 4.0];
        let range_m = off[0].hypot(off[1]).hypot(off[2]);
        for n in 0..800 {
            let s = 61e-12 * f64::from(n) - 2.0 * range_m / SPEED_OF_LIGHT_M_S;
            let pulse = (-(s / 0.3e-9).powi(2)).exp() * (std::f64::consts::TAU * 4e9 * s).cos();
            samples.push((pulse + noise()) as f32);
        }
    }
    let fixes = t_s.iter().map(|t| Fix::new(*t, [t - 2.0, y_m, 4.0]));
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap();
    let radargram = Radargram::new(t_s, 0.0, 61e-12, Samples::Real(samples)).unwrap();
    Recording::new(name, radargram, trajectory).clean_by(CleanOptions::none())
}

fn prepared(flights: Vec<Recording>) -> Prepared {
    let scene = Scene::plane(grid());
    let calibration = Default::default();
    let control = Control::default();
    prepare(
        flights,
        scene,
        &calibration,
        &mut Journal::default(),
        &control,
    )
    .unwrap()
}

fn grid() -> PlaneGrid {
    PlaneGrid::from_ranges([0.0, 0.6], [0.5, 1.5], 0.0, 0.025).unwrap()
}

fn request(method: Method, pixels: impl Into<Pixels>) -> ImageRequest {
    let mut request = ImageRequest::on(pixels);
    request.options.inversion.method = method;
    request
}

#[test]
fn every_method_finds_the_reflector_and_says_how() {
    let prepared = prepared(vec![flight("one", 0.0)]);
    let control = Control::default();
    let sloped = SurfaceGrid::from_fn(grid(), |x_m, _| {
        Ok::<_, acerra_imaging::ImagingError>(0.1 * (x_m - TARGET_M[0]))
    });
    let sloped = Pixels::surface(sloped.unwrap());
    for method in [Method::Tsvd, Method::Cgls, Method::Sparse, Method::Clean] {
        for pixels in [Pixels::plane(grid()), sloped.clone()] {
            let request = request(method, pixels);
            let focused = prepared
                .image(&request, &mut MemorySink::default(), &control)
                .unwrap();
            let [x_m, y_m, _] = focused.maximum_m();
            assert!((x_m - TARGET_M[0]).abs() < 0.03, "{method:?}: {x_m}");
            assert!((y_m - TARGET_M[1]).abs() < 0.10, "{method:?}: {y_m}");
            let record = focused.inversion.as_ref().unwrap();
            assert_eq!(record.method, method);
            assert!(record.residual < 0.9 && !record.iterations.is_empty());
            assert!(record.noise.is_some_and(|noise| noise.cells >= 64));
            let resolution = record.resolution.first().unwrap();
            assert!(
                resolution
                    .adjoint
                    .is_some_and(|r| (r.peak - 1.0).abs() < 0.05)
            );
            assert!(resolution.method.is_some());
            let findings = weigh_image(&prepared, &focused, &control).unwrap();
            for name in ["inversion_converged", "inversion_residual"] {
                assert!(
                    findings.iter().any(|finding| finding.name == name),
                    "{name}"
                );
            }
        }
    }
    let adjoint = request(Method::Adjoint, grid());
    let focused = prepared
        .image(&adjoint, &mut MemorySink::default(), &control)
        .unwrap();
    assert!(focused.inversion.is_none());
}

#[test]
fn several_tracks_and_slices_are_solved_for_together() {
    let prepared = prepared(vec![flight("one", 0.0), flight("two", -0.5)]);
    let control = Control::default();
    let joint = request(Method::Cgls, grid());
    let focused = prepared
        .image(&joint, &mut MemorySink::default(), &control)
        .unwrap();
    assert!((focused.maximum_m()[0] - TARGET_M[0]).abs() < 0.03);
    let mut grouped = request(Method::Sparse, grid());
    grouped.options.sum = Sum::Incoherent;
    let focused = prepared
        .image(&grouped, &mut MemorySink::default(), &control)
        .unwrap();
    assert!((focused.maximum_m()[0] - TARGET_M[0]).abs() < 0.03);
    let volume = VolumeGrid::new(
        PlaneGrid::from_ranges([0.1, 0.5], [0.8, 1.2], -0.2, 0.05).unwrap(),
        0.2,
        3,
    );
    let mut sink = MemorySink::default();
    let volume = request(Method::Tsvd, Pixels::volume(volume.unwrap()));
    let focused = prepared.image(&volume, &mut sink, &control).unwrap();
    assert_eq!(sink.stacks[0].images.len(), 3);
    assert!(focused.projections.is_some());
}

#[test]
fn what_is_not_solved_for_is_refused_by_name() {
    let prepared = prepared(vec![flight("one", 0.0), flight("two", -0.5)]);
    let refused = |request: &ImageRequest| {
        let mut sink = MemorySink::default();
        prepared
            .image(request, &mut sink, &Control::default())
            .unwrap_err()
    };
    let mut looks = request(Method::Tsvd, grid());
    looks.looks = Some(LookOptions {
        count: 2,
        overlap: 0.0,
        taper: Default::default(),
    });
    let mut powers = request(Method::Clean, grid());
    powers.options.sum = Sum::Incoherent;
    let volume = VolumeGrid::new(grid(), 0.1, 2).unwrap();
    let volume = request(Method::Clean, Pixels::volume(volume));
    for (request, part) in [
        (looks, "looks"),
        (powers, "incoherent"),
        (volume, "a volume"),
    ] {
        let message = refused(&request).to_string();
        assert!(message.starts_with("[image] method = \""), "{message}");
        assert!(
            message.contains("expected") && message.contains(part),
            "{message}"
        );
    }
    let stop = AtomicBool::new(true);
    let control = Control::default().cancelled_by(&stop);
    let cancelled = request(Method::Sparse, grid());
    let error = prepared
        .image(&cancelled, &mut MemorySink::default(), &control)
        .unwrap_err();
    assert!(matches!(error, ImageError::Cancelled(_)), "{error}");
}
