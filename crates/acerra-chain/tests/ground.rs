//! Below the surface: a simulated flight over burials by an independent full-wave program, from its file to the image.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::{Control, Journal, MemorySink};

const TABLES: &str = "
[preprocess]
zero_timing = 'none'
background = { components = 4 }
gate_ns = 'none'
[image]
band_ghz = [0.5, 2.5]
frequencies = 101
x_m = [0.3, 2.1]
y_m = [0.0, 0.0]
z_m = [-0.40, -0.04]
pixel_m = 0.01
pixel_z_m = 0.005
[ground]
relative_permittivity = 4.0
conductivity_s_m = 0.002
";

fn campaign(file: &Path, tables: &str) -> String {
    format!(
        "[radar]\nfile = '{}'\ndelay_ns = 0.77\n{tables}",
        file.display()
    )
}

/// Three buried cylinders, whose places the program's own settings state. The antennas' height changes by 8 cm along the
/// line, so that the surface echo is not the same in all traces: its first singular components are taken off.
#[test]
fn burials_of_a_full_wave_simulation_stand_where_they_are() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/burial-2d/burial-flat.npz");
    if !file.exists() {
        println!("skipped: ../shared/data/burial-2d is absent");
        return;
    }
    let campaign = Campaign::parse(&campaign(&file, TABLES)).unwrap();
    let prepared = (campaign.survey())
        .prepare(&mut Journal::default(), &Control::default())
        .unwrap();
    assert_eq!(prepared.aligned.antennas_from_place_m.len(), 72);
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let mut sink = MemorySink::default();
    prepared
        .image(&request, &mut sink, &Control::default())
        .unwrap();
    let slices = &sink.stacks[0].images;
    let place = |k: usize, i: usize| [0.3 + 0.01 * i as f64, -0.40 + 0.005 * k as f64];
    let strongest = |about: [f64; 2], within_m: f64| {
        let mut best = (0.0, [f64::NAN; 2]);
        for (k, slice) in slices.iter().enumerate() {
            for (i, value) in slice.iter().enumerate() {
                let [x, z] = place(k, i);
                let is_near = (x - about[0]).abs() <= within_m && (z - about[1]).abs() <= within_m;
                if is_near && value.norm() > best.0 {
                    best = (value.norm(), [x, z]);
                }
            }
        }
        best
    };
    let (most, place_of_most) = strongest([1.2, -0.2], 2.0);
    println!("strongest {most:e} at {place_of_most:?}");
    for (x_m, z_m, least_db) in [(0.6, -0.15, -3.0), (1.2, -0.10, -20.0), (1.75, -0.25, -6.0)] {
        let (level, [x, z]) = strongest([x_m, z_m], 0.0401);
        let level_db = 20.0 * f64::from(level / most).log10();
        println!("({x_m}, {z_m}) found at ({x:.3}, {z:.3}), {level_db:.1} dB");
        assert!((x - x_m).abs() <= 0.0101, "{x} {x_m}");
        assert!((z - z_m).abs() <= 0.0151, "{z} {z_m}");
        assert!(level_db >= least_db, "{level_db}");
    }
}

#[test]
fn ground_that_the_command_does_not_know_is_refused() {
    let refused = |from: &str, to: &str| {
        let text = campaign(Path::new("flight.npz"), &TABLES.replace(from, to));
        Campaign::parse(&text).unwrap_err().to_string()
    };
    let permittivity = "relative_permittivity = 4.0";
    for (from, to, expected) in [
        (
            permittivity,
            "relative_permittivity = 'auto'",
            "not found from the data",
        ),
        (permittivity, "relative_permittivity = 0.5", "1 to 100"),
        (permittivity, "", "[[ground.layer]]"),
        (
            permittivity,
            "relative_permittivity = 4.0\nsurface = 'radar'",
            "unknown variant `radar`",
        ),
        ("[image]", "[image]\nmethod = 'cgls'", "exclude each other"),
    ] {
        let found = refused(from, to);
        assert!(found.contains(expected), "{to}: {found}");
    }
}
