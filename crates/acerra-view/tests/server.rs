//! What the server answers, and what it refuses, without a browser.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

mod support;

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use acerra_chain::campaign::{Campaign, Gate};
use acerra_chain::{Control, ImageRequest, Journal, MemorySink, Pixels};
use acerra_imaging::PlaneGrid;
use acerra_npz::NpzWriter;
use acerra_products::data::{Axis, VolumeFile, read_image};
use acerra_view::{Server, ServerOptions};
use serde_json::json;
use support::{LIGHT_M_S, SAMPLES, Serving, TARGET_M, TRACES, place, run_in, run_with, shared};

/// Relative L2 distance of two images.
fn distance(found: &[[f32; 2]], expected: &[[f32; 2]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let power = |v: &[f32; 2]| f64::from(v[0]).powi(2) + f64::from(v[1]).powi(2);
    let off: f64 = found
        .iter()
        .zip(expected)
        .map(|(a, b)| power(&[a[0] - b[0], a[1] - b[1]]))
        .sum();
    (off / expected.iter().map(power).sum::<f64>()).sqrt()
}

#[test]
fn strangers_and_tricks_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let products = run_in(folder.path());
    fs::write(products.join("secret.txt"), "secret").unwrap();
    let server = Serving::start(vec![products.clone()]);
    let (host, base) = (&server.host, &server.base);
    let with = |path: &str, headers: &str| {
        server
            .send(&format!(
                "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n"
            ))
            .status
    };
    let own = format!("Host: {host}\r\n");
    assert_eq!(with(&format!("{base}/"), &own), 200);
    for strange in [
        "Host: evil.example\r\n".to_owned(),
        "Host: 127.0.0.1\r\n".to_owned(),
        format!("{own}Origin: http://evil.example\r\n"),
        format!("{own}Origin: null\r\n"),
        format!("{own}Sec-Fetch-Site: cross-site\r\n"),
    ] {
        assert_eq!(
            with(&format!("{base}/api/runs"), &strange),
            403,
            "{strange}"
        );
    }
    // Without the token there is nothing.
    for path in [
        "/",
        "/api/runs",
        "/0123456789abcdef0123456789abcdef/api/runs",
    ] {
        assert_eq!(with(path, &own), 404, "{path}");
    }
    // Of the directory, products by their names alone.
    assert_eq!(server.get("/run/0/run.json").status, 200);
    for path in [
        "/run/0/secret.txt",
        "/run/0/../secret.txt",
        "/run/0/..%2fflight.toml",
        "/run/0/%2e%2e/flight.toml",
        "/run/0/run.json%00.txt",
        "/run/0/data.zarr",
        "/run/1/run.json",
        "/run/-1/run.json",
        "/js/..%2f..%2fCargo.toml",
        "//etc/passwd",
    ] {
        let answer = server.get(path);
        assert!(
            [400, 404].contains(&answer.status),
            "{path}: {}",
            answer.status
        );
        assert!(!answer.body.windows(6).any(|w| w == b"secret"), "{path}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/etc/passwd", products.join("targets.geojson")).unwrap();
        assert_eq!(server.get("/run/0/targets.geojson").status, 404);
    }
}

#[test]
fn every_answer_forbids_what_the_page_does_not_need() {
    let server = Serving::start(vec![shared().join("products")]);
    for path in [
        "/",
        "/js/main.js",
        "/api/runs",
        "/run/0/report.html",
        "/nothing",
    ] {
        let head = server.get(path).head.to_lowercase();
        for part in [
            "content-security-policy: default-src 'none'",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "cross-origin-resource-policy: same-origin",
        ] {
            assert!(head.contains(part), "{path}: {part}");
        }
        assert!(
            !head.contains("unsafe-eval") && !head.contains("access-control"),
            "{path}"
        );
    }
}

#[test]
fn a_track_from_a_table_has_no_sky() {
    let server = Serving::start(vec![shared().join("products")]);
    assert_eq!(server.get("/api/run/0/sky/0").status, 409);
    let engine = server.engine();
    assert_eq!(engine["data"]["tracks"][0]["has_sky"], json!(false));
    for path in ["/api/run/0/sky/0", "/api/run/0/sky/7"] {
        assert_eq!(server.get(path).status, 404, "{path}");
    }
}

#[test]
fn tiles_and_cursor_hold_the_values_of_the_file() {
    let products = shared().join("products");
    let image = read_image(&products.join("image.npz")).unwrap();
    let server = Serving::start(vec![products]);
    let meta = server.get("/api/run/0").json();
    assert_eq!(
        (&meta["grid"]["nx"], &meta["levels"]),
        (&json!(301), &json!(2))
    );
    let tile = server.get("/api/run/0/image/0/1/0").pairs();
    assert_eq!(tile.len(), 45 * 256);
    for (k, [re, im]) in tile.iter().enumerate() {
        let expected = image.values[(k / 45) * 301 + 256 + k % 45];
        assert_eq!((re, im), (&expected.re, &expected.im), "value {k}");
    }
    // The same in half precision, for the screen.
    let scale_db = meta["display"]["half_db"].as_f64().unwrap();
    let halves = server.get("/api/run/0/image/0/1/0?half=true").body;
    assert_eq!(halves.len(), 4 * tile.len());
    for (k, bits) in halves.chunks_exact(2).enumerate() {
        let half = half::f16::from_le_bytes([bits[0], bits[1]]).to_f64();
        let [re, im] = tile[k / 2].map(f64::from);
        let off = half * 10_f64.powf(scale_db / 20.0) - [re, im][k % 2];
        assert!(
            off.abs() <= re.hypot(im) / 1024.0,
            "number {k}: off by {off}"
        );
    }
    assert_eq!(server.get("/api/run/0/image/0/1/0?half=7").status, 400);
    for path in [
        "2/0/0",
        "0/2/0",
        "0/0/99999999999999999999",
        "0/18446744073709551615/0",
    ] {
        let status = server.get(&format!("/api/run/0/image/{path}")).status;
        assert!([400, 404].contains(&status), "{path}: {status}");
    }

    let cursor = server.get("/api/run/0/cursor?x_m=5.004&y_m=3.996").json();
    let expected = image.values[150 * 301 + 150];
    assert_eq!(cursor["pixel"], json!([150, 150]));
    assert_eq!(cursor["value"], json!([expected.re, expected.im]));
    let phase_deg = f64::from(expected.arg()).to_degrees();
    assert!((cursor["phase_deg"].as_f64().unwrap() - phase_deg).abs() < 1e-9);
    assert!(cursor["level_db"].as_f64().unwrap().abs() < 0.5);
    // A metre of latitude is 1/111,049 of a degree here, within a thousandth.
    let latitude_deg = cursor["place_deg_m"][0].as_f64().unwrap();
    assert!(((latitude_deg - 40.9596) * 111_049.0 / 3.996 - 1.0).abs() < 1e-3);
    let nearest = (0..TRACES)
        .map(|k| {
            let [dx, dy, dz] = [place(k)[0] - 5.004, place(k)[1] - 3.996, place(k)[2]];
            (dx * dx + dy * dy + dz * dz).sqrt()
        })
        .fold(f64::INFINITY, f64::min);
    assert!((cursor["seen"]["range_m"].as_f64().unwrap() - nearest).abs() < 1e-3);
    assert_eq!(server.get("/api/run/0/cursor?x_m=nan&y_m=0").status, 400);
    // There is neither volume nor terrain.
    assert!(meta["volume"].is_null());
    for path in ["volume/z/0/0/0/0", "cursor?x_m=5&y_m=4&slice=0"] {
        assert_eq!(server.get(&format!("/api/run/0/{path}")).status, 404);
    }
}

#[test]
fn the_hyperbola_follows_the_echoes_and_the_ring_meets_the_target() {
    let server = Serving::start(vec![shared().join("products")]);
    let data = server.engine()["data"].clone();
    let [x_m, y_m, _] = TARGET_M;
    let hyperbola = server
        .get(&format!("/api/run/0/hyperbola?x_m={x_m}&y_m={y_m}"))
        .json();
    let axis = &data["tracks"][0]["radargram"];
    let start_ns = axis["fast_time_start_ns"].as_f64().unwrap();
    let step_ns = axis["fast_time_step_ns"].as_f64().unwrap();
    // The radargram as served, put together from its tiles: samples are rows.
    let mut radargram = vec![0_f32; TRACES * SAMPLES];
    for row in 0..SAMPLES.div_ceil(256) {
        let path = format!("/api/run/0/radargram/0/clean/0/0/{row}");
        for (k, [re, _]) in server.get(&path).pairs().into_iter().enumerate() {
            let (trace, sample) = (k % TRACES, 256 * row + k / TRACES);
            radargram[trace * SAMPLES + sample] = re;
        }
    }
    for trace in 0..TRACES {
        let samples = radargram[trace * SAMPLES..(trace + 1) * SAMPLES].iter();
        let strongest = samples
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .unwrap()
            .0;
        let time_ns = hyperbola["fast_time_ns"][trace].as_f64().unwrap();
        let sample = (time_ns - start_ns) / step_ns;
        assert!(
            (sample - strongest as f64).abs() <= 1.0,
            "trace {trace}: {sample}, {strongest}"
        );
    }
    let apex = usize::try_from(hyperbola["apex"].as_u64().unwrap()).unwrap();
    let time_ns = hyperbola["fast_time_ns"][apex].as_f64().unwrap();

    let ring = server
        .get(&format!(
            "/api/run/0/ring?pulse={apex}&fast_time_ns={time_ns}"
        ))
        .json();
    let places = ring["places_m"].as_array().unwrap();
    let number = |place: &serde_json::Value, i: usize| place[i].as_f64().unwrap();
    let range_m = 0.5 * LIGHT_M_S * time_ns * 1e-9;
    let away = |place: &serde_json::Value, from: [f64; 3]| {
        (0..3)
            .map(|i| (number(place, i) - from[i]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    assert!((ring["range_m"].as_f64().unwrap() - range_m).abs() < 1e-9);
    assert!(
        places
            .iter()
            .all(|p| (away(p, place(apex)) - range_m).abs() < 1e-3)
    );
    let nearest = places
        .iter()
        .map(|p| away(p, TARGET_M))
        .fold(f64::INFINITY, f64::min);
    // Corners stand a degree apart.
    assert!(nearest < 0.05, "{nearest}");
    // No ground is as near as this.
    let near = server.get("/api/run/0/ring?pulse=3&fast_time_ns=5").json();
    assert_eq!(near["places_m"], json!([]));
    assert_eq!(
        server
            .get("/api/run/0/ring?pulse=120&fast_time_ns=40")
            .status,
        404
    );
}

#[test]
fn the_cursor_tells_how_a_chosen_pulse_sees_a_place() {
    let server = Serving::start(vec![shared().join("products")]);
    let path = |pulse: usize| format!("/api/run/0/cursor?x_m=4.4&y_m=3.1&pulse={pulse}");
    server.engine();
    let hyperbola = server.get("/api/run/0/hyperbola?x_m=4.4&y_m=3.1").json();
    for pulse in [0, 57, TRACES - 1] {
        let seen = server.get(&path(pulse)).json()["seen"].clone();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let range_m = 0.5e-9 * LIGHT_M_S * number(&hyperbola["fast_time_ns"][pulse]);
        assert!((number(&seen["range_m"]) - range_m).abs() < 1e-9, "{seen}");
        assert_eq!(seen["incidence_deg"], hyperbola["incidence_deg"][pulse]);
        let [dx, dy, dz] = [
            4.4 - place(pulse)[0],
            3.1 - place(pulse)[1],
            place(pulse)[2],
        ];
        let incidence_deg = dx.hypot(dy).atan2(dz).to_degrees();
        assert!((number(&seen["incidence_deg"]) - incidence_deg).abs() < 1e-2);
        assert_eq!(number(&seen["trace"]), pulse as f64);
    }
    assert_eq!(server.get(&path(TRACES)).status, 404);
    // Higher up it is nearer.
    let above = server.get(&format!("{}&z_m=2", path(57))).json();
    assert_eq!(above["place_m"][2], json!(2.0));
    let below = server.get(&path(57)).json();
    assert!(above["seen"]["range_m"].as_f64() < below["seen"]["range_m"].as_f64());
}

#[test]
fn planes_through_a_volume_are_those_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    // Wider than a tile along x.
    let image = "x_m = [4.0, 6.0]\ny_m = [3.8, 4.2]\nz_m = [-0.1, 0.1]\npixel_m = 0.0075\n\
                 pixel_z_m = 0.05\n";
    let products = run_with(folder.path(), image);
    let volume = VolumeFile::open(&products.join("volume.npz")).unwrap();
    assert_eq!(volume.size(), [267, 54, 5]);
    let server = Serving::start(vec![products.clone()]);
    let meta = server.get("/api/run/0").json()["volume"].clone();
    assert_eq!(meta["slices"], json!(5));
    assert_eq!(meta["levels"], json!({ "x": 1, "y": 2, "z": 2 }));
    assert!((meta["z0_m"].as_f64().unwrap() + 0.1).abs() < 1e-9);
    assert!((meta["step_m"].as_f64().unwrap() - 0.05).abs() < 1e-9);
    for (axis, name, index, [columns, rows]) in [
        (Axis::Z, "z", 3, [267, 54]),
        (Axis::Y, "y", 20, [267, 5]),
        (Axis::X, "x", 260, [54, 5]),
        (Axis::Z, "z", 0, [267, 54]),
    ] {
        let expected = volume.plane(axis, index).unwrap();
        let mut found = vec![[0.0_f32; 2]; columns * rows];
        for tile in 0..usize::div_ceil(columns, 256) {
            let path = format!("/api/run/0/volume/{name}/{index}/0/{tile}/0");
            let width = (columns - 256 * tile).min(256);
            for (k, value) in server.get(&path).pairs().into_iter().enumerate() {
                found[(k / width) * columns + 256 * tile + k % width] = value;
            }
        }
        let expected: Vec<[f32; 2]> = expected.iter().map(|v| [v.re, v.im]).collect();
        assert_eq!(found, expected, "{name} {index}");
    }
    let cursor = server.get("/api/run/0/cursor?x_m=5&y_m=4&slice=1").json();
    let [i, j] = [0, 1].map(|n| cursor["pixel"][n].as_u64().unwrap() as usize);
    let value = volume.value([i, j, 1]).unwrap();
    assert_eq!(cursor["value"], json!([value.re, value.im]));
    assert!((cursor["place_m"][2].as_f64().unwrap() + 0.05).abs() < 1e-9);
    for path in [
        "volume/z/5/0/0/0",
        "volume/x/267/0/0/0",
        "volume/y/0/0/2/0",
        "volume/y/0/9/0/0",
        "volume/w/0/0/0/0",
        "volume/z/-1/0/0/0",
        "cursor?x_m=5&y_m=4&slice=5",
    ] {
        let status = server.get(&format!("/api/run/0/{path}")).status;
        assert!([400, 404].contains(&status), "{path}: {status}");
    }
    drop(server);
    // A volume that is broken, or of other pixels than the image, is named.
    let refused = || {
        let options = ServerOptions {
            directories: vec![products.clone()],
            ..ServerOptions::default()
        };
        Server::open(&options).unwrap_err().to_string()
    };
    let path = products.join("volume.npz");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 100]).unwrap();
    let message = refused();
    assert!(message.contains("volume.npz"), "{message}");
    let mut npz = NpzWriter::stored(fs::File::create(&path).unwrap());
    npz.array("volume", &[1, 1, 2], [num_complex::Complex32::ONE; 2])
        .unwrap();
    for (name, values) in [("x_m", &[4.0, 4.1][..]), ("y_m", &[3.8]), ("z_m", &[0.0])] {
        npz.array(name, &[values.len() as u64], values.iter().copied())
            .unwrap();
    }
    npz.finish().unwrap();
    let message = refused();
    assert!(
        message.contains("volume.npz") && message.contains("x_m"),
        "{message}"
    );
}

const VIEW: &str = r#"{"x0_m":4.2,"y0_m":3.3,"pixel_m":0.0125,"nx":130,"ny":110}"#;

fn view() -> PlaneGrid {
    PlaneGrid::new([4.2, 3.3, 0.0], 0.0125, [130, 110]).unwrap()
}

/// The image of a campaign on the pixels of [`VIEW`], by the chain itself.
fn by_chain(campaign: &Campaign, pulses: Option<std::ops::Range<usize>>) -> Vec<[f32; 2]> {
    let (mut journal, control) = (Journal::default(), Control::default());
    let prepared = campaign.survey().prepare(&mut journal, &control).unwrap();
    let mut grid = view();
    grid.z_m = campaign.image.base_z_m();
    let mut request: ImageRequest = campaign.image_request(Pixels::plane(grid));
    request.pulses = pulses;
    let sink = &mut MemorySink::default();
    let focused = prepared.image(&request, sink, &control).unwrap();
    focused.image.iter().map(|v| [v.re, v.im]).collect()
}

#[test]
fn images_of_selections_and_of_other_settings_are_the_chains() {
    let server = Serving::start(vec![shared().join("products")]);
    assert_eq!(server.engine()["state"], "ready");
    let text = fs::read_to_string(shared().join("flight.toml")).unwrap();
    let campaign = Campaign::parse(&text).unwrap().resolved_in(shared());
    let made = |pulses: &str, edits: &str| {
        let order = format!(r#"{{"view":{VIEW},"pulses":{pulses},"edits":{edits}}}"#);
        let answer = server.post("/api/run/0/image", &order);
        assert_eq!(
            answer.status,
            200,
            "{}",
            String::from_utf8_lossy(&answer.body)
        );
        answer
    };

    // Twice the accuracy asked for, as each of the two images may be off by it.
    let tolerance = 2.0 * campaign.image.accuracy;
    let all = made("null", "{}").pairs();
    assert!(distance(&all, &by_chain(&campaign, None)) < tolerance);
    let selected = made("[30,79]", "{}").pairs();
    assert!(distance(&selected, &by_chain(&campaign, Some(30..80))) < tolerance);
    assert!(distance(&selected, &all) > 0.1);
    // The sum over pulses is linear: parts add up to the whole.
    let parts = [
        made("[0,29]", "{}").pairs(),
        selected,
        made("[80,119]", "{}").pairs(),
    ];
    let sum: Vec<[f32; 2]> = (0..all.len())
        .map(|k| [0, 1].map(|i| parts.iter().map(|part| part[k][i]).sum()))
        .collect();
    assert!(distance(&sum, &all) < tolerance);

    let edits = r#"{"gate_ns":[-2.0,12.5],"background":"median","band_ghz":[3.3,4.6],
        "delay_change_ns":0.2,"z_m":0.1,"light_speed_m_s":2.9e8,"time_offset_change_s":0.01}"#;
    let edited = made("null", edits);
    assert!(edited.head.contains("x-acerra-image"));
    let file = server.post("/api/run/0/campaign", edits);
    assert_eq!(file.status, 200);
    let saved = Campaign::parse(std::str::from_utf8(&file.body).unwrap()).unwrap();
    assert_eq!(saved.preprocess.gate_ns, Gate::About([-2.0, 12.5]));
    assert!(distance(&edited.pairs(), &by_chain(&saved, None)) < tolerance);
    // The coherence of the two halves, at one pixel by hand.
    let looks = [made("[0,59]", "{}").pairs(), made("[60,119]", "{}").pairs()];
    let order = format!(r#"{{"view":{VIEW},"coherence":true}}"#);
    let gamma = server.post("/api/run/0/image", &order).pairs()[40 * 130 + 60];
    let (mut cross, mut powers) = ([0.0; 2], [0.0; 2]);
    for place in (37..44).flat_map(|j| (57..64).map(move |i| j * 130 + i)) {
        let [[a, b], [c, d]] = [0, 1].map(|look| looks[look][place].map(f64::from));
        cross = [cross[0] + a * c + b * d, cross[1] + b * c - a * d];
        powers = [powers[0] + a * a + b * b, powers[1] + c * c + d * d];
    }
    for i in 0..2 {
        let expected = cross[i] / (powers[0] * powers[1]).sqrt();
        assert!((f64::from(gamma[i]) - expected).abs() < 5e-3);
    }
    // Back to the run's settings, nothing of the changes is left.
    assert!(distance(&made("null", "{}").pairs(), &all) < 1e-9);
}

#[test]
fn impossible_orders_are_refused_with_what_is_possible() {
    let server = Serving::start(vec![shared().join("products")]);
    server.engine();
    let order = |view: &str, rest: &str| format!(r#"{{"view":{view}{rest}}}"#);
    for (body, status, part) in [
        (order(VIEW, r#","pulses":[5,120]"#), 400, "within 0 to 119"),
        (order(VIEW, r#","pulses":[9,5]"#), 400, "[first, last]"),
        (order(VIEW, r#","edits":{"gate_ns":[5,1]}"#), 422, ""),
        (
            order(VIEW, r#","edits":{"band_ghz":[4.8,3.1]}"#),
            400,
            "band_ghz",
        ),
        (
            order(VIEW, r#","edits":{"light_speed_m_s":0}"#),
            400,
            "light_speed_m_s",
        ),
        (order(VIEW, r#","edits":{"nothing":0}"#), 422, "nothing"),
        (
            order(
                r#"{"x0_m":0,"y0_m":0,"pixel_m":0.01,"nx":100000,"ny":100000}"#,
                "",
            ),
            400,
            "4000000",
        ),
        (
            order(r#"{"x0_m":0,"y0_m":0,"pixel_m":-1,"nx":10,"ny":10}"#, ""),
            400,
            "",
        ),
        (order(r#"{"x0_m":0}"#, ""), 422, ""),
        ("{".to_owned(), 400, ""),
    ] {
        let answer = server.post("/api/run/0/image", &body);
        let text = String::from_utf8_lossy(&answer.body).into_owned();
        assert_eq!(answer.status, status, "{body}: {text}");
        assert!(text.contains(part), "{body}: {text}");
    }
    assert_eq!(server.get("/api/run/0/radargram/1/clean/0/0/0").status, 404);
    assert_eq!(server.get("/api/run/0/radargram/0/burnt/0/0/0").status, 400);
    // It still answers.
    assert_eq!(server.engine()["state"], "ready");
}

/// Numbers that no flight has: whatever a page sends, the answer comes at once.
#[test]
fn extreme_numbers_are_refused_before_any_work() {
    let server = Serving::start(vec![shared().join("products")]);
    server.engine();
    for number in ["NaN", "inf", "-inf", "1e18", "-1e300", "1e308"] {
        for path in [
            format!("/api/run/0/spread?x_m={number}&y_m=4"),
            format!("/api/run/0/spread?x_m=5&y_m={number}"),
            format!("/api/run/0/hyperbola?x_m={number}&y_m=4"),
            format!("/api/run/0/hyperbola?x_m=5&y_m=4&z_m={number}"),
            format!("/api/run/0/cursor?x_m=5&y_m={number}"),
            format!("/api/run/0/ring?pulse=5&fast_time_ns={number}"),
        ] {
            let answer = server.get(&path);
            let text = String::from_utf8_lossy(&answer.body).into_owned();
            assert_eq!(answer.status, 400, "{path}: {text}");
        }
    }
    for number in ["1e18", "-1e300", "1e308", "1e-307", "0", "1e7"] {
        for view in [
            format!(r#"{{"x0_m":{number},"y0_m":3,"pixel_m":0.1,"nx":8,"ny":8}}"#),
            format!(r#"{{"x0_m":4,"y0_m":3,"pixel_m":{number},"nx":8,"ny":8}}"#),
            format!(r#"{{"x0_m":4,"y0_m":3,"z_m":{number},"pixel_m":0.1,"nx":8,"ny":8}}"#),
        ] {
            let answer = server.post("/api/run/0/image", &format!(r#"{{"view":{view}}}"#));
            let text = String::from_utf8_lossy(&answer.body).into_owned();
            assert!([200, 400].contains(&answer.status), "{view}: {text}");
            let is_no_flight = number.len() > 4 && !view.contains(r#""pixel_m":0.1"#);
            assert!(!is_no_flight || answer.status == 400, "{view}: {text}");
        }
        for key in [
            "delay_change_ns",
            "time_offset_change_s",
            "z_m",
            "light_speed_m_s",
        ] {
            let body = format!(r#"{{"view":{VIEW},"edits":{{"{key}":{number}}}}}"#);
            let answer = server.post("/api/run/0/image", &body);
            assert!(
                [200, 400, 422].contains(&answer.status),
                "{body}: {}",
                answer.status
            );
        }
    }
    assert_eq!(server.engine()["state"], "ready");
}

/// Idle connections of a program that does not know the token: the oldest are closed, the page goes on.
#[test]
fn connections_without_the_token_are_few() {
    let server = Serving::start(vec![shared().join("products")]);
    let (host, base) = (&server.host, &server.base);
    // A page keeps its connection.
    let mut page = TcpStream::connect(host).unwrap();
    page.set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    let mut ask = || {
        let request = format!("GET {base}/api/runs HTTP/1.1\r\nHost: {host}\r\n\r\n");
        page.write_all(request.as_bytes()).unwrap();
        let mut start = [0; 15];
        page.read_exact(&mut start).unwrap();
        // The rest of the answer.
        page.set_read_timeout(Some(Duration::from_millis(300)))
            .unwrap();
        let mut rest = [0; 1 << 16];
        while page.read(&mut rest).is_ok_and(|n| n > 0) {}
        page.set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        start
    };
    assert_eq!(&ask(), b"HTTP/1.1 200 OK");
    let strangers: Vec<TcpStream> = (0..200)
        .map(|_| TcpStream::connect(host).unwrap())
        .collect();
    assert_eq!(server.get("/api/runs").status, 200);
    assert_eq!(&ask(), b"HTTP/1.1 200 OK");
    let mut closed = 0;
    for mut stranger in &strangers {
        stranger
            .set_read_timeout(Some(Duration::from_millis(20)))
            .unwrap();
        let ended = match stranger.read(&mut [0; 16]) {
            Ok(bytes) => bytes == 0,
            Err(error) => error.kind() == ErrorKind::ConnectionReset,
        };
        closed += usize::from(ended);
    }
    assert!((180..=190).contains(&closed), "{closed} of 200 are closed");
}

/// Connections that are left open by a program that knows the token.
#[test]
fn connections_with_the_token_are_bounded() {
    let server = Serving::start(vec![shared().join("products")]);
    let (host, base) = (&server.host, &server.base);
    let pages: Vec<TcpStream> = (0..120)
        .map(|_| {
            let mut page = TcpStream::connect(host).unwrap();
            let wait = Duration::from_secs(20);
            page.set_read_timeout(Some(wait)).unwrap();
            let request = format!("GET {base}/api/runs HTTP/1.1\r\nHost: {host}\r\n\r\n");
            page.write_all(request.as_bytes()).unwrap();
            let mut start = [0; 15];
            page.read_exact(&mut start).unwrap();
            assert_eq!(&start, b"HTTP/1.1 200 OK");
            page
        })
        .collect();
    let is_closed = |mut page: &TcpStream| {
        let wait = Duration::from_millis(20);
        page.set_read_timeout(Some(wait)).unwrap();
        loop {
            // The rest of the answer comes first.
            match page.read(&mut [0; 1 << 12]) {
                Ok(0) => return true,
                Ok(_) => {}
                Err(error) => return error.kind() == ErrorKind::ConnectionReset,
            }
        }
    };
    let closed = pages.iter().filter(|page| is_closed(page)).count();
    // 64 that have shown the token and 16 more stay.
    assert!((38..=42).contains(&closed), "{closed} of 120 are closed");
    assert_eq!(server.get("/api/runs").status, 200);
}

#[test]
fn logs_that_are_not_those_of_the_run_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let products = run_in(folder.path());
    fs::write(
        folder.path().join("flight.csv"),
        "time_s,x_m,y_m,z_m\n0,0,0,5\n1,0,1,5\n",
    )
    .unwrap();
    let server = Serving::start(vec![products.clone()]);
    let status = server.engine();
    assert_eq!(status["state"], "failed");
    let reason = status["reason"].as_str().unwrap();
    assert!(
        reason.contains("flight.csv") && reason.contains("expected the file"),
        "{reason}"
    );
    // The image is shown all the same.
    assert_eq!(server.get("/api/run/0/image/1/0/0").status, 200);
    drop(server);
    fs::remove_file(folder.path().join("flight.npz")).unwrap();
    let server = Serving::start(vec![products]);
    assert!(
        server.engine()["reason"]
            .as_str()
            .unwrap()
            .contains("flight.npz")
    );
}

#[test]
fn directories_without_a_run_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let open = |directories: Vec<std::path::PathBuf>| {
        let options = ServerOptions {
            directories,
            ..Default::default()
        };
        Server::open(&options).unwrap_err().to_string()
    };
    assert!(open(vec![folder.path().to_owned()]).contains("run.json"));
    fs::write(folder.path().join("run.json"), "{}").unwrap();
    let message = open(vec![folder.path().to_owned()]);
    assert!(
        message.contains("run.json: expected the record of a run"),
        "{message}"
    );
    assert!(open(Vec::new()).contains("expected the directory"));
}
