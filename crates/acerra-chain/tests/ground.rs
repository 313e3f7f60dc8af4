//! Below the surface: a simulated flight over burials by an independent full-wave program, from its file to the image.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::{Control, Journal, MemorySink};

const TABLES: &str = "
[preprocess]
zero_timing = 'none'
BACKGROUND
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

/// Level ground is level by its first echoes too, and burials are where they are below it.
#[test]
fn the_radar_finds_level_ground_level() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/burial-2d/burial-flat.npz");
    if !file.exists() {
        println!("skipped: ../shared/data/burial-2d is absent");
        return;
    }
    let tables = TABLES.replace("BACKGROUND", "") + "surface = 'radar'\n";
    let campaign = Campaign::parse(&campaign(&file, &tables)).unwrap();
    let prepared = (campaign.survey())
        .prepare(&mut Journal::default(), &Control::default())
        .unwrap();
    let heights_m: Vec<f64> = (0..=36)
        .map(|k| {
            prepared
                .scene
                .ground
                .below_m(0.3 + 0.05 * f64::from(k), 0.0)
        })
        .collect();
    let mean_m = heights_m.iter().sum::<f64>() / heights_m.len() as f64;
    let most_m = heights_m
        .iter()
        .map(|z| (z - mean_m).abs())
        .fold(0.0, f64::max);
    assert!(most_m < 2e-3, "{heights_m:?}");
    // The pulse is a third of a nanosecond later than the stated zero of fast time.
    assert!(mean_m.abs() < 0.06, "{mean_m}");
}

/// Places (x, z, m) and levels (dB below the strongest pixel) of the strongest pixel within 4 cm of each of `about`.
fn strongest_near(file: &Path, background: &str, about: &[[f64; 2]]) -> Vec<([f64; 2], f64)> {
    let tables = TABLES.replace("BACKGROUND", background);
    let campaign = Campaign::parse(&campaign(file, &tables)).unwrap();
    let prepared = (campaign.survey())
        .prepare(&mut Journal::default(), &Control::default())
        .unwrap();
    assert_eq!(prepared.aligned.antennas_from_place_m.len(), 72);
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let mut sink = MemorySink::default();
    prepared
        .image(&request, &mut sink, &Control::default())
        .unwrap();
    let pixels: Vec<([f64; 2], f64)> = (sink.stacks[0].images.iter().enumerate())
        .flat_map(|(k, slice)| {
            let place = move |i: usize| [0.3 + 0.01 * i as f64, -0.40 + 0.005 * k as f64];
            let values = slice.iter().enumerate();
            values.map(move |(i, value)| (place(i), f64::from(value.norm())))
        })
        .collect();
    let most = pixels.iter().map(|(_, v)| *v).fold(0.0, f64::max);
    let near = |[x_m, z_m]: [f64; 2]| {
        let is_near = |[x, z]: [f64; 2]| (x - x_m).abs() <= 0.0401 && (z - z_m).abs() <= 0.0401;
        let candidates = pixels.iter().filter(|(place, _)| is_near(*place));
        let best = candidates.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        (best.0, 20.0 * (best.1 / most).log10())
    };
    about.iter().copied().map(near).collect()
}

/// Buried cylinders, whose places the program's own settings state: two of metal, and one of plastic, 15 dB weaker. By
/// default the echo of the surface leaves with the coupling, and the plastic one is found too: its top, as the wave enters
/// it. With the mean alone, what is left of the surface is stronger than it, as the height changes by 8 cm.
#[test]
fn burials_of_a_full_wave_simulation_are_found_where_they_are() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/burial-2d/burial-flat.npz");
    if !file.exists() {
        println!("skipped: ../shared/data/burial-2d is absent");
        return;
    }
    let about = [[0.6, -0.15], [1.75, -0.25], [1.2, -0.10]];
    for (background, found_there) in [("", 3), ("background = 'mean'", 2)] {
        let found = strongest_near(&file, background, &about);
        println!("{background}: {found:?}");
        for ([x_m, z_m], ([x, z], level_db)) in about.into_iter().zip(found).take(found_there) {
            assert!((x - x_m).abs() <= 0.0101, "{background}: {x} {x_m}");
            assert!((z - z_m).abs() <= 0.0151, "{background}: {z} {z_m}");
            assert!(level_db >= -16.0, "{background}: {level_db}");
        }
    }
}

#[test]
fn ground_that_the_command_does_not_know_is_refused() {
    let refused = |from: &str, to: &str| {
        let text = campaign(
            Path::new("flight.npz"),
            &TABLES.replace("BACKGROUND", "").replace(from, to),
        );
        Campaign::parse(&text).unwrap_err().to_string()
    };
    let permittivity = "relative_permittivity = 4.0";
    for (from, to, expected) in [
        (permittivity, "relative_permittivity = 'wet'", "or \"auto\""),
        (permittivity, "relative_permittivity = 0.5", "1 to 100"),
        (permittivity, "", "[[ground.layer]]"),
        (
            permittivity,
            "relative_permittivity = 4.0\nsurface = 'sea'",
            "unknown variant `sea`",
        ),
        ("[image]", "[image]\nmethod = 'cgls'", "exclude each other"),
    ] {
        let found = refused(from, to);
        assert!(found.contains(expected), "{to}: {found}");
    }
}

/// The permittivity of the full-wave simulation is found from its burials, with a deviation.
#[test]
fn the_permittivity_of_a_full_wave_simulation_is_found() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/burial-2d/burial-flat.npz");
    if !file.exists() {
        println!("skipped: ../shared/data/burial-2d is absent");
        return;
    }
    let tables = TABLES.replace("BACKGROUND", "").replace(
        "relative_permittivity = 4.0",
        "relative_permittivity = 'auto'",
    );
    let campaign = Campaign::parse(&campaign(&file, &tables)).unwrap();
    let prepared = (campaign.survey())
        .prepare(&mut Journal::default(), &Control::default())
        .unwrap();
    let found = prepared.permittivity.unwrap();
    println!("{found:?}");
    assert!((found.value / 4.0 - 1.0).abs() < 0.05, "{found:?}");
    assert!(
        (found.value - 4.0).abs() < 2.0 * found.sigma && found.sigma < 0.8,
        "{found:?}"
    );
    let settled = campaign.with_found(&prepared).ground.unwrap();
    let given = settled.relative_permittivity.unwrap().given();
    assert_eq!(given, Some(found.value));
}
