//! Numbers of rasters are not always metres: scales, offsets, units, masks and ways of packing.
#![allow(clippy::unwrap_used)]

mod tiff_file;

use std::io::Cursor;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::geoid::GeoidGrid;
use acerra_geo::terrain::{Crs, TerrainError, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use tiff_file::{Tiff, keys};

const SIZE: [u32; 2] = [40, 30];

/// Height of a cell (m), to a millimetre.
fn height_m(i: u32, j: u32) -> f64 {
    (1e3 * (62.0 + 0.25 * f64::from(i) - 0.125 * f64::from(j))).round() * 1e-3
}

/// A raster of metre cells about 41° N 14.2° E in UTM zone 33, its numbers yet to be written.
fn raster(bits: u16, format: u16, more_keys: &[u16], crs: u16) -> Tiff {
    let mut tiff = Tiff::new(SIZE[0], SIZE[1], bits, format);
    tiff.double(33550, &[1.0, 1.0, 0.0]);
    tiff.double(33922, &[0.0, 0.0, 0.0, 432_700.0, 4_539_080.0, 0.0]);
    let mut all = keys(1, 1, crs);
    all.extend(more_keys);
    tiff.short(34735, &all);
    tiff
}

fn metadata(items: &str) -> String {
    format!("<GDALMetadata>\n{items}</GDALMetadata>\n")
}

fn float(v: f64) -> Vec<u8> {
    (v as f32).to_le_bytes().to_vec()
}

fn heights(bytes: Vec<u8>) -> Result<Vec<Result<f64, TerrainError>>, TerrainError> {
    let frame = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
    let file = TerrainFile::open(Cursor::new(bytes), &TerrainOptions::default())?;
    let terrain = file.in_frame(&Frame::Enu(frame), [-12.0, 14.0], [-10.0, 10.0])?;
    let places = [(0.0, 0.0), (10.0, -7.0), (-11.3, 8.7), (3.3, 0.1)];
    Ok(places
        .map(|(x, y)| terrain.height_m(x, y))
        .into_iter()
        .collect())
}

fn plain() -> Vec<f64> {
    let mut tiff = raster(32, 3, &[], 32633);
    tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
    values(tiff.bytes())
}

fn values(bytes: Vec<u8>) -> Vec<f64> {
    heights(bytes)
        .unwrap()
        .into_iter()
        .map(Result::unwrap)
        .collect()
}

fn assert_same(found: &[f64], expected: &[f64], tolerance_m: f64, what: &str) {
    for (f, e) in found.iter().zip(expected) {
        assert!(
            (f - e).abs() < tolerance_m,
            "{what}: {found:?} {expected:?}"
        );
    }
}

const FOOT_M: f64 = 0.3048;
const US_SURVEY_FOOT_M: f64 = 1200.0 / 3937.0;

#[test]
fn scale_and_offset_are_applied_and_no_data_is_a_stored_number() {
    let mut tiff = raster(16, 2, &[], 32633);
    tiff.text(
        42112,
        &metadata(
            "<Item name=\"OFFSET\" sample=\"0\" role=\"offset\">60</Item>\
             <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.001</Item>\
             <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item>",
        ),
    );
    tiff.text(42113, "-32768");
    tiff.strips(SIZE, 7, |i, j| {
        let stored = (1e3 * (height_m(i, j) - 60.0)).round() as i16;
        let stored = if [i, j] == [35, 3] { i16::MIN } else { stored };
        stored.to_le_bytes().to_vec()
    });
    assert_same(&values(tiff.bytes()), &plain(), 1e-4, "scaled");
}

#[test]
fn feet_are_metres_by_tag_by_key_and_by_the_vertical_reference() {
    let unit = |name: &str| {
        metadata(&format!(
            "<Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">{name}</Item>"
        ))
    };
    for (name, more_keys, foot_m) in [
        (Some("ft"), vec![], FOOT_M),
        (Some("US survey foot"), vec![], US_SURVEY_FOOT_M),
        (Some("m"), vec![], 1.0),
        (None, vec![4099, 0, 1, 9002], FOOT_M),
        (None, vec![4099, 0, 1, 9003], US_SURVEY_FOOT_M),
        (None, vec![4096, 0, 1, 6360], US_SURVEY_FOOT_M),
        (Some("ft"), vec![4096, 0, 1, 8228, 4099, 0, 1, 9002], FOOT_M),
    ] {
        let mut tiff = raster(32, 3, &more_keys, 32633);
        if let Some(name) = name {
            tiff.text(42112, &unit(name));
        }
        tiff.strips(SIZE, 7, |i, j| float(height_m(i, j) / foot_m));
        let what = format!("{name:?} {more_keys:?}");
        assert_same(&values(tiff.bytes()), &plain(), 1e-4, &what);
    }
    for (items, more_keys, part) in [
        (unit("fathom"), vec![], "fathom"),
        (unit("ft"), vec![4099, 0, 1, 9003], "one unit"),
        (unit("m"), vec![4096, 0, 1, 5715], "depths"),
        (
            metadata("<Item name=\"SCALE\" sample=\"0\" role=\"scale\">much</Item>"),
            vec![],
            "\"much\"",
        ),
        (
            metadata("<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0</Item>"),
            vec![],
            "other than 0",
        ),
        ("<GDALMetadata><Item>".to_owned(), vec![], "expected XML"),
    ] {
        let mut tiff = raster(32, 3, &more_keys, 32633);
        tiff.text(42112, &items);
        tiff.strips(SIZE, 7, |_, _| float(1.0));
        let message = heights(tiff.bytes()).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn masked_cells_hold_no_data() {
    let mut tiff = raster(32, 3, &[], 32633);
    tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
    // Cells 28 to 31 of rows 16 to 24 are masked: about 10 m east, 7 m south of the frame's origin.
    let mut mask = Tiff::new(SIZE[0], SIZE[1], 1, 1);
    mask.long(254, 4);
    mask.short(262, &[4]);
    mask.long(278, 11);
    let byte = |row: u32, at: u32| match (row, at) {
        (16..=24, 3) => 0xf0,
        _ => 0xff,
    };
    mask.chunks = [0..11, 11..22, 22..30_u32]
        .map(|rows| rows.flat_map(|j| (0..5).map(move |k| byte(j, k))).collect())
        .to_vec();
    let found = heights(tiff.bytes_with(mask)).unwrap();
    assert!(matches!(found[1], Err(TerrainError::Hole { .. })));
    let expected = plain();
    for k in [0, 2, 3] {
        assert!((found[k].as_ref().unwrap() - expected[k]).abs() < 1e-6);
    }
}

/// Rows of floats, split into planes of bytes and differences (predictor 3), in Zstandard.
#[test]
fn zstandard_with_the_predictor_of_floats() {
    let mut tiff = raster(32, 3, &[], 32633);
    tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
    tiff.short(259, &[50_000]);
    tiff.short(317, &[3]);
    let width = SIZE[0] as usize;
    for chunk in &mut tiff.chunks {
        for row in chunk.chunks_mut(4 * width) {
            let numbers = row.to_vec();
            for (k, number) in numbers.chunks(4).enumerate() {
                for plane in 0..4 {
                    row[plane * width + k] = number[3 - plane];
                }
            }
            for k in (1..row.len()).rev() {
                row[k] = row[k].wrapping_sub(row[k - 1]);
            }
        }
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        *chunk = ruzstd::encoding::compress_to_vec(&chunk[..], level);
    }
    assert_same(&values(tiff.bytes()), &plain(), 1e-6, "zstd");

    let mut lerc = raster(32, 3, &[], 32633);
    lerc.strips(SIZE, 7, |_, _| float(1.0));
    lerc.short(259, &[34_887]);
    let message = heights(lerc.bytes()).unwrap_err().to_string();
    assert!(
        message.contains("LERC") && message.contains("gdal_translate"),
        "{message}"
    );
}

#[test]
fn national_systems_whose_datum_is_known() {
    // RDN2008 / UTM zone 33N has the numbers of WGS84's zone; Web Mercator does not.
    let mut tiff = raster(32, 3, &[], 6708);
    tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
    assert_same(&values(tiff.bytes()), &plain(), 1e-4, "RDN2008");
    let mut tiff = raster(32, 3, &[3076, 0, 1, 9002], 32633);
    tiff.strips(SIZE, 7, |_, _| float(1.0));
    let message = heights(tiff.bytes()).unwrap_err().to_string();
    assert!(message.contains("ProjLinearUnits"), "{message}");

    // Cells of 1.32 m of the map, a metre on the ground at 41°; PROJ 9.5 puts the origin at these numbers.
    let mut tiff = Tiff::new(SIZE[0], SIZE[1], 32, 3);
    tiff.double(33550, &[1.0, 1.0, 0.0]);
    let corner = [1_580_736.769_3 - 20.5, 5_012_341.663_8 + 15.5];
    tiff.double(33922, &[0.0, 0.0, 0.0, corner[0], corner[1], 0.0]);
    tiff.short(34735, &keys(1, 1, 3857));
    tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
    let file = TerrainFile::open(Cursor::new(tiff.bytes()), &TerrainOptions::default()).unwrap();
    assert_eq!(file.crs().unwrap(), Crs::Epsg(3857));
    let frame = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
    let terrain = file
        .in_frame(&Frame::Enu(frame), [-5.0, 5.0], [-5.0, 5.0])
        .unwrap();
    let found = terrain.height_m(0.0, 0.0).unwrap();
    assert!((found - (height_m(20, 15) - 60.0)).abs() < 1e-3, "{found}");
}

#[test]
fn longitudes_may_go_on_to_the_east_of_180_degrees() {
    // The same ground west of Greenwich as −70.5° and as 289.5°.
    let at = |west_deg: f64| {
        let mut tiff = Tiff::new(SIZE[0], SIZE[1], 32, 3);
        tiff.double(33550, &[1e-5, 1e-5, 0.0]);
        tiff.double(33922, &[0.0, 0.0, 0.0, west_deg, -33.0, 0.0]);
        tiff.short(34735, &keys(2, 1, 4326));
        tiff.strips(SIZE, 7, |i, j| float(height_m(i, j)));
        let file = TerrainFile::open(Cursor::new(tiff.bytes()), &TerrainOptions::default());
        let origin = Geodetic::from_degrees(-33.000_15, -70.4998, 60.0);
        let frame = Frame::Enu(EnuFrame::new(origin));
        let terrain = file.unwrap().in_frame(&frame, [-5.0, 5.0], [-5.0, 5.0]);
        terrain.unwrap().height_m(1.0, 2.0).unwrap()
    };
    assert!((at(-70.5) - at(289.5)).abs() < 1e-6);
}

#[test]
fn grids_in_text_with_keys_in_any_order_nan_and_a_prj_beside() {
    let folder = std::env::temp_dir().join(format!("acerra-prj-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("ground.asc");
    let mut text = "NODATA_value nan\nCELLSIZE 1\nyllcorner 4539050\nxllcorner 432700\nNROWS 30\n\
                    NCOLS 40\n"
        .to_owned();
    for j in 0..30 {
        for i in 0..40 {
            let hole = (28..32).contains(&i) && (16..25).contains(&j);
            text += &match hole {
                true => "NaN ".to_owned(),
                false => format!("{:.3} ", height_m(i, j)),
            };
        }
        text.push('\n');
    }
    std::fs::write(&path, text).unwrap();
    let wkt = "PROJCS[\"WGS_1984_UTM_Zone_33N\",GEOGCS[\"GCS_WGS_1984\"]]";
    std::fs::write(folder.join("ground.prj"), wkt).unwrap();
    let options = TerrainOptions::default();
    let file = TerrainFile::open_path(&path, &options).unwrap();
    let utm = Crs::Utm {
        zone: 33,
        south: false,
    };
    assert_eq!(file.crs().unwrap(), utm);
    let frame = Frame::Enu(EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0)));
    let terrain = file.in_frame(&frame, [-12.0, 14.0], [-10.0, 10.0]).unwrap();
    assert!((terrain.height_m(0.0, 0.0).unwrap() - plain()[0]).abs() < 1e-3);
    assert!(terrain.height_m(10.0, -7.0).is_err());

    std::fs::write(folder.join("ground.prj"), "Projection UTM\nZone 33\n").unwrap();
    let message = TerrainFile::open_path(&path, &options).unwrap_err();
    assert!(message.to_string().contains("ground.prj"), "{message}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// What unpacks to gigabytes is refused by its size, before anything is unpacked.
#[test]
fn tiles_that_dwarf_the_image_are_refused() {
    let tall = |side: [u32; 2], rows: u32, chunks: usize| {
        let mut tiff = raster(32, 3, &[], 32633);
        tiff.long(257, rows);
        tiff.tiled = true;
        tiff.long(322, side[0]);
        tiff.long(323, side[1]);
        tiff.chunks = vec![vec![0]; chunks];
        heights(tiff.bytes()).unwrap_err()
    };
    // One tile of 4 GB; tiles of 64 MB, of which each holds a row of the image.
    for error in [tall([1024, 1 << 20], 30, 1), tall([1 << 24, 1], 30, 30)] {
        assert!(matches!(error, TerrainError::Limit { .. }), "{error}");
    }
}

#[test]
fn geoid_grids_have_scales_too_and_other_grids_are_refused() {
    let grid = |stored: &dyn Fn(f64) -> Vec<u8>, bits, format, items: &str| {
        let mut tiff = Tiff::new(13, 13, bits, format);
        tiff.double(33550, &[0.25, 0.25, 0.0]);
        tiff.double(33922, &[0.0, 0.0, 0.0, 138.0, 37.0, 0.0]);
        tiff.short(34735, &keys(2, 1, 4326));
        tiff.text(42112, &metadata(items));
        tiff.strips([13, 13], 13, |i, j| {
            stored(39.5 + 0.5 * f64::from(i) - 0.5 * f64::from(j))
        });
        GeoidGrid::from_reader(&tiff.bytes()[..])
    };
    let scale = "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.5</Item>";
    let kind = "<Item name=\"TYPE\">VERTICAL_OFFSET_GEOGRAPHIC_TO_VERTICAL</Item>";
    let whole = |v: f64| ((v / 0.5) as i16).to_le_bytes().to_vec();
    let by_floats = grid(&float, 32, 3, kind).unwrap();
    let by_scale = grid(&whole, 16, 2, &format!("{kind}{scale}")).unwrap();
    for (latitude, longitude) in [(35.1, 139.6), (36.5, 138.5)] {
        let found = by_scale.height_m(latitude, longitude).unwrap();
        let expected = by_floats.height_m(latitude, longitude).unwrap();
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    let velocity = "<Item name=\"TYPE\">VELOCITY</Item>";
    let error = grid(&float, 32, 3, velocity).unwrap_err().to_string();
    assert!(error.contains("VELOCITY"), "{error}");
}
