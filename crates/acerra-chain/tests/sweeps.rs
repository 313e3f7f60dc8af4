//! A flight of one Touchstone file a sweep, placed by a table that numbers the files.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::measure::MeasureOptions;
use acerra_chain::{ChainError, Control, Journal, MemorySink, Prepared};

const LIGHT_M_S: f64 = 299_792_458.0;
const BAND_HZ: [f64; 2] = [5.75e9, 6.25e9];
const FREQUENCIES: usize = 81;
const TRACES: usize = 201;
const HALF_PATH_M: f64 = 2.5;
const HEIGHT_M: f64 = 5.0;
/// Reflectors on the ground: east, north (m).
const REFLECTORS_M: [[f64; 2]; 2] = [[0.3, 6.0], [-1.213, 8.107]];

fn place_m(trace: usize) -> [f64; 3] {
    let share = trace as f64 / (TRACES - 1) as f64;
    [HALF_PATH_M * (2.0 * share - 1.0), 0.0, HEIGHT_M]
}

/// Writes the sweeps and the table of their places.
fn write(folder: &Path) {
    let mut table = "trace,x_m,y_m,z_m\n".to_owned();
    for trace in 0..TRACES {
        let [x, y, z] = place_m(trace);
        let delay_s = |[e, n]: [f64; 2]| 2.0 * (x - e).hypot(y - n).hypot(z) / LIGHT_M_S;
        let mut sweep = "# Hz S RI R 50\n".to_owned();
        for n in 0..FREQUENCIES {
            let share = n as f64 / (FREQUENCIES - 1) as f64;
            let hz = BAND_HZ[0] + (BAND_HZ[1] - BAND_HZ[0]) * share;
            let turns = REFLECTORS_M.map(|place| TAU * (hz * delay_s(place)).fract());
            let re: f64 = turns.iter().map(|turn| turn.cos()).sum();
            let im: f64 = turns.iter().map(|turn| -turn.sin()).sum();
            writeln!(sweep, "{hz} {re:.8} {im:.8}").unwrap();
        }
        // Numbers in names count by their value: sweep-10 comes after sweep-9.
        fs::write(folder.join(format!("sweep-{trace}.s1p")), sweep).unwrap();
        writeln!(table, "{},{x},{y},{z}", trace + 1).unwrap();
    }
    fs::write(folder.join("places.csv"), table).unwrap();
}

fn campaign(folder: &Path, tables: &str) -> Campaign {
    let text = format!(
        "[radar]\nfiles = 'sweep-*.s1p'\n{tables}[image]\nx_m = [-2.0, 1.0]\ny_m = [5.0, 9.0]\nz_m = 0\n\
         pixel_m = 0.01\n"
    );
    Campaign::parse(&text).unwrap().resolved_in(folder)
}

const PLACES: &str = "[trajectory]\nfile = 'places.csv'\n";

fn prepared(campaign: &Campaign) -> Result<Prepared, ChainError> {
    (campaign.survey()).prepare(&mut Journal::default(), &Control::default())
}

#[test]
fn a_flight_of_one_sweep_a_file_puts_reflectors_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let campaign = campaign(folder.path(), PLACES);
    let prepared = prepared(&campaign).unwrap();
    assert_eq!(prepared.aligned.traces.len(), TRACES);
    let control = Control::default();
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let focused = prepared
        .image(&request, &mut MemorySink::default(), &control)
        .unwrap();
    let found = prepared
        .measure(&focused, &MeasureOptions::from(&campaign.measure), &control)
        .unwrap();
    for [e, n] in REFLECTORS_M {
        let range_m = n.hypot(HEIGHT_M);
        let wavelength_m = LIGHT_M_S / (0.5 * (BAND_HZ[0] + BAND_HZ[1]));
        // Along the track by the aperture's angle, across it by the band, on the ground.
        let along_m = 0.5 * wavelength_m * range_m / (2.0 * HALF_PATH_M);
        let across_m = 0.5 * LIGHT_M_S / (BAND_HZ[1] - BAND_HZ[0]) * range_m / n;
        let is_there = found
            .targets
            .iter()
            .any(|t| (t.x_m - e).abs() < 0.1 * along_m && (t.y_m - n).abs() < 0.1 * across_m);
        assert!(is_there, "{e} {n}: {:?}", found.targets);
    }
}

#[test]
fn sweeps_that_do_not_belong_together_or_have_no_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let refused = |tables: &str| {
        prepared(&campaign(folder.path(), tables))
            .unwrap_err()
            .to_string()
    };
    let found = refused("");
    assert!(
        found.contains("a [trajectory] file with a column trace, found none"),
        "{found}"
    );
    let other = "# Hz S RI R 50\n5.75e9 1 0\n6.25e9 1 0\n";
    fs::write(folder.path().join("sweep-7.s1p"), other).unwrap();
    let found = refused(PLACES);
    let expected = "sweep-7.s1p: frequencies: expected 81 as in sweep-0.s1p, found 2";
    assert!(found.contains(expected), "{found}");
}
