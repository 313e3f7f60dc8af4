//! Runs that leave Zarr, HDF5, VTK and phase history data; what is in them; and images from them.
//! `ACERRA_PYTHON` names a Python with xarray, h5py and sarkit, where there is one.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on has failed

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use acerra_chain::campaign::ProductFormat;
use acerra_chain::{Control, Journal};
use acerra_npz::NpzReader;
use acerra_products::data::convert;
use acerra_products::run_campaign;
use acerra_radar::{NeutralContent, Radargram, Samples, npz::write_npz};
use num_complex::Complex32;

const LIGHT_M_S: f64 = 299_792_458.0;
const TARGET_M: [f64; 3] = [5.0, 4.0, 0.0];
const TRACES: usize = 120;
const SAMPLES: usize = 960;
const STEP_S: f64 = 61.035e-12;
const INTERVAL_S: f64 = 0.02;

fn place(trace: usize) -> [f64; 3] {
    [
        0.2 * (0.05 * trace as f64).sin(),
        0.04 * trace as f64 + 1.6,
        5.0,
    ]
}

/// Echoes of a target: Gaussian pulses about 3.95 GHz.
fn radargram() -> Radargram {
    let echo = |trace: usize| {
        let away = place(trace);
        let range_m: f64 = (0..3)
            .map(|i| (away[i] - TARGET_M[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        move |n: usize| {
            let t = n as f64 * STEP_S - 2.0 * range_m / LIGHT_M_S;
            (1e3 * (-(t / 0.4e-9).powi(2)).exp() * (TAU * 3.95e9 * t).cos()) as f32
        }
    };
    let samples = (0..TRACES)
        .flat_map(|trace| (0..SAMPLES).map(echo(trace)))
        .collect();
    let time_s = (0..TRACES).map(|k| INTERVAL_S * k as f64).collect();
    Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap()
}

/// Log, trajectory and campaign of the flight; with or without a place on the Earth.
fn flight(folder: &Path, origin: &str, formats: &str) -> PathBuf {
    let log = File::create(folder.join("flight.npz")).unwrap();
    write_npz(log, &NeutralContent::Radargram(radargram()), None).unwrap();
    let mut csv = origin.to_owned();
    csv.push_str("time_s,x_m,y_m,z_m\n");
    for k in 0..TRACES {
        let [x, y, z] = place(k);
        writeln!(csv, "{},{x},{y},{z}", INTERVAL_S * k as f64).unwrap();
    }
    fs::write(folder.join("flight.csv"), csv).unwrap();
    let campaign = format!(
        "[radar]\nfile = 'flight.npz'\ndelay_ns = 0.0\nselect = 'all'\n\
         [trajectory]\nfile = 'flight.csv'\ntime_offset_s = 0.0\n\
         [preprocess]\nbackground = 'none'\ngate_ns = 'none'\n\
         [image]\nx_m = [4.0, 6.0]\ny_m = [3.0, 5.0]\nz_m = 0.0\npixel_m = 0.02\n\
         weight = 'trace'\n[checks]\ncontradictions = 'warn'\n[products]\nformats = [{formats}]\n"
    );
    let file = folder.join("flight.toml");
    fs::write(&file, campaign).unwrap();
    file
}

const ON_EARTH: &str = "# origin_deg_m: 40.9596 14.3696 75.0\n\
                        # second_zero_gps_week_tow_s: 2400 302400.25\n";

fn run(campaign: &Path, products: &Path) -> Vec<String> {
    let mut journal = Journal::default();
    run_campaign(campaign, products, &mut journal, &Control::default()).unwrap();
    journal.warnings.said().to_vec()
}

fn image(products: &Path) -> Vec<Complex32> {
    let mut npz = NpzReader::new(File::open(products.join("image.npz")).unwrap()).unwrap();
    let (shape, values) = npz.values("image", 1 << 20).unwrap();
    assert_eq!(shape, [101, 101]);
    values
        .iter()
        .map(|(re, im)| Complex32::new(*re as f32, *im as f32))
        .collect()
}

#[test]
fn a_run_leaves_its_data_and_they_make_the_same_image() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let campaign = flight(folder.path(), ON_EARTH, "'zarr', 'hdf5', 'vtk', 'cphd'");
    let products = at("products");
    run(&campaign, &products);
    let expected = image(&products);
    let peak = expected.iter().map(|z| z.norm()).fold(0.0, f32::max);
    let brightest = expected.iter().position(|z| z.norm() == peak).unwrap();
    let [x, y] = [
        4.0 + 0.02 * (brightest % 101) as f64,
        3.0 + 0.02 * (brightest / 101) as f64,
    ];
    assert!((x - TARGET_M[0]).hypot(y - TARGET_M[1]) < 0.05, "{x} {y}");

    // The same image from the phase history data, in the same frame.
    let from_cphd = "[radar]\nfile = 'products/spectra.cphd'\nchannel = '1'\n\
                     [image]\nx_m = [4.0, 6.0]\ny_m = [3.0, 5.0]\nz_m = 0.0\npixel_m = 0.02\n\
                     weight = 'trace'\n[checks]\ncontradictions = 'warn'\n";
    fs::write(at("again.toml"), from_cphd).unwrap();
    run(&at("again.toml"), &at("again"));
    let worst = image(&at("again"))
        .iter()
        .zip(&expected)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, f32::max);
    println!("largest difference {:.2e} of the peak", worst / peak);
    assert!(worst < 1e-5 * peak, "{worst} of {peak}");
    // It stands on the Earth as well, at the same instants.
    let first_row = |folder: &str| -> Vec<String> {
        let text = fs::read_to_string(at(folder).join("trajectory.csv")).unwrap();
        let (names, row) = (text.lines().next().unwrap(), text.lines().nth(1).unwrap());
        let wanted = ["latitude_deg", "longitude_deg", "height_m", "gpst"];
        let cells = names.split(',').zip(row.split(','));
        cells
            .filter(|(name, _)| wanted.contains(name))
            .map(|(_, cell)| cell.to_owned())
            .collect()
    };
    assert_eq!(first_row("products").len(), 4);
    assert_eq!(first_row("products"), first_row("again"));
    assert!(at("again/image-db.tif").is_file());

    // A run without these formats takes the older ones away.
    let plain = flight(folder.path(), ON_EARTH, "");
    run(&plain, &products);
    for name in ["data.zarr", "data.h5", "image.vti", "spectra.cphd"] {
        assert!(!products.join(name).exists(), "{name}");
    }
}

#[test]
fn products_are_converted_as_the_run_would_have_written_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let campaign = flight(folder.path(), ON_EARTH, "'zarr', 'vtk'");
    run(&campaign, &at("run"));
    let formats = [ProductFormat::Zarr, ProductFormat::Hdf5, ProductFormat::Vtk];
    convert(&at("run"), &formats, &at("converted")).unwrap();
    for name in [
        "image/c/0/0",
        "level/c/0/0",
        "x/zarr.json",
        "latitude/c/0",
        "time/zarr.json",
    ] {
        let of = |folder: &str| fs::read(at(folder).join("data.zarr").join(name)).unwrap();
        assert_eq!(of("run"), of("converted"), "{name}");
    }
    let group = |folder: &str| -> serde_json::Value {
        let bytes = fs::read(at(folder).join("data.zarr/zarr.json")).unwrap();
        serde_json::from_slice(&bytes).unwrap()
    };
    let (whole, converted) = (group("run"), group("converted"));
    for name in [
        "EVIDENCE",
        "FRAME",
        "ORIGIN_DEG_M",
        "INPUT_flight.npz",
        "VERTICAL_DATUM",
    ] {
        assert_eq!(
            whole["attributes"][name], converted["attributes"][name],
            "{name}"
        );
        assert!(whole["attributes"][name].is_string(), "{name}");
    }
    let own = |group: &serde_json::Value| -> serde_json::Value {
        serde_json::from_str(group["attributes"]["CONFIGURATION"].as_str().unwrap()).unwrap()
    };
    assert_eq!(own(&whole), own(&converted));
    let arrays = "/consolidated_metadata/metadata";
    assert!(whole.pointer(&format!("{arrays}/radargram")).is_some());
    assert!(whole.pointer(&format!("{arrays}/spectrum")).is_some());
    assert!(converted.pointer(&format!("{arrays}/spectrum")).is_none());
    assert!(at("converted/data.h5").is_file() && at("converted/image.vti").is_file());

    let refused = |folder: &Path, format| {
        let error = convert(folder, &[format], &at("never")).unwrap_err();
        assert!(!at("never").exists());
        format!("{error:#}")
    };
    let error = refused(&at("run"), ProductFormat::Cphd);
    assert!(error.contains("run the campaign again"), "{error}");
    let error = refused(folder.path(), ProductFormat::Zarr);
    assert!(error.contains("no run.json"), "{error}");
    fs::write(at("run/trajectory.csv"), "time_s,x_m\n1.0,far\n").unwrap();
    let error = refused(&at("run"), ProductFormat::Zarr);
    assert!(
        error.contains("line 2, x_m: expected a number, found \"far\""),
        "{error}"
    );
    let bytes = fs::read(at("run/image.npz")).unwrap();
    fs::write(at("run/image.npz"), &bytes[..bytes.len() / 2]).unwrap();
    let error = refused(&at("run"), ProductFormat::Vtk);
    assert!(error.contains("image.npz"), "{error}");
}

#[test]
fn damaged_products_are_refused_or_read_but_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = flight(folder.path(), ON_EARTH, "");
    let products = folder.path().join("products");
    run(&campaign, &products);
    let output = folder.path().join("output");
    let attempt = || convert(&products, &[ProductFormat::Vtk], &output).is_ok();
    assert!(attempt());
    let mut refused = 0;
    for name in ["trajectory.csv", "targets.json", "run.json", "image.npz"] {
        let path = products.join(name);
        let sound = fs::read(&path).unwrap();
        let step = (sound.len() / 40).max(1);
        for at in (0..sound.len()).step_by(step) {
            fs::write(&path, &sound[..at]).unwrap();
            refused += usize::from(!attempt());
            for byte in [0, b'9', b',', 0xff] {
                let mut damaged = sound.clone();
                damaged[at] = byte;
                fs::write(&path, &damaged).unwrap();
                attempt();
            }
        }
        fs::write(&path, &sound).unwrap();
    }
    assert!(refused > 100, "{refused} of 160 pieces were refused");
}

#[test]
fn without_a_place_on_the_earth_there_is_no_phase_history_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = flight(folder.path(), "", "'cphd', 'zarr'");
    let products = folder.path().join("products");
    let warnings = run(&campaign, &products);
    assert!(!products.join("spectra.cphd").exists());
    assert!(products.join("data.zarr/image/zarr.json").is_file());
    let said = warnings.iter().find(|w| w.contains("spectra.cphd"));
    assert!(
        said.unwrap().contains("no place on the Earth"),
        "{warnings:?}"
    );
}

#[test]
fn volumes_are_written_slice_by_slice() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = flight(folder.path(), ON_EARTH, "'zarr', 'vtk', 'hdf5'");
    let text = fs::read_to_string(&campaign).unwrap();
    let volume = text.replace("z_m = 0.0", "z_m = [-0.2, 0.2]\npixel_z_m = 0.1");
    fs::write(&campaign, volume).unwrap();
    let products = folder.path().join("products");
    run(&campaign, &products);
    let volume = fs::read(products.join("data.zarr/volume/zarr.json")).unwrap();
    let volume: serde_json::Value = serde_json::from_slice(&volume).unwrap();
    assert_eq!(volume["shape"], serde_json::json!([5, 101, 101]));
    assert_eq!(
        volume["dimension_names"],
        serde_json::json!(["z", "y", "x"])
    );
    assert!(products.join("data.zarr/volume/c/4/0/0").is_file());
    let vti = fs::read(products.join("volume.vti")).unwrap();
    let head = String::from_utf8_lossy(&vti[..400]).into_owned();
    assert!(head.contains("WholeExtent=\"0 100 0 100 0 4\""), "{head}");
    let hdf5 = fs::read(products.join("data.h5")).unwrap();
    let holds = |name: &[u8]| hdf5.windows(name.len()).any(|part| part == name);
    assert!(holds(b"volume_real") && holds(b"volume_imag"));
}

/// A geoid that lies at one height from 40° to 42° N and from 13° to 15° E, as NOAA writes it (GTX).
fn geoid(height_m: f32) -> Vec<u8> {
    let mut gtx = Vec::new();
    for edge_or_step in [40.0_f64, 13.0, 1.0, 1.0] {
        gtx.extend(edge_or_step.to_be_bytes());
    }
    for count in [3_u32, 3] {
        gtx.extend(count.to_be_bytes());
    }
    gtx.extend(height_m.to_be_bytes().repeat(9));
    gtx
}

#[test]
fn heights_above_the_sea_stand_beside_those_above_the_ellipsoid() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("geoid.gtx"), geoid(48.25)).unwrap();
    let with_geoid = |origin: &str| {
        let campaign = flight(folder.path(), origin, "'geojson'");
        let text = fs::read_to_string(&campaign).unwrap();
        let text = text.replace("[image]\n", "[image]\ngeoid = 'geoid.gtx'\n");
        fs::write(&campaign, text).unwrap();
        run(&campaign, &at("products"))
    };
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(at("products").join(name)).unwrap()).unwrap()
    };
    let warnings = with_geoid(ON_EARTH);
    assert!(
        !warnings.iter().any(|w| w.contains("geoid")),
        "{warnings:?}"
    );
    let target = &json("targets.json")["targets"][0];
    let ellipsoidal_m = target["place_deg_m"][2].as_f64().unwrap();
    let above_m = target["height_above_geoid_m"].as_f64().unwrap();
    assert!((ellipsoidal_m - 75.0).abs() < 0.01, "{target}");
    assert!((ellipsoidal_m - 48.25 - above_m).abs() < 1e-5, "{target}");
    let feature = &json("targets.geojson")["features"][0]["properties"];
    assert_eq!(feature["height_above_geoid_m"], above_m);
    let inputs = json("run.json")["inputs"].to_string();
    assert!(inputs.contains("geoid.gtx"), "{inputs}");

    // Elsewhere on the Earth, and nowhere on it.
    let elsewhere = ON_EARTH.replace("40.9596", "50.9596");
    for (origin, reason) in [
        (elsewhere.as_str(), "does not cover 50.9596"),
        ("", "local frame"),
    ] {
        let warnings = with_geoid(origin);
        assert!(warnings.iter().any(|w| w.contains(reason)), "{warnings:?}");
        assert!(json("targets.json")["targets"][0]["height_above_geoid_m"].is_null());
    }
}

/// Level ground about the flight as a GeoTIFF whose heights count from the sea (EGM96).
fn level_ground(height_m: f32) -> Vec<u8> {
    use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
    use tiff::tags::Tag;
    let mut out = Vec::new();
    let mut file = TiffEncoder::new(std::io::Cursor::new(&mut out)).unwrap();
    let mut image = file.new_image::<Gray32Float>(20, 20).unwrap();
    let tags = image.encoder();
    let (scale, tie): (&[f64], &[f64]) =
        (&[0.001, 0.001, 0.0], &[0.0, 0.0, 0.0, 14.36, 40.97, 0.0]);
    // Geographic, cells as areas, WGS 84; heights above EGM96.
    let keys: &[u16] = &[
        1, 1, 0, 4, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326, 4096, 0, 1, 5773,
    ];
    tags.write_tag(Tag::ModelPixelScaleTag, scale).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, tie).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
    image.write_data(&[height_m; 400]).unwrap();
    out
}

#[test]
fn terrain_above_the_sea_is_raised_by_the_geoid() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("geoid.gtx"), geoid(48.25)).unwrap();
    fs::write(at("ground.tif"), level_ground(26.75)).unwrap();
    let campaign = flight(folder.path(), ON_EARTH, "");
    let text = fs::read_to_string(&campaign).unwrap();
    let on_terrain = |keys: &str| {
        let text = text.replace("z_m = 0.0", &format!("terrain = 'ground.tif'\n{keys}"));
        fs::write(&campaign, text).unwrap();
        let mut journal = Journal::default();
        let made = run_campaign(
            &campaign,
            &at("products"),
            &mut journal,
            &Control::default(),
        );
        (
            made.map(|o| o.measured.targets),
            journal.warnings.said().to_vec(),
        )
    };
    for keys in ["geoid = 'geoid.gtx'", "geoid_height_m = 48.25"] {
        let (targets, warnings) = on_terrain(keys);
        let target = &targets.unwrap()[0];
        assert!(target.z_m.abs() < 0.01, "{keys}: {target:?}");
        assert!(
            (target.x_m - TARGET_M[0]).abs() < 0.05,
            "{keys}: {target:?}"
        );
        assert!(
            !warnings.iter().any(|w| w.contains("count from")),
            "{warnings:?}"
        );
    }
    let (_, warnings) = on_terrain("");
    assert!(
        warnings.iter().any(|w| w.contains("count from")),
        "{warnings:?}"
    );
    let (both, _) = on_terrain("geoid = 'geoid.gtx'\ngeoid_height_m = 48.25");
    assert!(format!("{:#}", both.unwrap_err()).contains("geoid_height_m exclude"));
}

/// The same run by xarray, h5py and sarkit.
const ASK: &str = r#"
import sys, json, numpy as np, xarray as xr, h5py
import sarkit.cphd as skcphd, sarkit.verification as skver
folder = sys.argv[1]
npz = np.load(folder + "/image.npz")["image"]
d = xr.open_zarr(folder + "/data.zarr")
with h5py.File(folder + "/data.h5") as f:
    hdf5 = f["image_real"][:] + 1j * f["image_imag"][:]
with open(folder + "/spectra.cphd", "rb") as f:
    check = skver.CphdConsistency.from_file(f, thorough=True)
    check.check()
failed = [t["details"] for v in check.failures().values() for t in v["details"] if not t["passed"]]
with open(folder + "/spectra.cphd", "rb") as f, skcphd.Reader(f) as r:
    tree = r.metadata.xmltree
    signal, pvps = r.read_channel("1")
    names = [p.get("name") for p in tree.findall("{*}ProductInfo/{*}Parameter")]
# Backprojection of the target's pixel by what CPHD says alone.
iarp = pvps["SRPPos"][0]
x, y = (np.array([float(tree.findtext(f"{{*}}SceneCoordinates/{{*}}ReferenceSurface/{{*}}Planar/{{*}}{a}/{{*}}{b}")) for b in "XYZ"]) for a in ("uIAX", "uIAY"))
c = 299792458.0
def pixel(east, north):
    place = iarp + east * x + north * y
    two_way = lambda p: np.linalg.norm(pvps["TxPos"] - p, axis=1) + np.linalg.norm(pvps["RcvPos"] - p, axis=1)
    toa = (two_way(place) - two_way(iarp)) / c
    f = pvps["SC0"][:, None] + pvps["SCSS"][:, None] * np.arange(signal.shape[1])
    sgn = int(tree.findtext("{*}Global/{*}SGN"))
    return abs((signal * np.exp(-2j * np.pi * sgn * f * toa[:, None])).sum())
offsets = np.linspace(-0.1, 0.1, 21)
grid = np.array([[pixel(e, n) for e in offsets] for n in offsets])
at = np.unravel_index(grid.argmax(), grid.shape)
print(json.dumps({
    "zarr": bool((d.image.values == npz).all()), "hdf5": bool((hdf5 == npz).all()),
    "time": str(d.time.values[0])[:22], "dims": dict(d.sizes), "lat": float(d.latitude[0]),
    "units": {k: v.attrs.get("units") for k, v in d.variables.items() if "units" in v.attrs},
    "failed": failed, "names": names, "focus": [float(offsets[at[1]]), float(offsets[at[0]])],
    "radargram": str(d.radargram.dims), "attrs": sorted(d.attrs),
}))
"#;

#[test]
fn other_programs_read_what_a_run_leaves() {
    let Some(python) = std::env::var_os("ACERRA_PYTHON") else {
        eprintln!("skipped: ACERRA_PYTHON names no Python with xarray, zarr, h5py and sarkit");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let campaign = flight(folder.path(), ON_EARTH, "'zarr', 'hdf5', 'cphd'");
    let products = folder.path().join("products");
    run(&campaign, &products);
    let answer = Command::new(python)
        .args(["-c", ASK])
        .arg(&products)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(answer.status.success(), "{errors}");
    let told: serde_json::Value = serde_json::from_slice(&answer.stdout).unwrap();
    assert_eq!(
        [&told["zarr"], &told["hdf5"]],
        [&serde_json::json!(true); 2],
        "{told}"
    );
    // 302400.25 s of GPS week 2400 is 18 s earlier in UTC.
    assert_eq!(told["time"], "2026-01-07T11:59:42.25", "{told}");
    assert_eq!(told["dims"]["trace"], TRACES);
    assert_eq!(told["units"]["frequency"], "Hz");
    assert_eq!(told["radargram"], "('pulse', 'fast_time')");
    assert!((told["lat"].as_f64().unwrap() - 40.95961).abs() < 1e-4);
    for name in [
        "EVIDENCE",
        "CONFIGURATION",
        "TIME_SPAN_GPST",
        "VERTICAL_DATUM",
    ] {
        let is_in = |list: &serde_json::Value| list.as_array().unwrap().iter().any(|n| n == name);
        assert!(
            is_in(&told["names"]) && is_in(&told["attrs"]),
            "{name}: {told}"
        );
    }
    // The checker tells the ground range to four digits and asks for six.
    let failed = told["failed"].as_array().unwrap();
    let is_rounding = |f: &serde_json::Value| f == "GroundRange matches defined PVP/calculation";
    assert!(failed.iter().all(is_rounding), "{told}");
    // The target stands in the middle of the image.
    for k in 0..2 {
        assert!(told["focus"][k].as_f64().unwrap().abs() < 0.021, "{told}");
    }
}
