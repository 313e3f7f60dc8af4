//! `acerra ppk` on simulated logs: the real binary, its files, its messages.
#![allow(clippy::unwrap_used, reason = "tests may fail loudly")]

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_simulate::gnss::{GnssModel, Setting, constellation, navigation_to_rinex, simulate};
use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const BASE_M: [f64; 3] = [-35.0, 12.0, 1.6];
const DURATION_S: f64 = 120.0;

fn start() -> GpsTime {
    GpsTime::from_calendar(&Calendar::new(2018, 7, 9, 9, 30, 0.0).unwrap())
}

fn frame() -> EnuFrame {
    EnuFrame::new(Geodetic::from_degrees(40.95, 14.35, 60.0))
}

/// Out along a gentle arc, climbing.
fn flight(time_s: f64) -> [f64; 3] {
    let t = time_s / DURATION_S;
    [
        20.0 * (3.0 * t).sin(),
        15.0 * (2.0 * t).cos(),
        1.0 + 9.0 * t,
    ]
}

/// The logs of one flight, made once.
fn logs() -> &'static [(&'static str, Vec<u8>)] {
    static LOGS: OnceLock<Vec<(&'static str, Vec<u8>)>> = OnceLock::new();
    LOGS.get_or_init(|| {
        let navigation = constellation(start(), DURATION_S, 3);
        let setting = Setting {
            frame: frame(),
            start: start(),
            duration_s: DURATION_S,
            rover_m: &flight,
            base_m: BASE_M,
            navigation: &navigation,
            seed: 5,
        };
        let logs = simulate(&GnssModel::default(), &setting).unwrap();
        vec![
            ("rover.obs", logs.rover.to_rinex("ROVER").into_bytes()),
            ("base.obs", logs.base.to_rinex("BASE").into_bytes()),
            ("brdc.nav", navigation_to_rinex(&navigation).into_bytes()),
            ("rover.ubx", logs.rover.to_ubx(&navigation)),
            ("base.ubx", logs.base.to_ubx(&navigation)),
        ]
    })
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in logs() {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn acerra(folder: &Path, arguments: &str) -> assert_cmd::assert::Assert {
    Command::cargo_bin("acerra")
        .unwrap()
        .current_dir(folder)
        .arg("ppk")
        .args(arguments.split_whitespace())
        .assert()
}

fn base_argument() -> String {
    let place = frame().geodetic_from_enu(BASE_M);
    format!(
        "--base-position llh:{:.11},{:.11},{:.5}",
        place.latitude_deg(),
        place.longitude_deg(),
        place.height_m
    )
}

fn stderr(assert: &assert_cmd::assert::Assert) -> String {
    String::from_utf8(assert.get_output().stderr.clone()).unwrap()
}

/// Largest horizontal and vertical error of fixed positions, and how many there are.
fn errors(pos: &Path) -> (f64, f64, usize) {
    let options = ReadOptions::default().with_origin(*frame().origin());
    let (track, _) = read_trajectory(fs::read(pos).unwrap().as_slice(), &options).unwrap();
    let mut worst = (0.0_f64, 0.0_f64, 0);
    for fix in track.fixes().iter().filter(|f| f.status.is_fixed()) {
        let time_s = track.gps_time_at(fix.time_s).unwrap() - start();
        let truth = flight(time_s);
        let [e, n, u] = [0, 1, 2].map(|i| fix.position_m[i] - truth[i]);
        worst = (worst.0.max(e.hypot(n)), worst.1.max(u.abs()), worst.2 + 1);
    }
    worst
}

#[test]
fn rinex_and_raw_logs_give_fixed_positions() {
    let folder = folder();
    for files in ["rover.obs base.obs brdc.nav", "rover.ubx base.ubx"] {
        acerra(
            folder.path(),
            &format!("{files} {} -o out.pos", base_argument()),
        )
        .success();
        let (horizontal_m, vertical_m, fixed) = errors(&folder.path().join("out.pos"));
        assert!(fixed > 80, "{files}: {fixed} fixed");
        assert!(
            horizontal_m < 0.03 && vertical_m < 0.06,
            "{files}: {horizontal_m} {vertical_m}"
        );
    }
}

#[test]
fn the_answer_as_json_and_the_page() {
    let folder = folder();
    let arguments = format!(
        "rover.obs base.obs brdc.nav {} --json --report page.html --events events.csv",
        base_argument()
    );
    let assert = acerra(folder.path(), &arguments).success();
    let answer: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    let count = |key: &str| answer[key].as_u64().unwrap();
    assert_eq!(
        count("epochs"),
        count("fixed") + count("float") + count("other") + count("lost")
    );
    assert!(answer["fixed_percent"].as_f64().unwrap() > 70.0, "{answer}");
    assert_eq!(answer["base"]["source"], "given");
    assert_eq!(answer["files"].as_array().unwrap().len(), 3);
    assert_eq!(answer["files"][0]["format"], "RINEX 2.11 observation");
    assert!(answer["fixed_sd_m"][2].as_f64().unwrap() < 0.05);
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("rover.obs"));
    for reference in ["src=\"http", "href=\"http", "url(http"] {
        assert!(!page.contains(reference), "{reference}");
    }
    let events = fs::read_to_string(folder.path().join("events.csv")).unwrap();
    assert!(events.starts_with("time_gpst,kind,"));
}

#[test]
fn same_input_same_bytes() {
    let folder = folder();
    let arguments = format!("rover.obs base.obs brdc.nav {} -o -", base_argument());
    let one = acerra(folder.path(), &arguments)
        .success()
        .get_output()
        .stdout
        .clone();
    let two = acerra(folder.path(), &arguments)
        .success()
        .get_output()
        .stdout
        .clone();
    assert!(!one.is_empty() && one == two);
}

#[test]
fn configuration_files_are_followed_and_their_rest_is_named() {
    let folder = folder();
    let conf = "pos1-posmode =kinematic\npos1-frequency =l1\npos1-soltype =backward\n\
                pos1-tidecorr =on\nant2-postype =rinexhead\nout-solformat =enu\n";
    fs::write(folder.path().join("my.conf"), conf).unwrap();
    let arguments = "rover.obs base.obs brdc.nav --config my.conf -o out.pos --format xyz";
    let assert = acerra(folder.path(), arguments).success();
    let said = stderr(&assert);
    assert!(
        said.contains("my.conf: line 4: pos1-tidecorr = on: not supported"),
        "{said}"
    );
    assert!(
        said.contains("the base position was taken from its file's header"),
        "{said}"
    );
    let pos = fs::read_to_string(folder.path().join("out.pos")).unwrap();
    assert!(
        pos.contains("% solution  : Backward") && pos.contains("x-ecef(m)"),
        "{pos}"
    );
}

#[test]
fn a_base_without_a_position_is_answered_by_the_option_that_gives_one() {
    let folder = folder();
    // UBX logs hold no position.
    let refused = acerra(folder.path(), "rover.ubx base.ubx -o none.pos").code(1);
    let message = stderr(&refused);
    let (said, place) = message.rsplit_once("--base-position ").unwrap();
    assert!(
        said.contains("base.ubx") && said.contains("median"),
        "{message}"
    );
    // What is offered is accepted, and near the truth.
    let place = place.trim();
    let numbers: Vec<f64> = place["llh:".len()..]
        .split(',')
        .map(|n| n.parse().unwrap())
        .collect();
    let offered = Geodetic::from_degrees(numbers[0], numbers[1], numbers[2]);
    let [east, north, up] = frame().enu_from_ecef(ecef_from_geodetic(&offered));
    let off_m = [east - BASE_M[0], north - BASE_M[1], up - BASE_M[2]];
    assert!(off_m.iter().all(|d| d.abs() < 8.0), "{off_m:?}");
    acerra(
        folder.path(),
        &format!("rover.ubx base.ubx -o out.pos --base-position {place}"),
    )
    .success();
}

#[test]
fn single_point_positions_need_no_base() {
    let folder = folder();
    acerra(folder.path(), "rover.obs brdc.nav --mode single -o out.pos").success();
    let pos = fs::read_to_string(folder.path().join("out.pos")).unwrap();
    let lines: Vec<&str> = pos.lines().filter(|l| !l.starts_with('%')).collect();
    assert!(lines.len() > 100);
    assert!(
        lines
            .iter()
            .all(|l| l.split_whitespace().nth(5) == Some("5")),
        "{}",
        lines[0]
    );
}

/// One message that names the file and what was wrong with it; exit 1; nothing written.
#[test]
fn what_cannot_work_says_why() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("empty.obs", b"");
    write(
        "text.obs",
        b"these are not the observations you are looking for\n",
    );
    write("bad.conf", b"pos1-elmask =steep\n");
    // The same log a day later.
    let text = String::from_utf8(logs()[1].1.clone()).unwrap();
    write(
        "later.obs",
        text.replace(" 18  7  9 ", " 18  7 10 ").as_bytes(),
    );
    let nav = String::from_utf8(logs()[2].1.clone()).unwrap();
    let at = nav.find("END OF HEADER").unwrap();
    write("hollow.nav", &nav.as_bytes()[..at + 14]);
    let entries = || fs::read_dir(folder.path()).unwrap().count();
    let before = entries();
    let good = base_argument();
    for (arguments, parts) in [
        (
            "nothing.obs base.obs brdc.nav".to_owned(),
            vec!["nothing.obs"],
        ),
        (
            "empty.obs base.obs brdc.nav".to_owned(),
            vec!["empty.obs", "empty"],
        ),
        (
            "text.obs base.obs brdc.nav".to_owned(),
            vec!["text.obs", "of no known kind"],
        ),
        (
            "rover.obs brdc.nav base.obs".to_owned(),
            vec!["brdc.nav", "expected the base's"],
        ),
        (
            "brdc.nav base.obs brdc.nav".to_owned(),
            vec!["brdc.nav", "expected observations"],
        ),
        (
            "rover.obs base.obs rover.obs".to_owned(),
            vec!["rover.obs", "expected navigation"],
        ),
        (
            "rover.obs base.obs".to_owned(),
            vec!["no ephemeris in", "rover.obs"],
        ),
        (
            "rover.obs base.obs hollow.nav".to_owned(),
            vec!["no ephemeris in", "hollow.nav"],
        ),
        (
            format!("rover.obs later.obs brdc.nav {good}"),
            vec!["later.obs", "do not overlap", "07/10"],
        ),
        (
            "rover.obs base.obs brdc.nav --base-position xyz:0,0,0".to_owned(),
            vec!["base.obs", "impossible", "single-point position"],
        ),
        (
            "rover.obs base.obs brdc.nav --base-position llh:0,0,0".to_owned(),
            vec!["base.obs", "single-point position"],
        ),
        (
            "rover.obs base.obs brdc.nav --config bad.conf".to_owned(),
            vec!["bad.conf", "line 1"],
        ),
        (
            format!("rover.obs base.obs brdc.nav {good} --report rover.obs"),
            vec!["rover.obs", "is an input"],
        ),
        ("rover.obs".to_owned(), vec!["base's log is needed"]),
    ] {
        let assert = acerra(folder.path(), &format!("{arguments} -o out.pos")).code(1);
        let said = stderr(&assert);
        for part in parts {
            assert!(said.contains(part), "{arguments}: {said}");
        }
        assert!(!said.contains("panicked"), "{said}");
        assert_eq!(entries(), before, "{arguments}");
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = folder();
    for arguments in [
        "",
        "rover.obs base.obs --mode sideways",
        "rover.obs base.obs --base-position llh:1,2",
        "rover.obs base.obs --systems GX",
        "rover.obs base.obs --elevation-mask 95",
        "rover.obs base.obs --exclude G99",
        "rover.obs base.obs --frequencies 4",
    ] {
        acerra(folder.path(), arguments).code(2);
    }
}

/// Suspicious input is processed with a remark.
#[test]
fn suspicions_are_said() {
    let folder = folder();
    let good = base_argument();
    let assert = acerra(
        folder.path(),
        &format!("base.obs base.obs brdc.nav {good} -o out.pos"),
    )
    .success();
    assert!(
        stderr(&assert).contains("identical observations"),
        "{}",
        stderr(&assert)
    );
    // A log that ends in the middle of an epoch.
    let (_, rover) = &logs()[0];
    fs::write(
        folder.path().join("cut.obs"),
        &rover[..rover.len() * 3 / 4 + 5],
    )
    .unwrap();
    let assert = acerra(
        folder.path(),
        &format!("cut.obs base.obs brdc.nav {good} -o out.pos"),
    )
    .success();
    assert!(
        stderr(&assert).contains("cut.obs: dropped for cut off"),
        "{}",
        stderr(&assert)
    );
}

/// A RINEX 2 observation file of the flight's day as two: the epochs before and from the `k`-th on.
fn halves(rinex: &str, k: usize) -> [String; 2] {
    let header_end = rinex.find("END OF HEADER").unwrap();
    let header_end = header_end + rinex[header_end..].find('\n').unwrap() + 1;
    let (header, body) = rinex.split_at(header_end);
    let at = 1 + body.match_indices("\n 18  7  9 ").nth(k).unwrap().0;
    [&body[..at], &body[at..]].map(|part| format!("{header}{part}"))
}

/// The positions in a solution file, without the lines about its making.
fn positions(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('%'));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn hourly_files_of_a_receiver_are_joined() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (whole, k) in [("rover.obs", 70), ("base.obs", 50)] {
        let text = fs::read_to_string(path(whole)).unwrap();
        for (i, half) in halves(&text, k).into_iter().enumerate() {
            fs::write(path(&format!("{whole}.{i}")), half).unwrap();
        }
    }
    let base = base_argument();
    acerra(
        folder.path(),
        &format!("rover.obs base.obs brdc.nav {base} -o whole.pos"),
    )
    .success();
    acerra(
        folder.path(),
        &format!(
            "rover.obs.1 base.obs.0 brdc.nav --rover rover.obs.0 --base base.obs.1 {base} -o parts.pos"
        ),
    )
    .success();
    assert_eq!(positions(&path("parts.pos")), positions(&path("whole.pos")));
    // A file missing in between is a gap that is said.
    let text = fs::read_to_string(path("base.obs")).unwrap();
    fs::write(path("late.obs"), &halves(&text, 80)[1]).unwrap();
    let told = acerra(
        folder.path(),
        &format!("rover.obs base.obs.0 brdc.nav --base late.obs {base} -o gap.pos"),
    )
    .success();
    let told = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(told.contains("between base.obs.0 and late.obs"), "{told}");
    // The same file twice is an overlap.
    let told = acerra(
        folder.path(),
        &format!("rover.obs base.obs brdc.nav --base base.obs.1 {base} -o twice.pos"),
    )
    .success();
    let told = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(told.contains("both hold"), "{told}");
    assert_eq!(positions(&path("twice.pos")), positions(&path("whole.pos")));
}

#[test]
fn other_outputs_are_written_where_asked() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let base = base_argument();
    let told = acerra(
        folder.path(),
        &format!(
            "rover.obs base.obs brdc.nav {base} -o out.pos --velocities --nmea out.nmea \
             --residuals out.csv"
        ),
    )
    .success();
    let told = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(told.contains("no geoid grid"), "{told}");
    let pos = fs::read_to_string(path("out.pos")).unwrap();
    assert!(pos.contains("vn(m/s)"));
    let read = |name: &str| {
        let file = std::io::BufReader::new(fs::File::open(path(name)).unwrap());
        read_trajectory(file, &ReadOptions::default()).unwrap().0
    };
    assert_eq!(
        read("out.nmea").fixes().len(),
        read("out.pos").fixes().len()
    );
    assert!(fs::read_to_string(path("out.csv")).unwrap().lines().count() > 500);
    // Nothing is within a tenth of a millimetre.
    acerra(
        folder.path(),
        &format!("rover.obs base.obs brdc.nav {base} -o none.pos --max-sigma 0.0001"),
    )
    .success();
    assert_eq!(positions(&path("none.pos")), "");
    // The log has no events to pair with an image.
    fs::write(path("images.txt"), "a.jpg\n").unwrap();
    let refused = acerra(
        folder.path(),
        &format!(
            "rover.obs base.obs brdc.nav {base} -o no.pos --images images.txt \
             --image-positions no.csv"
        ),
    )
    .code(1);
    let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        told.contains("images.txt") && told.contains("0 events, found 1 images"),
        "{told}"
    );
    assert!(!path("no.pos").exists() && !path("no.csv").exists());
}

#[test]
fn configurations_name_outputs_and_products() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let base = base_argument();
    let conf = "pos1-posmode =kinematic\npos1-frequency =l1\npos1-navsys =1\n\
                pos2-armode =fix-and-hold\nant2-postype =rinexhead\nout-outvel =on\n\
                out-outstat =residual\n";
    fs::write(path("out.conf"), conf).unwrap();
    let run = |conf: &str, output: &str| {
        acerra(
            folder.path(),
            &format!("rover.obs base.obs brdc.nav {base} --config {conf} -o {output}"),
        )
    };
    run("out.conf", "out.pos").success();
    assert!(
        fs::read_to_string(path("out.pos"))
            .unwrap()
            .contains("vn(m/s)")
    );
    assert!(path("out.pos.residuals.csv").exists());
    fs::write(
        path("precise.conf"),
        format!("{conf}pos1-sateph =precise\n"),
    )
    .unwrap();
    let refused = run("precise.conf", "no.pos").code(1);
    let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(told.contains("give an SP3 file"), "{told}");
    fs::write(
        path("antenna.conf"),
        format!("{conf}file-rcvantfile =missing.atx\nant1-anttype =*\n"),
    )
    .unwrap();
    let refused = run("antenna.conf", "no.pos").code(1);
    let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(told.contains("missing.atx"), "{told}");
}

/// A real walk as RTCM 3 logs, of which only the rover's tells its date.
#[test]
fn a_log_without_a_date_takes_that_of_the_other() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/gnss-walk-lg69t");
    if !data.exists() {
        println!("skipped: {} is not there", data.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| data.join(name).display().to_string();
    let (rover, base) = (file("rover.rtcm3.gz"), file("base.rtcm3.gz"));
    let window = "--systems GE --start 2023-05-19T06:40:00 --end 2023-05-19T06:40:30";
    acerra(
        folder.path(),
        &format!("{rover} {base} {window} -o by-rtcm.pos"),
    )
    .success();
    let text = positions(&folder.path().join("by-rtcm.pos"));
    assert!(text.lines().count() > 10);
    assert!(
        text.lines()
            .all(|line| line.starts_with("2023/05/19 06:40:")),
        "{text}"
    );
    // Exchanged, the rover's log is the one without a date.
    acerra(
        folder.path(),
        &format!("{base} {rover} {window} --mode single -o exchanged.pos"),
    )
    .success();
    let text = positions(&folder.path().join("exchanged.pos"));
    assert!(text.lines().count() > 20);
    assert!(
        text.lines()
            .all(|line| line.starts_with("2023/05/19 06:40:")),
        "{text}"
    );
    // Alone it is refused, with the way out.
    let refused = acerra(folder.path(), &format!("{base} {base} -o no.pos")).code(1);
    let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(told.contains("base.rtcm3.gz (--date)"), "{told}");
}

/// The base of the flight taken for a moving one: its own codes place it, and the vector is that of
/// carrier phase all the same.
#[test]
fn a_moving_base_gives_vectors_and_headings() {
    let folder = folder();
    let arguments = "rover.obs base.obs brdc.nav --mode moving-base -o out.pos \
                     --attitudes attitudes.csv --json";
    let assert = acerra(folder.path(), arguments).success();
    let answer: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(answer["base"].is_null() && answer["baseline"]["length_m"].is_number());
    let pos = fs::read_to_string(folder.path().join("out.pos")).unwrap();
    assert!(pos.contains("% pos mode  : Moving-Base") && pos.contains("e-baseline(m)"));
    let attitudes = fs::read_to_string(folder.path().join("attitudes.csv")).unwrap();
    let rows = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|l| !l.starts_with(['%', 't']));
        lines.map(str::to_owned).collect()
    };
    let (vectors, attitudes) = (rows(&pos), rows(&attitudes));
    assert_eq!(vectors.len(), attitudes.len());
    let mut fixed = 0;
    for (vector, attitude) in vectors.iter().zip(&attitudes) {
        let fields: Vec<&str> = vector.split_whitespace().collect();
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        if fields[5] != "1" {
            continue;
        }
        fixed += 1;
        let [hour, minute, second] = {
            let mut parts = fields[1].split(':').map(|p| p.parse::<f64>().unwrap());
            [(); 3].map(|()| parts.next().unwrap())
        };
        let time_s = (hour - 9.0) * 3600.0 + (minute - 30.0) * 60.0 + second;
        let place = flight(time_s);
        for k in 0..3 {
            // The base turns by metres of its place over the distance to the satellites: nothing.
            let error_m = number(2 + k) - (place[k] - BASE_M[k]);
            assert!(error_m.abs() < [0.03, 0.03, 0.06][k], "{vector}: {error_m}");
        }
        let heading_deg: f64 = attitude.split(',').nth(2).unwrap().parse().unwrap();
        let expected_deg = f64::atan2(number(2), number(3))
            .to_degrees()
            .rem_euclid(360.0);
        assert!((heading_deg - expected_deg).abs() < 1e-3, "{attitude}");
    }
    assert!(fixed > 80, "{fixed} fixed");
    for wrong in ["--baseline-length 1", "--attitudes a.csv"] {
        let assert = acerra(
            folder.path(),
            &format!("rover.obs base.obs brdc.nav {wrong}"),
        );
        let said = stderr(&assert.failure());
        assert!(said.contains("expected --mode moving-base"), "{said}");
    }
    let conf = "pos1-posmode =movingbase\npos1-soltype =combined\npos1-frequency =l1\n\
                pos2-armode =fix-and-hold\nout-solformat =enu\n";
    fs::write(folder.path().join("my.conf"), conf).unwrap();
    let arguments = "rover.obs base.obs brdc.nav --config my.conf -o conf.pos";
    acerra(folder.path(), arguments).success();
    let pos = fs::read_to_string(folder.path().join("conf.pos")).unwrap();
    assert!(pos.contains("% pos mode  : Moving-Base"), "{pos}");
}
