//! Terrain files: every kind that is read, and what is refused.
#![allow(clippy::unwrap_used)]

mod tiff_file;

use std::io::Cursor;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::terrain::{Crs, LocalTerrain, TerrainError, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use tiff_file::{Tiff, keys};

fn open(bytes: Vec<u8>) -> Result<TerrainFile<Cursor<Vec<u8>>>, TerrainError> {
    TerrainFile::open(Cursor::new(bytes), &TerrainOptions::default())
}

/// A frame about 41° N 14.2° E, 60 m above the ellipsoid.
fn frame() -> (Frame, EnuFrame) {
    let enu = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
    (Frame::Enu(enu), enu)
}

const SIZE: [u32; 2] = [37, 29];

/// Ground as a function of longitude and latitude that interpolation keeps.
fn plane(longitude_deg: f64, latitude_deg: f64) -> f64 {
    55.0 + 4000.0 * (longitude_deg - 14.2) - 2500.0 * (latitude_deg - 41.0)
}

fn geographic(write: impl Fn(&mut Tiff, &dyn Fn(u32, u32) -> f64)) -> Vec<u8> {
    // 10⁻⁵° cells, the middle of the raster over the frame's origin, area-based.
    let west = 14.2 - 18.5e-5;
    let north = 41.0 + 14.5e-5;
    let at = |i: u32, j: u32| {
        plane(
            west + (f64::from(i) + 0.5) * 1e-5,
            north - (f64::from(j) + 0.5) * 1e-5,
        )
    };
    let mut tiff = Tiff::new(SIZE[0], SIZE[1], 64, 3);
    tiff.double(33550, &[1e-5, 1e-5, 0.0]);
    tiff.double(33922, &[0.0, 0.0, 0.0, west, north, 0.0]);
    tiff.short(34735, &keys(2, 1, 4326));
    write(&mut tiff, &at);
    tiff.bytes()
}

fn check_plane(terrain: &LocalTerrain, tolerance_m: f64) {
    let (_, enu) = frame();
    for (x, y) in [(0.0, 0.0), (10.0, -10.0), (-12.3, 8.7), (3.3, 0.1)] {
        let place = enu.geodetic_from_enu([x, y, 0.0]);
        // 60 m is the origin's height, and the Earth's curve is under 0.1 mm here.
        let expected = plane(place.longitude_deg(), place.latitude_deg()) - 60.0;
        let found = terrain.height_m(x, y).unwrap();
        assert!((found - expected).abs() < tolerance_m, "{found} {expected}");
    }
}

#[test]
fn strips_and_tiles_of_doubles_in_degrees() {
    let double = |v: f64| v.to_le_bytes().to_vec();
    let files = [
        geographic(|t, at| t.strips(SIZE, 4, |i, j| double(at(i, j)))),
        geographic(|t, at| t.tiles(SIZE, 16, |i, j| double(at(i, j)))),
    ];
    for bytes in files {
        let file = open(bytes).unwrap();
        assert_eq!(file.crs().unwrap(), Crs::Geographic);
        assert_eq!(file.size(), [37, 29]);
        let terrain = file
            .in_frame(&frame().0, [-13.0, 13.0], [-13.0, 13.0])
            .unwrap();
        check_plane(&terrain, 2e-4);
    }
}

#[test]
fn a_point_based_raster_stands_half_a_cell_elsewhere() {
    // The same numbers, their tie point said to be a centre: the ground moves by half a cell.
    let double = |v: f64| v.to_le_bytes().to_vec();
    let height = |raster: u16| {
        let mut bytes = geographic(|t, at| t.strips(SIZE, 29, |i, j| double(at(i, j))));
        let directory: Vec<u8> = keys(2, 1, 4326)
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let at = bytes
            .windows(directory.len())
            .position(|w| w == directory)
            .unwrap();
        let replaced: Vec<u8> = keys(2, raster, 4326)
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        bytes[at..at + replaced.len()].copy_from_slice(&replaced);
        let file = open(bytes).unwrap();
        let terrain = file.in_frame(&frame().0, [-5.0, 5.0], [-5.0, 5.0]).unwrap();
        terrain.height_m(0.0, 0.0).unwrap()
    };
    // Half a cell east raises by 0.02 m, half a cell south by 0.0125 m: centres stood there.
    assert!((height(1) - height(2) - (-0.02 - 0.0125)).abs() < 1e-4);
}

#[test]
fn utm_metres_whole_numbers_no_data_and_an_offset() {
    let (frame, enu) = frame();
    // The frame's origin stands at 432 718.466 E 4 539 065.233 N (PROJ 9.5).
    let mut tiff = Tiff::new(60, 60, 16, 2);
    tiff.double(
        34264,
        &[
            1.0,
            0.0,
            0.0,
            432_700.0,
            0.0,
            -1.0,
            0.0,
            4_539_090.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
        ],
    );
    tiff.short(34735, &keys(1, 1, 32633));
    tiff.text(42113, "-32768");
    tiff.strips([60, 60], 7, |i, j| {
        let hole = i == 50 && j == 50;
        let v = if hole {
            -32768
        } else {
            i16::try_from(i).unwrap()
        };
        v.to_le_bytes().to_vec()
    });
    let bytes = tiff.bytes();
    let options = TerrainOptions::default().with_offset_m(47.5);
    let file = TerrainFile::open(Cursor::new(bytes.clone()), &options).unwrap();
    assert_eq!(
        file.crs().unwrap(),
        Crs::Utm {
            zone: 33,
            south: false
        }
    );
    let terrain = file.in_frame(&frame, [-10.0, 34.0], [-28.0, 10.0]).unwrap();
    let east = |x: f64| terrain.height_m(x, 0.0).unwrap();
    assert!((east(0.0) - (432_718.466 - 432_700.5 + 47.5 - 60.0)).abs() < 1e-3);
    // A metre a column to grid east, which leans by sin φ Δλ = 0.52° from the frame's.
    let slope = (east(2.0) - east(-2.0)) / 4.0;
    let lean = (0.8_f64 * enu.origin().latitude_rad.sin())
        .to_radians()
        .cos();
    assert!((slope - 0.99966 * lean).abs() < 1e-4, "{slope}");
    // Cell (50, 50) has no data: about 32 m east and 25.7 m south.
    assert!(matches!(
        terrain.height_m(32.0, -25.5),
        Err(TerrainError::Hole { .. })
    ));

    // Far off, the message names the place.
    let file = TerrainFile::open(Cursor::new(bytes), &options).unwrap();
    let message = file
        .in_frame(&frame, [-2.0, 500.0], [0.0, 1.0])
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("x = ") && message.contains("raster of 60 × 60"),
        "{message}"
    );
}

/// Written by GDAL 3.10 (rasterio 1.4.4), with heights a function of the coordinates.
#[test]
fn files_written_by_gdal() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/");
    let read = |name: &str| {
        let file = std::fs::File::open(format!("{folder}{name}")).unwrap();
        let file = TerrainFile::open(file, &TerrainOptions::default()).unwrap();
        file.in_frame(&frame().0, [-12.0, 16.0], [-13.0, 9.0])
            .unwrap()
    };
    let utm = read("utm33-deflate-tiles.tif");
    let degrees = read("wgs84-lzw-strips.tif");
    // East and north in the frame; heights there by PROJ 9.5 and the kernel of Keys (1981).
    for ([x, y], in_utm, in_degrees) in [
        ([0.0, 0.0], -9.92719, 11.0),
        ([15.0, -12.0], -8.82498, 20.96757),
        ([-10.3, 7.7], -10.71842, 3.42311),
        ([3.3, 0.1], -9.51038, 12.80649),
    ] {
        let found = utm.height_m(x, y).unwrap();
        assert!((found - in_utm).abs() < 1e-4, "{found} {in_utm}");
        let found = degrees.height_m(x, y).unwrap();
        assert!((found - in_degrees).abs() < 1e-4, "{found} {in_degrees}");
    }
}

#[test]
fn text_grids() {
    let local = |text: &str, x: [f64; 2], y: [f64; 2]| {
        open(text.as_bytes().to_vec())
            .unwrap()
            .in_frame(&Frame::Local, x, y)
            .unwrap()
    };
    // Rows from the north; corners are edges.
    let asc = "ncols 3\nnrows 2\nxllcorner 9.5\nyllcorner -0.5\ncellsize 1\nNODATA_value -9\n\
               1 2 3\n4 5 -9\n";
    let t = local(asc, [10.0, 11.5], [0.0, 1.0]);
    assert_eq!(t.height_m(10.0, 0.0).unwrap(), 4.0);
    assert_eq!(t.height_m(10.5, 1.0).unwrap(), 1.5);
    assert!(matches!(
        t.height_m(11.5, 0.5),
        Err(TerrainError::Hole { .. })
    ));
    let centre = asc
        .replace("corner 9.5", "center 10")
        .replace("corner -0.5", "center 0");
    assert_eq!(
        local(&centre, [10.0, 11.0], [0.0, 1.0])
            .height_m(10.5, 1.0)
            .unwrap(),
        1.5
    );

    // Points in any order, a header and comments, commas.
    let xyz = "x,y,z\n# made by hand\n1,0.5,3\n0,0.5,1\n0,0,2\n1,0,4\n";
    let t = local(xyz, [0.0, 1.0], [0.0, 0.5]);
    assert_eq!(t.height_m(0.5, 0.25).unwrap(), 2.5);
    // One row and one column.
    let t = local("0 7 1\n1 7 2\n2 7 4\n", [0.0, 2.0], [7.0, 7.0]);
    // (−1 + 9·2 + 9·4 − 6)/16, 6 being where the slope from 2 to 4 leads.
    assert_eq!(t.height_m(1.5, 7.0).unwrap(), 2.9375);

    // Thirds to three decimals are a grid; coordinates in UTM size too.
    let mut text = String::new();
    for j in 0..4 {
        for i in 0..10 {
            let (x, y) = (
                432_700.0 + f64::from(i) / 3.0,
                4_539_000.0 + f64::from(j) / 3.0,
            );
            text += &format!("{x:.3} {y:.3} {i}\n");
        }
    }
    let options = TerrainOptions::default().with_crs(Crs::Local);
    let file = TerrainFile::open(Cursor::new(text), &options).unwrap();
    assert_eq!(file.size(), [10, 4]);
    let t = file
        .in_frame(
            &Frame::Local,
            [432_700.5, 432_702.5],
            [4_539_000.0, 4_539_001.0],
        )
        .unwrap();
    assert!((t.height_m(432_701.0, 4_539_000.5).unwrap() - 3.0).abs() < 2e-2);
}

#[test]
fn what_cannot_be_used_is_refused_with_its_place() {
    let message = |text: &str| open(text.as_bytes().to_vec()).unwrap_err().to_string();
    for (text, part) in [
        ("", "empty"),
        ("# nothing\n", "empty"),
        ("0 0 1\n1 0\n", "line 2: expected x, y and z"),
        ("0 0 1\n1 0 nan\n", "line 2: expected a finite number"),
        ("0 0 1\n1 0 1\n2.4 0 1\n9.3 7.1 2\n", "is on no grid"),
        (
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3 4\n",
            "line 4: expected xllcorner",
        ),
        (
            "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n",
            "expected as many",
        ),
        (
            "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3\n",
            "line 7: expected the end",
        ),
        ("ncols 2\nwidth 3\n", "line 2: expected ncols"),
        (
            "ncols 1e9\nnrows 1e9\nxllcorner 0\nyllcorner 0\ncellsize 1\n1\n",
            "more than the",
        ),
        ("II*\0", "TIFF header"),
        ("MM\0*\0\0\0\x08\0\0", "TIFF header"),
    ] {
        let found = message(text);
        assert!(found.contains(part), "{text:?}: {found}");
    }

    let double = |v: f64| v.to_le_bytes().to_vec();
    // No place at all.
    let mut plain = Tiff::new(4, 4, 64, 3);
    plain.strips([4, 4], 4, |_, _| double(1.0));
    assert!(
        open(plain.bytes())
            .unwrap_err()
            .to_string()
            .contains("ModelPixelScale")
    );
    // No such system; a unit of angles.
    for (key, part) in [
        (vec![1_u16], "EPSG:1:"),
        (vec![32633, 4099, 0, 1, 9101], "9101"),
    ] {
        let mut tiff = Tiff::new(4, 4, 64, 3);
        tiff.double(33550, &[1.0, 1.0, 0.0]);
        tiff.double(33922, &[0.0; 6]);
        let mut all = keys(1, 1, key[0]);
        all.extend(&key[1..]);
        tiff.short(34735, &all);
        tiff.strips([4, 4], 4, |_, _| double(1.0));
        let found = open(tiff.bytes()).unwrap_err().to_string();
        assert!(found.contains(part), "{found}");
    }
    // A text that claims a gigabyte.
    let mut tiff = Tiff::new(4, 4, 64, 3);
    tiff.text(42113, "-9999 and more");
    tiff.strips([4, 4], 4, |_, _| double(1.0));
    let mut bytes = tiff.bytes();
    let entry = bytes
        .windows(4)
        .position(|w| w == [0x81, 0xa4, 2, 0])
        .unwrap();
    bytes[entry + 4..entry + 8].copy_from_slice(&(1_u32 << 30).to_le_bytes());
    let found = open(bytes).unwrap_err().to_string();
    assert!(found.contains("1073741824 are more than"), "{found}");
    // Cut off half way: the header is there, the heights are not.
    let mut bytes = geographic(|t, at| t.strips(SIZE, 4, |i, j| double(at(i, j))));
    for count in bytes
        .windows(4)
        .enumerate()
        .filter_map(|(k, w)| {
            (w == 1184_u32.to_le_bytes()).then_some(k) // bytes of a whole strip
        })
        .collect::<Vec<_>>()
    {
        bytes[count..count + 4].copy_from_slice(&(1_u32 << 30).to_le_bytes());
    }
    let found = open(bytes)
        .unwrap()
        .in_frame(&frame().0, [-1.0, 1.0], [-1.0, 1.0])
        .unwrap_err()
        .to_string();
    assert!(found.contains("strip or tile"), "{found}");
    // A raster on the Earth for positions in a room.
    let bytes = geographic(|t, at| t.strips(SIZE, 4, |i, j| double(at(i, j))));
    let found = open(bytes)
        .unwrap()
        .in_frame(&Frame::Local, [0.0, 1.0], [0.0, 1.0])
        .unwrap_err()
        .to_string();
    assert!(found.contains("no known place"), "{found}");
}
