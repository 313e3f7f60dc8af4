//! Simulated flights of an FMCW radar and of a network analyser, from their files to measured reflectors.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::measure::MeasureOptions;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_imaging::Complex64;
use acerra_imaging::metrics::Measurement;
use acerra_npz::NpzWriter;

const LIGHT_M_S: f64 = 299_792_458.0;
/// 6 GHz, 500 MHz.
const BAND_HZ: [f64; 2] = [5.75e9, 6.25e9];
/// Reflectors on the ground: east, north (m).
const REFLECTORS_M: [[f64; 2]; 2] = [[0.3, 6.0], [-1.213, 8.107]];
const HEIGHT_M: f64 = 5.0;
const HALF_PATH_M: f64 = 4.0;
const TRACES: usize = 321;

fn place_m(trace: usize) -> [f64; 3] {
    let share = trace as f64 / (TRACES - 1) as f64;
    [HALF_PATH_M * (2.0 * share - 1.0), 0.0, HEIGHT_M]
}

/// Two-way delays of the reflectors at a trace (s).
fn delays_s(trace: usize) -> [f64; 2] {
    let [x, y, z] = place_m(trace);
    REFLECTORS_M.map(|[e, n]| 2.0 * (x - e).hypot(y - n).hypot(z) / LIGHT_M_S)
}

/// A campaign with this table `[radar]`, and what follows it.
fn campaign(folder: &Path, radar: &str) -> Campaign {
    let text = format!(
        "[radar]\n{radar}\n[image]\nx_m = [-2.0, 1.0]\ny_m = [5.0, 9.0]\nz_m = 0\npixel_m = 0.01\n"
    );
    Campaign::parse(&text).unwrap().resolved_in(folder)
}

/// Number of traces of a campaign, and the targets of its image.
fn measured(campaign: &Campaign) -> (usize, Measurement) {
    let control = Control::default();
    let survey = campaign.survey();
    let prepared = survey.prepare(&mut Journal::default(), &control).unwrap();
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let focused = prepared
        .image(&request, &mut MemorySink::default(), &control)
        .unwrap();
    let found = prepared
        .measure(&focused, &MeasureOptions::from(&campaign.measure), &control)
        .unwrap();
    (prepared.aligned.traces.len(), found)
}

/// Whether the reflectors are measured within a tenth of the resolution of where they are.
fn assert_found(folder: &Path, radar: &str) {
    let (traces, found) = measured(&campaign(folder, radar));
    assert_eq!(traces, TRACES);
    for [e, n] in REFLECTORS_M {
        let ground_range_m = n;
        let range_m = ground_range_m.hypot(HEIGHT_M);
        let wavelength_m = LIGHT_M_S / (0.5 * (BAND_HZ[0] + BAND_HZ[1]));
        // Along the track by the aperture's angle, across it by the band, on the ground.
        let along_m = 0.5 * wavelength_m * range_m / (2.0 * HALF_PATH_M);
        let across_m = 0.5 * LIGHT_M_S / (BAND_HZ[1] - BAND_HZ[0]) * range_m / ground_range_m;
        let off = |t: &acerra_imaging::metrics::Target| [(t.x_m - e).abs(), (t.y_m - n).abs()];
        let nearest = (found.targets.iter())
            .map(off)
            .min_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])))
            .unwrap();
        assert!(
            nearest[0] < 0.1 * along_m && nearest[1] < 0.1 * across_m,
            "{nearest:?} of {along_m} and {across_m}: {:?}",
            found.targets
        );
    }
}

#[test]
fn an_fmcw_flight_puts_reflectors_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let (slope, rate_hz, samples) = (5e11, 1e6, 1000_usize);
    let mut beat = Vec::new();
    for trace in 0..TRACES {
        let delays = delays_s(trace);
        beat.extend((0..samples).map(|k| {
            // What is sent, times the conjugate of what comes back: e^{j2π(f₀τ + S t τ − S τ²/2)}.
            let t = k as f64 / rate_hz;
            let of = |tau: &f64| {
                let turns = BAND_HZ[0] * tau + slope * t * tau - 0.5 * slope * tau * tau;
                if t >= *tau {
                    Complex64::from_polar(1.0, TAU * turns.fract())
                } else {
                    Complex64::default()
                }
            };
            delays.iter().map(of).sum::<Complex64>()
        }));
    }
    let mut npz = NpzWriter::stored(File::create(folder.path().join("fmcw.npz")).unwrap());
    npz.array("beat", &[TRACES as u64, samples as u64], beat)
        .unwrap();
    for (name, value) in [
        ("start_frequency_hz", BAND_HZ[0]),
        ("slope_hz_per_s", slope),
        ("sample_rate_hz", rate_hz),
    ] {
        npz.array(name, &[1], [value]).unwrap();
    }
    let places = (0..TRACES).flat_map(place_m).collect::<Vec<f64>>();
    npz.array("position_m", &[TRACES as u64, 3], places)
        .unwrap();
    npz.finish().unwrap();
    assert_found(folder.path(), "file = 'fmcw.npz'");
}

#[test]
fn a_stepped_frequency_flight_puts_reflectors_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = "Frequency (Hz)".to_owned();
    for trace in 0..TRACES {
        let _ = write!(table, ",S11 {0} re,S11 {0} im", trace + 1);
    }
    let frequencies = 101;
    for n in 0..frequencies {
        let hz = BAND_HZ[0] + (BAND_HZ[1] - BAND_HZ[0]) * n as f64 / (frequencies - 1) as f64;
        let _ = write!(table, "\n{hz}");
        for trace in 0..TRACES {
            let echo = |tau: &f64| Complex64::from_polar(1.0, -TAU * (hz * tau).fract());
            let z: Complex64 = delays_s(trace).iter().map(echo).sum();
            let _ = write!(table, ",{:.8},{:.8}", z.re, z.im);
        }
    }
    std::fs::write(folder.path().join("sweeps.csv"), table + "\n").unwrap();
    let line = format!(
        "file = 'sweeps.csv'\nline_start_m = {:?}\nline_end_m = {:?}",
        place_m(0),
        place_m(TRACES - 1)
    );
    assert_found(folder.path(), &line);
}

/// One Touchstone file a sweep, and a table of their places.
fn write_sweeps(folder: &Path) {
    let mut table = "trace,x_m,y_m,z_m\n".to_owned();
    for trace in 0..TRACES {
        let delays = delays_s(trace);
        let mut sweep = "# Hz S RI R 50\n".to_owned();
        for n in 0..81 {
            let hz = BAND_HZ[0] + (BAND_HZ[1] - BAND_HZ[0]) * f64::from(n) / 80.0;
            let echo = |tau: &f64| Complex64::from_polar(1.0, -TAU * (hz * tau).fract());
            let z: Complex64 = delays.iter().map(echo).sum();
            let _ = writeln!(sweep, "{hz} {:.8} {:.8}", z.re, z.im);
        }
        // Numbers in names count by their value: sweep-10 comes after sweep-9.
        std::fs::write(folder.join(format!("sweep-{trace}.s1p")), sweep).unwrap();
        let [x, y, z] = place_m(trace);
        let _ = writeln!(table, "{},{x},{y},{z}", trace + 1);
    }
    std::fs::write(folder.join("places.csv"), table).unwrap();
}

const SWEEPS: &str = "files = 'sweep-*.s1p'";
const PLACED_SWEEPS: &str = "files = 'sweep-*.s1p'\n[trajectory]\nfile = 'places.csv'";

#[test]
fn a_flight_of_one_sweep_a_file_puts_reflectors_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    write_sweeps(folder.path());
    assert_found(folder.path(), PLACED_SWEEPS);
}

#[test]
fn sweeps_that_do_not_belong_together_or_have_no_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_sweeps(folder.path());
    let refused = |radar: &str| {
        let survey = campaign(folder.path(), radar).survey();
        let prepared = survey.prepare(&mut Journal::default(), &Control::default());
        prepared.unwrap_err().to_string()
    };
    let found = refused(SWEEPS);
    let expected = "a [trajectory] file with a column trace, found none";
    assert!(found.contains(expected), "{found}");
    let other = "# Hz S RI R 50\n5.75e9 1 0\n6.25e9 1 0\n";
    std::fs::write(folder.path().join("sweep-7.s1p"), other).unwrap();
    let found = refused(PLACED_SWEEPS);
    let expected = "sweep-7.s1p: frequencies: expected 81 as in sweep-0.s1p, found 2";
    assert!(found.contains(expected), "{found}");
}

/// A run of gprMax 4.0.1 in a plane: a metal bar of radius 1 cm in air whose near side is 0.3 m below antennas 6 cm
/// apart, 61 traces 1 cm apart, a Ricker pulse of 1.5 GHz; every second sample of the merged output.
const GPRMAX: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/gprmax/antennas-apart.h5"
);

/// Place of the strongest target of the gprMax scene, x and z (m).
fn gprmax_target_m(radar: &str) -> [f64; 2] {
    let text = format!(
        "[radar]\nfile = '{GPRMAX}'\n{radar}\n[preprocess]\nzero_timing = 'direct-wave'\nbackground = 'mean'\n\
         gate_ns = 'none'\n[image]\nx_m = [0.2, 0.8]\ny_m = [0, 0]\nz_m = [0.05, 0.40]\npixel_m = 0.005\n\
         band_ghz = [0.6, 3.0]\nfrequencies = 60\n"
    );
    let (_, found) = measured(&Campaign::parse(&text).unwrap());
    let first = &found.targets[0];
    [first.x_m, first.z_m]
}

#[test]
fn a_bar_simulated_by_gprmax_is_where_it_is_with_antennas_apart() {
    let [x_m, z_m] = gprmax_target_m("");
    assert!(
        (x_m - 0.5).abs() < 0.005 && (z_m - 0.2).abs() < 0.005,
        "{x_m} {z_m}"
    );
    // Antennas in one place: the direct wave is taken for range zero, and the bar is too near.
    let [x_m, z_m] = gprmax_target_m("antenna_offset_m = [0.001, 0, 0]");
    assert!((x_m - 0.5).abs() < 0.005 && z_m - 0.2 > 0.02, "{x_m} {z_m}");
}
