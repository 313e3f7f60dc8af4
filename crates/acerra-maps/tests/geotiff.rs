//! Maps as other programs read them. `rasterio` (GDAL) is asked where `ACERRA_PYTHON` names a Python
//! that has it.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on has failed

use std::io::Cursor;
use std::process::Command;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_maps::crs::MapCrs;
use acerra_maps::geotiff::{Description, write_geotiff};
use acerra_maps::placement::{LocalGrid, Placement};
use acerra_maps::raster::{LevelScale, Raster};
use num_complex::Complex32;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

const GRID: LocalGrid = LocalGrid {
    x0_m: -3.0,
    y0_m: -2.0,
    z_m: -1.5,
    pixel_m: 0.02,
    nx: 700,
    ny: 530,
};

fn frame() -> EnuFrame {
    EnuFrame::new(Geodetic::from_degrees(40.9596, 14.3696, 75.0))
}

/// A power that tells its pixel: row 0 is the southernmost.
fn power() -> Vec<f32> {
    (0..GRID.nx * GRID.ny).map(|k| 1.0 + k as f32).collect()
}

fn written(raster: &Raster<'_>, crs: Option<&MapCrs>) -> Vec<u8> {
    let placement = match crs {
        Some(crs) => Placement::fit(&frame(), &GRID, crs).unwrap(),
        None => Placement::local(&GRID),
    };
    let description = Description {
        title: "power of a test".to_owned(),
        software: "Acerra".to_owned(),
        unit: "1".to_owned(),
        items: vec![("ORIGIN".to_owned(), "40.9596° <75 m>".to_owned())],
    };
    let mut file = Cursor::new(Vec::new());
    write_geotiff(&mut file, raster, &placement, crs, &description).unwrap();
    file.into_inner()
}

#[test]
fn values_come_back_with_the_north_on_top() {
    let power = power();
    let crs = MapCrs::utm_about(frame().origin());
    let file = written(&Raster::power(&power, GRID.nx, GRID.ny), Some(&crs));
    let mut decoder = Decoder::new(Cursor::new(file)).unwrap();
    assert_eq!(decoder.dimensions().unwrap(), (700, 530));
    let DecodingResult::F32(values) = decoder.read_image().unwrap() else {
        panic!("powers are single precision");
    };
    for (row, line) in values.chunks(GRID.nx).enumerate() {
        let from = (GRID.ny - 1 - row) * GRID.nx;
        assert_eq!(line, &power[from..from + GRID.nx], "row {row}");
    }
    let keys = decoder.find_tag(Tag::GeoKeyDirectoryTag).unwrap().unwrap();
    let keys = keys.into_u16_vec().unwrap();
    assert_eq!(&keys[keys.len() - 4..], [3072, 0, 1, 32633]);
    // Two overviews, of 350 × 265 and 175 × 133.
    let mut sizes = Vec::new();
    while decoder.more_images() {
        decoder.next_image().unwrap();
        sizes.push(decoder.dimensions().unwrap());
    }
    assert_eq!(sizes, [(350, 265), (175, 133)]);
}

#[test]
fn a_frame_without_a_place_claims_none() {
    let power = power();
    let file = written(
        &Raster::level_db(&power, GRID.nx, GRID.ny, LevelScale::ABSOLUTE),
        None,
    );
    let mut decoder = Decoder::new(Cursor::new(file)).unwrap();
    assert!(decoder.find_tag(Tag::GeoKeyDirectoryTag).unwrap().is_none());
    let matrix = decoder
        .get_tag_f64_vec(Tag::ModelTransformationTag)
        .unwrap();
    // The outer corner of the north-western pixel.
    assert!((matrix[3] + 3.01).abs() < 1e-9 && (matrix[7] - (-2.0 + 529.5 * 0.02)).abs() < 1e-9);
    assert!((matrix[0] - 0.02).abs() < 1e-12 && (matrix[5] + 0.02).abs() < 1e-12);
}

#[test]
fn too_few_values_are_refused() {
    let placement = Placement::local(&GRID);
    let raster = Raster::power(&[1.0; 12], 4, 4);
    let mut file = Cursor::new(Vec::new());
    let error = write_geotiff(
        &mut file,
        &raster,
        &placement,
        None,
        &Description::default(),
    );
    assert_eq!(
        error.unwrap_err().to_string(),
        "expected 16 pixels, found 12"
    );
}

/// Asked of GDAL: place of the corners by PROJ, values, overviews, metadata, and whether the layout is
/// cloud optimised.
const ASK: &str = r#"
import sys, json, rasterio, pyproj
from rio_cogeo.cogeo import cog_validate
path, lat, lon = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
with rasterio.open(path) as f:
    corners = [f.transform * c for c in [(0.5, 0.5), (f.width - 0.5, f.height - 0.5)]]
    geo = pyproj.Transformer.from_crs(f.crs, "EPSG:4326", always_xy=True)
    value = f.read(1)[3, 5]
    print(json.dumps({
        "crs": f.crs.to_epsg(), "overviews": f.overviews(1), "nodata": str(f.nodata),
        "unit": f.units[0], "tags": f.tags().get("ORIGIN"), "dtype": f.dtypes[0],
        "value": [float(complex(value).real), float(complex(value).imag)],
        "corners": [geo.transform(*c) for c in corners],
        "cog": cog_validate(path, quiet=True)[0],
    }))
"#;

#[test]
fn gdal_sees_places_values_and_layout() {
    let Some(python) = std::env::var_os("ACERRA_PYTHON") else {
        eprintln!("skipped: ACERRA_PYTHON names no Python with rasterio, pyproj and rio-cogeo");
        return;
    };
    let power = power();
    let complex: Vec<Complex32> = power.iter().map(|p| Complex32::new(*p, -*p)).collect();
    let k = (GRID.ny - 1 - 3) * GRID.nx + 5;
    let level = 10.0 * f64::from(power[k]).log10();
    let utm = MapCrs::utm_about(frame().origin());
    let mercator = MapCrs::from_epsg(3857).unwrap();
    let degrees = MapCrs::from_epsg(4326).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let powers = Raster::power(&power, GRID.nx, GRID.ny);
    let levels = Raster::level_db(&power, GRID.nx, GRID.ny, LevelScale::ABSOLUTE);
    let amplitudes = Raster::complex(&complex, GRID.nx, GRID.ny);
    let p = f64::from(power[k]);
    for (raster, crs, dtype, value) in [
        (powers, &utm, "float32", [p, 0.0]),
        (levels, &mercator, "float32", [level, 0.0]),
        (amplitudes, &degrees, "complex64", [p, -p]),
    ] {
        let path = folder.path().join("map.tif");
        std::fs::write(&path, written(&raster, Some(crs))).unwrap();
        let answer = Command::new(&python)
            .args(["-c", ASK])
            .arg(&path)
            .args(["40.9596", "14.3696"])
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert!(answer.status.success(), "{errors}");
        let seen: serde_json::Value = serde_json::from_slice(&answer.stdout).unwrap();
        assert_eq!(seen["crs"], crs.epsg());
        assert_eq!(seen["overviews"], serde_json::json!([2, 4]));
        assert_eq!(seen["dtype"], dtype);
        assert_eq!(seen["unit"], "1");
        assert_eq!(seen["tags"], "40.9596° <75 m>");
        assert_eq!(seen["cog"], true, "{errors}");
        for (found, expected) in [0, 1].map(|i| (seen["value"][i].as_f64().unwrap(), value[i])) {
            assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{seen}");
        }
        // North-western and south-eastern pixel.
        let [east_m, south_m] = [699.0 * 0.02 - 3.0, -2.0];
        for (corner, local) in [[-3.0, 529.0 * 0.02 - 2.0], [east_m, south_m]]
            .iter()
            .enumerate()
        {
            let expected = frame().geodetic_from_enu([local[0], local[1], -1.5]);
            let found = [0, 1].map(|i| seen["corners"][corner][i].as_f64().unwrap());
            let north_m = (found[1] - expected.latitude_deg()) * 111_000.0;
            let east_m = (found[0] - expected.longitude_deg()) * 84_000.0;
            assert!(north_m.hypot(east_m) < 1e-3, "{seen}");
        }
    }
}
