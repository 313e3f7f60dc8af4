//! Data cubes: by their structure, and as other programs read them where `ACERRA_PYTHON` names a Python
//! with `xarray`, `zarr`, `netCDF4`, `h5py` and `vtk`.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on has failed

use std::fs;
use std::io::{self, Cursor, Read, Seek, Write};
use std::path::Path;
use std::process::Command;

use acerra_cubes::{
    CubeError, Dataset, Hdf5File, Hdf5Stack, StackShape, Values, Variable, VtiGrid, VtiWriter,
    ZarrGroup, write_hdf5, write_zarr,
};
use num_complex::Complex32;

const NX: usize = 700;
const NY: usize = 530;

fn pixel(k: usize) -> Complex32 {
    Complex32::new(k as f32, -0.5 * k as f32)
}

/// An image that tells its pixels, its coordinates, a few targets, and a height.
fn dataset() -> Dataset<'static> {
    let mut data = Dataset::default();
    for (name, length) in [("y", NY), ("x", NX), ("target", 3)] {
        data.dimension(name, length);
    }
    data.attribute("title", "a test <&> größer");
    data.attribute("Conventions", "CF-1.11");
    data.attribute("INPUT_größe.mrm", "sha256");
    data.attribute("note", "");
    let axis = |name: &'static str, n: usize, from: f64| {
        let values: Vec<f64> = (0..n).map(|k| from + 0.05 * k as f64).collect();
        Variable::new(name, &[name], values.into()).with("units", "m")
    };
    data.variable(axis("x", NX, -3.0).with("long_name", "east"));
    data.variable(axis("y", NY, 2.0).with("long_name", "north"));
    data.variable(Variable::new("z", &[], vec![-1.5].into()).with("units", "m"));
    let image: Vec<Complex32> = (0..NX * NY).map(pixel).collect();
    data.variable(Variable::new("image", &["y", "x"], image.into()).with("units", "1"));
    let level: Vec<f32> = (0..NX * NY).map(|k| k as f32).collect();
    data.variable(Variable::new("level", &["y", "x"], level.into()).with("units", "dB"));
    let track = Variable::new("track", &["target"], Values::from(vec![1, 2, 3]));
    data.variable(track.with("valid_min", 1.0));
    // An image without a target.
    data.dimension("none", 0);
    data.variable(Variable::new(
        "nothing",
        &["none"],
        Values::from(Vec::<f64>::new()),
    ));
    data
}

fn unzipped(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(fs::File::open(path).unwrap())
        .read_to_end(&mut bytes)
        .unwrap();
    bytes
}

#[test]
fn a_group_tells_its_arrays_and_chunks_hold_them() {
    let folder = tempfile::tempdir().unwrap();
    write_zarr(folder.path(), &dataset()).unwrap();
    let group: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("zarr.json")).unwrap()).unwrap();
    let of = |path: &str| {
        group
            .pointer(path)
            .unwrap_or_else(|| panic!("{path}"))
            .clone()
    };
    assert_eq!(of("/zarr_format"), 3);
    assert_eq!(of("/attributes/Conventions"), "CF-1.11");
    let image = "/consolidated_metadata/metadata/image";
    assert_eq!(
        of(&format!("{image}/dimension_names")),
        serde_json::json!(["y", "x"])
    );
    assert_eq!(of(&format!("{image}/shape")), serde_json::json!([NY, NX]));
    assert_eq!(of(&format!("{image}/data_type")), "complex64");
    // An array's own document is the one in the group.
    let own = fs::read(folder.path().join("image/zarr.json")).unwrap();
    assert_eq!(
        serde_json::from_slice::<serde_json::Value>(&own).unwrap(),
        of(image)
    );
    // The last chunk begins at row 512 and column 512, and is filled up beyond the edges.
    let bytes = unzipped(&folder.path().join("image/c/1/1"));
    assert_eq!(bytes.len(), 512 * 512 * 8);
    let value = |row: usize, column: usize| {
        let at = 8 * (row * 512 + column);
        let half = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        Complex32::new(half(at), half(at + 4))
    };
    assert_eq!(value(17, 187), pixel(529 * NX + 699));
    assert_eq!(value(0, 0), pixel(512 * NX + 512));
    assert!(value(17, 188).re.is_nan() && value(18, 0).re.is_nan());
    let z = unzipped(&folder.path().join("z/c"));
    assert_eq!(z, (-1.5_f64).to_le_bytes());
}

#[test]
fn stacks_are_written_slice_by_slice() {
    let folder = tempfile::tempdir().unwrap();
    let shape = StackShape {
        images: 3,
        rows: 2,
        columns: 4,
    };
    let volume = Variable::new(
        "volume",
        &["z", "y", "x"],
        Values::from(Vec::<Complex32>::new()),
    );
    let mut group = ZarrGroup::create(folder.path()).unwrap();
    let mut stack = group.stack(&volume, shape).unwrap();
    for k in 0..3 {
        let slice: Vec<Complex32> = (0..8).map(|n| pixel(8 * k + n)).collect();
        stack.slice(&slice).unwrap();
    }
    let error = stack.slice(&[Complex32::ONE; 8]).unwrap_err();
    assert!(
        matches!(error, CubeError::Slices { found: 4, .. }),
        "{error}"
    );
    stack.finish().unwrap();
    group.finish(&[]).unwrap();
    let bytes = unzipped(&folder.path().join("volume/c/2/0/0"));
    assert_eq!(bytes.len(), 64);
    assert_eq!(bytes[..4], pixel(16).re.to_le_bytes());
    let mut group = ZarrGroup::create(folder.path()).unwrap();
    let mut short = group.stack(&volume, shape).unwrap();
    assert!(matches!(short.slice(&[]), Err(CubeError::Length { .. })));
    assert!(matches!(
        short.finish(),
        Err(CubeError::Slices { found: 0, .. })
    ));
}

/// A volume of 4 × 3 × 2 points whose values tell their place.
fn volume() -> Vec<u8> {
    let grid = VtiGrid {
        origin_m: [-3.0, 2.0, -1.0],
        spacing_m: [0.5, 0.5, 0.25],
        points: [4, 3, 2],
        has_heights: false,
    };
    let mut file = Cursor::new(Vec::new());
    let items = [("NOTE \"1\"".to_owned(), "größer <&>".to_owned())];
    let mut vti = VtiWriter::new(&mut file, grid, &items).unwrap();
    for k in 0..2 {
        let slice: Vec<Complex32> = (0..12).map(|n| pixel(12 * k + n)).collect();
        vti.slice(&slice).unwrap();
    }
    vti.finish().unwrap();
    file.into_inner()
}

#[test]
fn image_data_hold_each_array_in_one_piece() {
    let bytes = volume();
    let at = bytes.windows(2).position(|w| w == b"\n_").unwrap() + 2;
    for array in 0..3 {
        let start = at + array * (8 + 4 * 24);
        assert_eq!(bytes[start..start + 8], 96_u64.to_le_bytes());
        let last: f32 = f32::from_le_bytes(bytes[start + 100..start + 104].try_into().unwrap());
        let z = pixel(23);
        let expected = [z.re, z.im, 10.0 * z.norm_sqr().log10()][array];
        assert_eq!(last, expected);
    }
    assert!(bytes.ends_with(b"</VTKFile>\n"));
    let text = String::from_utf8_lossy(&bytes);
    assert!(
        text.contains("WholeExtent=\"0 3 0 2 0 1\" Origin=\"-3 2 -1\""),
        "{text}"
    );
}

#[test]
fn hdf5_files_hold_the_variables() {
    let mut bytes = Cursor::new(Vec::new());
    write_hdf5(&mut bytes, &dataset()).unwrap();
    let bytes = bytes.into_inner();
    let file = hdf5_pure::File::from_bytes(bytes).unwrap();
    let imag = file.dataset("image_imag").unwrap();
    assert_eq!(imag.shape().unwrap(), [NY as u64, NX as u64]);
    let values = imag.read_f32().unwrap();
    assert_eq!(values[7 * NX + 3], pixel(7 * NX + 3).im);
    assert_eq!(
        file.dataset("x").unwrap().read_f64().unwrap()[2],
        -3.0 + 0.05 * 2.0
    );
}

/// Values of an array of more chunks than a node of the file's index holds.
const LONG: i32 = 70 << 16;

fn long() -> Dataset<'static> {
    let mut data = Dataset::default();
    data.dimension("k", LONG as usize);
    let values: Vec<i32> = (0..LONG).collect();
    data.variable(Variable::new("long", &["k"], values.into()));
    data
}

#[test]
fn hdf5_files_hold_arrays_of_many_chunks() {
    let mut bytes = Cursor::new(Vec::new());
    write_hdf5(&mut bytes, &long()).unwrap();
    let bytes = bytes.into_inner();
    assert!(bytes.len() < 4 * LONG as usize / 4, "{}", bytes.len());
    let file = hdf5_pure::File::from_bytes(bytes).unwrap();
    let values = file.dataset("long").unwrap().read_i32().unwrap();
    assert!(values.iter().copied().eq(0..LONG));
}

#[test]
fn hdf5_stacks_are_written_image_by_image() {
    let shape = StackShape {
        images: 3,
        rows: 520,
        columns: 5,
    };
    let image = |k: usize| -> Vec<Complex32> { (0..2600).map(|i| pixel(i + 7000 * k)).collect() };
    let variable = Variable::new(
        "volume",
        &["z", "y", "x"],
        Values::from(Vec::<Complex32>::new()),
    );
    let mut bytes = Cursor::new(Vec::new());
    let mut file = Hdf5File::create(&mut bytes).unwrap();
    let mut stack = Hdf5Stack::begin(&mut file, &variable, shape).unwrap();
    assert!(matches!(
        stack.slice(&image(0)[1..]),
        Err(CubeError::Length { .. })
    ));
    (0..3).for_each(|k| stack.slice(&image(k)).unwrap());
    assert!(matches!(
        stack.slice(&image(3)),
        Err(CubeError::Slices { found: 4, .. })
    ));
    stack.finish().unwrap();
    file.finish(&[]).unwrap();
    let file = hdf5_pure::File::from_bytes(bytes.into_inner()).unwrap();
    let imag = file.dataset("volume_imag").unwrap();
    assert_eq!(imag.shape().unwrap(), [3, 520, 5]);
    let values = imag.read_f32().unwrap();
    let expected = (0..3).flat_map(image).map(|z| z.im);
    assert!(values.into_iter().eq(expected));
}

#[test]
fn attributes_that_no_header_holds_are_refused() {
    let mut data = dataset();
    let many = acerra_cubes::Attribute::Numbers(vec![0.5; 8000]);
    data.attribute("many", many);
    let written = write_hdf5(Cursor::new(Vec::new()), &data);
    assert!(matches!(
        written,
        Err(CubeError::Attribute { found: 64_004, .. })
    ));
}

#[test]
fn a_file_cut_off_is_no_hdf5_file() {
    /// Takes so many bytes.
    struct Full(Cursor<Vec<u8>>, usize);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0.get_ref().len() + bytes.len() > self.1 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.0.write(bytes)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Seek for Full {
        fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }
    let mut disk = Full(Cursor::new(Vec::new()), 100_000);
    assert!(matches!(
        write_hdf5(&mut disk, &dataset()),
        Err(CubeError::Io(_))
    ));
    assert!(hdf5_pure::File::from_bytes(disk.0.into_inner()).is_err());
}

const ASK: &str = r#"
import sys, json, warnings, numpy as np
warnings.simplefilter("ignore")
import xarray as xr, zarr, h5py, h5netcdf, netCDF4, vtk
from vtk.util.numpy_support import vtk_to_numpy
zarr_path, hdf5_path, vti_path, long_path = sys.argv[1:5]
told = {}
def look(name, d, image):
    told[name] = {
        "dims": list(image.dims), "at": [float(d.x[2]), float(d.y[-1]), float(d.z)],
        "value": [float(image.sel(x=-3 + 0.05 * 5, y=2 + 0.05 * 3, method="nearest").real),
                  float(image[-1, -1].imag)],
        "units": [d.x.attrs["units"], d.level.attrs["units"]], "title": d.attrs["title"],
        "track": d.track.values.tolist(), "level": float(d.level[3, 5]),
        "coords": sorted(d.coords),
    }
d = xr.open_zarr(zarr_path, consolidated=True)
look("zarr", d, d.image)
told["zarr"]["dtype"] = str(d.image.dtype)
told["zarr"]["sum"] = float(d.image.real.astype("f8").sum())
for engine in ["netcdf4", "h5netcdf"]:
    with xr.open_dataset(hdf5_path, engine=engine) as d:
        look(engine, d, d.image_real + 1j * d.image_imag)
with netCDF4.Dataset(hdf5_path) as f:
    told["netcdf"] = [
        [[name, d.size] for name, d in f.dimensions.items()], list(f.variables), f["x"].units,
    ]
with h5py.File(hdf5_path) as f:
    told["h5py"] = [list(f["image_real"].shape), float(f["level"][3, 5]), f["x"].attrs["units"]]
    scales = [[d.label, d[0].name] for d in f["level"].dims]
    told["scales"] = [scales, f["x"].is_scale, len(f["y"].attrs["REFERENCE_LIST"])]
    told["sum"] = float(f["level"][...].astype("f8").sum())
    told["text"] = [f.attrs["title"], f["level"].attrs["units"]]
with h5py.File(hdf5_path) as f:
    told["odd"] = [f.attrs["INPUT_größe.mrm"], f.attrs["note"], list(f["nothing"].shape)]
with xr.open_dataset(hdf5_path, engine="netcdf4") as d:
    told["odd"] += [d.attrs["INPUT_größe.mrm"], d.sizes["none"]]
with h5py.File(long_path) as f:
    told["long"] = [int(f["long"][...].astype("i8").sum()), int(f["long"][-1]), f["long"].chunks[0]]
reader = vtk.vtkXMLImageDataReader()
reader.SetFileName(vti_path)
reader.Update()
image = reader.GetOutput()
points = image.GetPointData()
told["vtk"] = {
    "dimensions": image.GetDimensions(), "origin": image.GetOrigin(), "spacing": image.GetSpacing(),
    "arrays": [points.GetArrayName(k) for k in range(points.GetNumberOfArrays())],
    "value": float(vtk_to_numpy(points.GetArray("imag"))[image.ComputePointId([3, 2, 1])]),
    "note": image.GetFieldData().GetAbstractArray('NOTE "1"').GetValue(0),
}
print(json.dumps(told, ensure_ascii=False))
"#;

#[test]
fn other_programs_read_them() {
    let Some(python) = std::env::var_os("ACERRA_PYTHON") else {
        eprintln!(
            "skipped: ACERRA_PYTHON names no Python with xarray, zarr, netCDF4, h5netcdf, h5py and vtk"
        );
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_zarr(&at("data.zarr"), &dataset()).unwrap();
    write_hdf5(fs::File::create(at("data.h5")).unwrap(), &dataset()).unwrap();
    fs::write(at("volume.vti"), volume()).unwrap();
    write_hdf5(fs::File::create(at("long.h5")).unwrap(), &long()).unwrap();
    let answer = Command::new(python)
        .args(["-c", ASK])
        .args(["data.zarr", "data.h5", "volume.vti", "long.h5"].map(at))
        .env("PYTHONIOENCODING", "utf-8")
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(answer.status.success(), "{errors}");
    let told: serde_json::Value = serde_json::from_slice(&answer.stdout).unwrap();
    let seen = &told["zarr"];
    assert_eq!(seen["dims"], serde_json::json!(["y", "x"]), "{told}");
    assert_eq!(seen["coords"], serde_json::json!(["x", "y"]), "{told}");
    assert_eq!(seen["units"], serde_json::json!(["m", "dB"]));
    assert_eq!(seen["title"], "a test <&> größer");
    assert_eq!(seen["track"], serde_json::json!([1, 2, 3]));
    assert_eq!(seen["level"], (3 * NX + 5) as f64);
    let value = [pixel(3 * NX + 5).re, pixel(NX * NY - 1).im];
    assert_eq!(seen["value"], serde_json::json!(value), "{told}");
    for (k, expected) in [-2.9, 2.0 + 0.05 * 529.0, -1.5].into_iter().enumerate() {
        assert!(
            (seen["at"][k].as_f64().unwrap() - expected).abs() < 1e-12,
            "{told}"
        );
    }
    let all = (NX * NY) as f64;
    assert_eq!(told["zarr"]["dtype"], "complex64");
    assert_eq!(told["zarr"]["sum"], 0.5 * all * (all - 1.0));
    assert_eq!(
        told["h5py"],
        serde_json::json!([[NY, NX], (3 * NX + 5) as f64, "m"])
    );
    for engine in ["netcdf4", "h5netcdf"] {
        let seen = &told[engine];
        assert_eq!(seen["dims"], serde_json::json!(["y", "x"]), "{told}");
        assert_eq!(seen["coords"], serde_json::json!(["x", "y"]), "{told}");
        assert_eq!(seen["units"], serde_json::json!(["m", "dB"]));
        assert_eq!(seen["title"], "a test <&> größer");
        assert_eq!(seen["value"], serde_json::json!(value), "{told}");
        assert_eq!(seen["track"], serde_json::json!([1, 2, 3]));
    }
    let netcdf = &told["netcdf"];
    assert_eq!(
        netcdf[0],
        serde_json::json!([["y", NY], ["x", NX], ["target", 3], ["none", 0]])
    );
    // A dimension without coordinates is no variable.
    assert_eq!(
        netcdf[1],
        serde_json::json!([
            "x",
            "y",
            "z",
            "image_real",
            "image_imag",
            "level",
            "track",
            "nothing"
        ])
    );
    assert_eq!(
        told["odd"],
        serde_json::json!(["sha256", "", [0], "sha256", 0])
    );
    assert_eq!(
        told["scales"],
        serde_json::json!([[["", "/y"], ["", "/x"]], true, 3])
    );
    assert_eq!(told["sum"], 0.5 * all * (all - 1.0));
    let many = LONG as i64;
    assert_eq!(
        told["long"],
        serde_json::json!([many * (many - 1) / 2, many - 1, 1 << 16])
    );
    let vtk = &told["vtk"];
    assert_eq!(vtk["dimensions"], serde_json::json!([4, 3, 2]));
    assert_eq!(vtk["spacing"], serde_json::json!([0.5, 0.5, 0.25]));
    assert_eq!(
        vtk["arrays"],
        serde_json::json!(["real", "imag", "level_dB"])
    );
    assert_eq!(vtk["value"], f64::from(pixel(23).im));
    assert_eq!(vtk["note"], "größer <&>");
}
