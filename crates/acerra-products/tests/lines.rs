//! Drawings and maps of a grid: each line is a piece of its own.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs::{self, File};

use acerra_chain::{Control, Journal};
use acerra_formats::Positions;
use acerra_formats::segy::{SegyTraces, write_segy};
use acerra_products::run_campaign;

const TRACES: usize = 20;
const SAMPLES: usize = 128;

#[test]
fn the_way_from_line_to_line_is_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    for line in 0..3 {
        let values: Vec<f32> = (0..TRACES * SAMPLES)
            .map(|i| {
                let (trace, k) = (i / SAMPLES, i % SAMPLES);
                let t = k as f64 - 60.0 - 0.1 * (trace as f64 - 10.0).powi(2);
                ((-(t / 4.0).powi(2)).exp() * (0.6 * t).cos() * 100.0) as f32
            })
            .collect();
        let place = |k: usize| [50.0 + 2e-6 * line as f64, 7.0 + 1e-6 * k as f64, 101.0];
        let traces = SegyTraces {
            values: &values,
            samples: SAMPLES,
            step_s: 100e-12,
            start_s: 0.0,
            positions: Some(&Positions::Geodetic((0..TRACES).map(place).collect())),
            antennas_m: None,
            text: &[],
        };
        let path = folder.path().join(format!("line-{line}.sgy"));
        write_segy(&mut File::create(path).unwrap(), &traces).unwrap();
    }
    let campaign = folder.path().join("grid.toml");
    fs::write(
        &campaign,
        "[radar]\nfiles = 'line-*.sgy'\ndelay_ns = 0.0\n[preprocess]\ngate_ns = 'none'\n\
         [image]\nband_ghz = [0.5, 1.5]\nfrequencies = 31\nx_m = [0, 1.3]\ny_m = [0, 0.5]\nz_m = -1.0\n\
         pixel_m = 0.1\n[checks]\ncontradictions = 'warn'\n[products]\nformats = ['kmz', 'geojson']\n",
    )
    .unwrap();
    let products = folder.path().join("products");
    run_campaign(
        &campaign,
        &products,
        &mut Journal::default(),
        &Control::default(),
    )
    .unwrap();
    let text = |name: &str| fs::read_to_string(products.join(name)).unwrap();
    let flight: serde_json::Value = serde_json::from_str(&text("flight.geojson")).unwrap();
    let features = flight["features"].as_array().unwrap().iter();
    let lines: Vec<_> = features
        .filter(|feature| feature["properties"]["name"] == "track 1")
        .map(|feature| feature["geometry"]["coordinates"].as_array().unwrap())
        .collect();
    assert_eq!(lines.len(), 3);
    for line in lines {
        assert_eq!(line.len(), TRACES);
        let latitude_deg = |place: &serde_json::Value| place[1].as_f64().unwrap();
        let off_deg = latitude_deg(&line[0]) - latitude_deg(&line[TRACES - 1]);
        assert!(off_deg.abs() < 1e-7, "{off_deg}");
    }
    let record: serde_json::Value = serde_json::from_str(&text("run.json")).unwrap();
    assert_eq!(
        record["traces"]["line_starts"],
        serde_json::json!([TRACES, 2 * TRACES])
    );
}
