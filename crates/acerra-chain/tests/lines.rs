//! Lines of a grid: several files as one recording, with breaks between the lines.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs::File;
use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::findings::{Evidence, weigh_unchecked};
use acerra_chain::measure::MeasureOptions;
use acerra_chain::{Control, Journal, MemorySink, Prepared};
use acerra_formats::segy::{SegyTraces, write_segy};
use acerra_radar::Samples;

const SAMPLES: usize = 64;

/// Writes a line of traces that all hold `level` as coupling in sample 20, and trace `echo` 1 more in sample 40.
fn write_line(path: &Path, traces: usize, level: f32, echo: usize) {
    let mut values = vec![0.0; traces * SAMPLES];
    for row in values.chunks_exact_mut(SAMPLES) {
        row[20] = level;
    }
    values[echo * SAMPLES + 40] = 1.0;
    let line = SegyTraces {
        values: &values,
        samples: SAMPLES,
        step_s: 100e-12,
        start_s: 0.0,
        positions: None,
        antennas_m: None,
        text: &[],
    };
    write_segy(&mut File::create(path).unwrap(), &line).unwrap();
}

fn prepared(folder: &Path, tables: &str) -> Prepared {
    let campaign = Campaign::parse(&format!(
        "[radar]\nfiles = '{}/line-*.sgy'\ndelay_ns = 0\nline_start_m = [0, 0, 1]\nline_end_m = [4, 0, 1]\n\
         line_step_m = [0, 0.5, 0]\n[image]\nx_m = [0, 4]\ny_m = [-1, 2]\nz_m = 0\npixel_m = 0.5\n\
         band_ghz = [1.0, 2.0]\nfrequencies = 11\n[preprocess]\ngate_ns = 'none'\n{tables}",
        folder.display()
    ));
    let survey = campaign.unwrap().survey();
    survey
        .prepare(&mut Journal::default(), &Control::default())
        .unwrap()
}

#[test]
fn lines_are_breaks_for_path_and_background() {
    let folder = tempfile::tempdir().unwrap();
    // Coupling differs from line to line, as on another day.
    for (k, traces) in [9, 5, 17].into_iter().enumerate() {
        let path = folder.path().join(format!("line-{}.sgy", k + 1));
        write_line(&path, traces, 5.0 + k as f32, 2);
    }
    let of_window = prepared(folder.path(), "background = { window = 1001 }\n");
    let aligned = &of_window.aligned;
    assert_eq!(aligned.line_starts, [9, 14]);
    // Three lines of 4 m; the ways of 4.03 m between the lines do not count.
    let path_m: f64 = aligned.path_m.iter().sum();
    assert!((path_m - 12.0).abs() < 1e-9, "{path_m}");
    assert!((aligned.path_m[8] - 0.25).abs() < 1e-9);
    assert!((aligned.path_m[9] - 0.5).abs() < 1e-9);
    // A window ends with its line: nothing is left of the coupling, and an echo keeps all but its own share.
    let clean = &of_window.cleaned().unwrap().clean;
    let Samples::Real(values) = &clean.samples else {
        panic!("complex samples")
    };
    let at = |trace: usize, sample: usize| values[trace * SAMPLES + sample];
    assert!((0..31).all(|trace| at(trace, 20).abs() < 1e-5));
    for (first, traces) in [(0, 9.0), (9, 5.0), (14, 17.0)] {
        assert!((at(first + 2, 40) - (1.0 - 1.0 / traces)).abs() < 1e-5);
        assert!((at(first + 3, 40) + 1.0 / traces).abs() < 1e-5);
    }
    // The mean is what all lines have in common.
    let of_all = prepared(folder.path(), "background = 'mean'\n");
    let clean = &of_all.cleaned().unwrap().clean;
    let expected = 5.0 - (9.0 * 5.0 + 5.0 * 6.0 + 17.0 * 7.0) / 31.0;
    assert!((clean.samples.at(20).re - expected).abs() < 1e-5);
}

/// Ways of echoes are ranges in air, and below the surface the optical length of the refracted ray.
#[test]
fn ways_are_refracted_below_ground() {
    let folder = tempfile::tempdir().unwrap();
    write_line(&folder.path().join("line-1.sgy"), 9, 5.0, 2);
    let tables = "[ground]\nrelative_permittivity = 4.0\nsurface_z_m = 0.0\n";
    let prepared = prepared(folder.path(), tables);
    let ways_m = |tables: &str, place_m: [f64; 3]| {
        let text = format!("[radar]\nfile = 'line-1.sgy'\n{tables}");
        let campaign = Campaign::parse(&text).unwrap();
        let request = campaign.image_request(prepared.scene.pixels.clone());
        prepared.half_ways_m(&request, place_m).unwrap()
    };
    // The third trace is 1 m above (1, 0); straight down the index is 2.
    let down_m = ways_m(tables, [1.0, 0.0, -0.3]);
    assert!((down_m[2] - 1.6).abs() < 1e-9, "{}", down_m[2]);
    // By Fermat's principle no crossing of the surface is earlier than that of the ray.
    let crossings_m = (0..=3000).map(|k| 1e-3 * f64::from(k));
    let over = |x_m: f64| x_m.hypot(1.0) + 2.0 * (3.0 - x_m).hypot(0.3);
    let earliest_m = crossings_m.map(over).fold(f64::INFINITY, f64::min);
    assert!((down_m[8] - earliest_m).abs() < 1e-6, "{}", down_m[8]);
    let above_m = ways_m(tables, [1.0, 0.0, 0.2]);
    assert!((above_m[8] - 3f64.hypot(0.8)).abs() < 1e-9);
    let in_air_m = ways_m("", [1.0, 0.0, -0.3]);
    assert!((in_air_m[2] - 1.3).abs() < 1e-9);
}

/// Prepares line 1 of `folder` with positions from `positions.csv`.
fn prepared_by_table(folder: &Path, tables: &str) -> Result<Prepared, String> {
    let campaign = Campaign::parse(&format!(
        "[radar]\nfile = '{0}/line-1.sgy'\ndelay_ns = 0\n[trajectory]\nfile = '{0}/positions.csv'\n{tables}\
         [image]\nx_m = [0, 4]\ny_m = [-1, 2]\nz_m = 0\npixel_m = 0.5\nband_ghz = [1.0, 2.0]\nfrequencies = 11\n\
         [preprocess]\ngate_ns = 'none'\n",
        folder.display()
    ));
    let survey = campaign.unwrap().survey();
    survey
        .prepare(&mut Journal::default(), &Control::default())
        .map_err(|error| error.to_string())
}

#[test]
fn a_table_places_traces_by_their_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write_line(&folder.path().join("line-1.sgy"), 9, 5.0, 2);
    let write = |rows: &str| {
        let text = format!("trace,x_m,y_m,z_m\n{rows}");
        std::fs::write(folder.path().join("positions.csv"), text).unwrap();
    };
    // Every second trace; those between lie between.
    write("1,0,0,1\n3,0.5,0,1\n5,1.0,0,1\n7,1.5,0,1\n9,2.0,0,1\n");
    let found = prepared_by_table(folder.path(), "").unwrap();
    assert_eq!(found.tracks[0].time_offset_s, 0.0);
    // Without a clock no offset is left unchecked.
    let campaign = Campaign::parse("[radar]\nfile = 'line-1.sgy'\n").unwrap();
    let request = campaign.image_request(found.scene.pixels.clone());
    let evidence = Evidence::default();
    let unchecked = weigh_unchecked(&found, &request.options, None, &evidence, &[]);
    let unchecked: Vec<&str> = unchecked.iter().map(|one| one.setting).collect();
    assert!(
        unchecked.contains(&"lever_arm_m forward") && !unchecked.contains(&"time_offset_s"),
        "{unchecked:?}"
    );
    for (trace, p) in found.aligned.position_m.iter().enumerate() {
        assert!((p[0] - 0.25 * trace as f64).abs() < 1e-9, "{trace}: {p:?}");
    }
    // From zero on.
    write("0,0,0,1\n4,1.0,0,1\n8,2.0,0,1\n");
    let found = prepared_by_table(folder.path(), "max_gap_s = 10\n").unwrap();
    assert!((found.aligned.position_m[8][0] - 2.0).abs() < 1e-9);
    // A number that no trace has, a clock's offset, and times for traces without times.
    write("1,0,0,1\n10,2.0,0,1\n");
    let refused = prepared_by_table(folder.path(), "").unwrap_err();
    assert!(
        refused.contains("positions.csv: trace 10: expected 1 to 9"),
        "{refused}"
    );
    write("1,0,0,1\n9,2.0,0,1\n");
    let refused = prepared_by_table(folder.path(), "time_offset_s = 1.5\n").unwrap_err();
    assert!(
        refused.contains("[trajectory] time_offset_s: expected none"),
        "{refused}"
    );
    let timed = "time_s,x_m,y_m,z_m\n0,0,0,1\n9,2.0,0,1\n";
    std::fs::write(folder.path().join("positions.csv"), timed).unwrap();
    let refused = prepared_by_table(folder.path(), "").unwrap_err();
    assert!(
        refused.contains("expected times or positions of traces"),
        "{refused}"
    );
}

/// Positions by trace number are those of each log's own traces: tracks do not share them.
#[test]
fn a_table_of_trace_numbers_is_read_for_every_track() {
    let folder = tempfile::tempdir().unwrap();
    let of_tracks = |traces: [usize; 2]| {
        let mut tables = String::new();
        for (k, traces) in traces.into_iter().enumerate() {
            write_line(&folder.path().join(format!("line-{k}.sgy")), traces, 5.0, 2);
            tables += &format!(
                "[[track]]\nname = 'line {k}'\n[track.radar]\nfile = '{0}/line-{k}.sgy'\ndelay_ns = 0\n\
                 [track.trajectory]\nfile = '{0}/positions.csv'\n",
                folder.path().display()
            );
        }
        let campaign = Campaign::parse(&format!(
            "{tables}[image]\nx_m = [0, 4]\ny_m = [-1, 2]\nz_m = 0\npixel_m = 0.5\nband_ghz = [1.0, 2.0]\n\
             frequencies = 11\n[preprocess]\ngate_ns = 'none'\n"
        ));
        let survey = campaign.unwrap().survey();
        let prepared = survey.prepare(&mut Journal::default(), &Control::default());
        prepared.map_err(|error| error.to_string())
    };
    let rows = "trace,x_m,y_m,z_m\n1,0,0,1\n9,2.0,0,1\n";
    std::fs::write(folder.path().join("positions.csv"), rows).unwrap();
    let found = of_tracks([9, 9]).unwrap();
    for (k, p) in found.aligned.position_m.iter().enumerate() {
        assert!((p[0] - 0.25 * (k % 9) as f64).abs() < 1e-9, "{k}: {p:?}");
    }
    let refused = of_tracks([9, 5]).unwrap_err();
    assert!(refused.contains("trace 9: expected 1 to 5"), "{refused}");
}

/// The slice 6 cm below the surface of a modelled minefield: moduli, row after row, the side of the square grid, which
/// has a pixel every 2 cm from (0.15, 0.15), and the places of the targets, m.
struct Slice {
    moduli: Vec<f32>,
    side: usize,
    targets_m: Vec<[f64; 2]>,
}

/// The slice from lines `first`, `first + step`, ….
fn minefield(folder: &Path, first: usize, step: usize) -> Slice {
    let numbers: Vec<usize> = (first..=37).step_by(step).collect();
    let file = |k: &usize| folder.join(format!("buried_objects_xdir_bscan_{k}.rd3"));
    let row = |k: &usize| {
        let (file, y_m) = (file(k), 0.15 + 0.025 * (k - 1) as f64);
        format!("{{ file = {file:?}, start_m = [0.15, {y_m}, 0.01], end_m = [1.05, {y_m}, 0.01] }}")
    };
    let files: Vec<_> = numbers.iter().map(file).collect();
    let rows: Vec<String> = numbers.iter().map(row).collect();
    let campaign = Campaign::parse(&format!(
        "[radar]\nfiles = {files:?}\nlines = [{}]\n[preprocess]\nzero_timing = 'direct-wave'\n\
         [image]\nband_ghz = [0.63, 2.28]\nfrequencies = 40\nx_m = [0.15, 1.05]\ny_m = [0.15, 1.05]\nz_m = -0.06\n\
         pixel_m = 0.02\n[ground]\nrelative_permittivity = 5.0\nsurface_z_m = 0.0\n",
        rows.join(",\n"),
    ))
    .unwrap();
    let control = Control::default();
    let survey = campaign.survey();
    let prepared = survey.prepare(&mut Journal::default(), &control).unwrap();
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let focused = prepared
        .image(&request, &mut MemorySink::default(), &control)
        .unwrap();
    let measured = prepared
        .measure(&focused, &MeasureOptions::from(&campaign.measure), &control)
        .unwrap();
    Slice {
        moduli: focused.image.iter().map(|v| v.norm()).collect(),
        side: prepared.scene.pixels.grid.nx,
        targets_m: measured.targets.iter().map(|t| [t.x_m, t.y_m]).collect(),
    }
}

/// The objects of a modelled minefield have the same places within 2 cm, and the same levels, in the images of all 37
/// lines, of every second line from the first, and of the other lines, which share no trace with these.
#[test]
fn a_minefield_looks_the_same_from_half_of_its_lines() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/gpr-iwagpr2017");
    if !folder.is_dir() {
        println!("skipped: ../shared/data/gpr-iwagpr2017 is absent");
        return;
    }
    let of_all = minefield(&folder, 1, 1);
    let (all, side) = (&of_all.moduli, of_all.side);
    let near = |k: usize| {
        let about = |c: usize| c.saturating_sub(1)..(c + 2).min(side);
        about(k / side).flat_map(move |j| about(k % side).map(move |i| j * side + i))
    };
    let top = all.iter().copied().fold(0.0, f32::max);
    let objects: Vec<usize> = (0..all.len())
        .filter(|&k| all[k] > 0.3 * top && near(k).all(|n| all[n] <= all[k]))
        .collect();
    assert!(objects.len() >= 4, "{objects:?}");
    for first in [1, 2] {
        let of_half = minefield(&folder, first, 2);
        let half = &of_half.moduli;
        let highest = half.iter().copied().fold(0.0, f32::max);
        for &object in &objects {
            let level = all[object] / top;
            let again = near(object).map(|n| half[n] / highest).fold(0.0, f32::max);
            let at = [object % side, object / side];
            assert!(
                (again / level - 1.0).abs() < 0.15,
                "{at:?}: {level} {again}"
            );
        }
        // All but one of the targets are listed again, within the distance of these lines.
        let is_listed = |[x, y]: &[f64; 2]| {
            let mut again = of_half.targets_m.iter();
            again.any(|[x2, y2]| (x2 - x).hypot(y2 - y) < 0.05)
        };
        let both = of_all.targets_m.iter().filter(|at| is_listed(at)).count();
        let (all_m, half_m) = (&of_all.targets_m, &of_half.targets_m);
        assert!(
            all_m.len() >= 6 && both + 1 >= all_m.len(),
            "{all_m:?} {half_m:?}"
        );
    }
}
