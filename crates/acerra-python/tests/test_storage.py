"""Every array of the package is saved and read again by every engine of xarray; runs are pickled."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import acerra
from acerra._storage import grid_mapping

ENGINES = {"scipy": "scipy", "netcdf4": "netCDF4", "h5netcdf": "h5netcdf"}
IMAGE = {"x_m": [3, 5], "y_m": [-1, 1], "pixel_m": 0.1}
ORIGIN_DEG_M = (40.9, 14.4, 1200.0)


def campaign(demo: Path, **image: Any) -> acerra.Campaign:
    """The demo's campaign with few pixels."""
    tables = acerra.Campaign.read(demo / "campaign.toml").tables
    tables["image"] = {**tables["image"], **IMAGE, **image}
    return acerra.Campaign.of(tables, folder=demo)


@pytest.fixture(scope="session")
def run(demo: Path) -> acerra.Run:
    return campaign(demo).run()


@pytest.fixture(scope="session")
def arrays(
    demo: Path, run: acerra.Run, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """An array of each kind that the package gives, by the call."""
    track = np.column_stack([np.linspace(-1, 1, 41), np.zeros(41), np.full(41, 2.0)])
    frequency = np.linspace(3.1e9, 4.8e9, 32)
    echoes = np.ones((41, 32), complex)
    x, y = [-0.5, 0.5], [0, 0.8]
    grids: dict[str, Any] = {
        "Plane": acerra.Plane(x, y, pixel_m=0.05),
        "Tilted": acerra.Tilted([0, 1, 0], [0.1, 0, 0], [0, 0.1, 0.05], shape=(6, 5)),
        "Surface": acerra.Surface(x, y, np.full((17, 21), 0.1), pixel_m=0.05),
        "Volume": acerra.Volume(x, y, [0, 0.2], pixel_m=0.1),
    }
    file = tmp_path_factory.mktemp("arrays") / "spectra.npz"
    np.savez(
        file, spectrum=echoes, frequency_hz=frequency, time_s=np.arange(41.0), position_m=track
    )
    gnss = acerra.Campaign.read(demo / "campaign.toml").tables["gnss"]
    volume = campaign(demo, z_m=[-0.1, 0.1]).run()
    return {
        "run.image": run.image,
        "abs(run.image)": abs(run.image),
        "run.volume": volume.volume,
        "volume run.image": volume.image,
        "prepared.image": run.prepared.image(),
        "prepared.spectrum": run.prepared.spectrum,
        "prepared.radargram": run.prepared.radargram("clean"),
        "read of traces": acerra.read(demo / "radar.mrm"),
        "read of spectra": acerra.read(file),
        "ppk": acerra.ppk(demo / "rover.ubx", demo / "base.ubx", base_ecef_m=gnss["base_ecef_m"]),
        "trajectory": acerra.trajectory(
            track,
            time_s=0.1 * np.arange(41),
            sigma_m=np.full((41, 3), 0.01),
            status=["fix", "float"] * 20 + ["single"],
            origin_deg_m=ORIGIN_DEG_M,
            gps_start=(2075, 207000.123456789),
        ),
        "trajectory of places": acerra.trajectory(track),
        "point spread": acerra.PointSpread(track, frequency).image([[0, 0.4, 0]], grids["Plane"]),
        **{
            f"adjoint on {kind}": acerra.adjoint(track, frequency, echoes, grid)
            for kind, grid in grids.items()
        },
    }


KINDS = (
    "run.image|abs(run.image)|run.volume|volume run.image|prepared.image|prepared.spectrum|"
    "prepared.radargram|read of traces|read of spectra|ppk|trajectory|trajectory of places|point spread|"
    "adjoint on Plane|adjoint on Tilted|adjoint on Surface|adjoint on Volume"
).split("|")


def test_every_kind_is_named(arrays: dict[str, Any]) -> None:
    assert list(arrays) == KINDS


# netCDF4 warns of its own build when imported.
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", KINDS)
def test_an_array_is_saved_and_read_again(
    tmp_path: Path, arrays: dict[str, Any], kind: str, engine: Any
) -> None:
    pytest.importorskip(ENGINES[engine])
    labelled = arrays[kind]
    file = tmp_path / "array.nc"
    whole = labelled.to_dataset() if isinstance(labelled, xr.DataArray) else labelled
    is_complex = any(variable.dtype.kind == "c" for variable in whole.data_vars.values())
    if is_complex:
        acerra.split_complex(labelled).to_netcdf(file, engine=engine)
        read: Any = acerra.join_complex(xr.load_dataset(file, engine=engine))
    else:
        labelled.to_netcdf(file, engine=engine)
        read = xr.load_dataset(file, engine=engine)
    xr.testing.assert_equal(read, whole)
    for name, variable in whole.variables.items():
        assert set(variable.attrs) <= set(read[name].attrs), name
    assert set(whole.attrs) <= set(read.attrs)
    if isinstance(labelled, xr.DataArray) and not is_complex:
        # Without any option, as a first user reads it.
        xr.testing.assert_equal(xr.load_dataarray(file, engine=engine), labelled)


def test_zarr_holds_complex_numbers(tmp_path: Path, arrays: dict[str, Any]) -> None:
    pytest.importorskip("zarr")
    for kind in ("run.image", "ppk"):
        labelled = arrays[kind]
        whole = labelled.to_dataset() if isinstance(labelled, xr.DataArray) else labelled
        whole.to_zarr(tmp_path / kind, consolidated=False, zarr_format=2)
        read = xr.load_dataset(tmp_path / kind, engine="zarr", consolidated=False)
        xr.testing.assert_equal(read, whole)


def test_gps_time_is_the_calendar_s(arrays: dict[str, Any]) -> None:
    read = arrays["trajectory"]
    # Week 2075, second 207000: Tuesday 15 October 2019, 09:30:00 GPS time.
    start = np.datetime64("2019-10-15T09:30:00.123456789")
    assert read["gps_time"].values[0] == start
    assert read["gps_time"].values[10] == start + np.timedelta64(1, "s")


def test_a_trajectory_is_a_table_of_one_row_for_each_epoch(arrays: dict[str, Any]) -> None:
    table = arrays["ppk"].to_dataframe()
    assert len(table) == arrays["ppk"].sizes["epoch"]
    assert set(table) == {
        *"xyz",
        "sigma_x",
        "sigma_y",
        "sigma_z",
        "status",
        "time",
        "gps_time",
    }
    assert table["gps_time"].dtype.kind == "M"


@pytest.mark.filterwarnings("ignore")
def test_georeferenced_arrays_name_their_projection(arrays: dict[str, Any]) -> None:
    pyproj: Any = pytest.importorskip("pyproj")
    for kind in ("run.image", "abs(run.image)", "run.volume", "prepared.image"):
        crs = arrays[kind]["spatial_ref"].attrs
        assert pyproj.CRS.from_cf(dict(crs)).is_projected, kind
    assert arrays["run.image"].attrs["grid_mapping"] == "spatial_ref"
    for kind in ("ppk", "trajectory", "prepared.spectrum"):
        assert pyproj.CRS(arrays[kind].attrs["crs_wkt"]).is_projected, kind
    # The tangential plane itself, about an origin at 1200 m.
    latitude, longitude, height = ORIGIN_DEG_M
    enu = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +inv +proj=topocentric +ellps=WGS84 "
        f"+lat_0={latitude} +lon_0={longitude} +h_0={height} +step +inv +proj=cart +ellps=WGS84"
    )
    attrs = grid_mapping(ORIGIN_DEG_M)
    assert attrs["crs_wkt"] == arrays["trajectory"].attrs["crs_wkt"]
    by_name = {k: v for k, v in attrs.items() if k != "crs_wkt"}
    for crs in (pyproj.CRS.from_wkt(attrs["crs_wkt"]), pyproj.CRS.from_cf(by_name)):
        to_plane = pyproj.Transformer.from_crs(crs.geodetic_crs, crs, always_xy=True)
        for x, y in ((300.0, -200.0), (-700.0, 700.0)):
            place = enu.transform(x, y, 0.0)
            found = to_plane.transform(*place[:2])
            assert np.hypot(found[0] - x, found[1] - y) < 2e-3


@pytest.mark.filterwarnings("ignore")
def test_rioxarray_places_an_image(tmp_path: Path, arrays: dict[str, Any]) -> None:
    rioxarray: Any = pytest.importorskip("rioxarray")
    pytest.importorskip("netCDF4")
    assert rioxarray.__version__
    abs(arrays["run.image"]).to_netcdf(tmp_path / "level.nc", engine="netcdf4")
    read: Any = xr.load_dataarray(tmp_path / "level.nc", engine="netcdf4")
    assert read.rio.crs.is_projected
    west, south, east, north = read.rio.transform_bounds("EPSG:4326")
    latitude, longitude, _ = arrays["run.image"].attrs["origin_deg_m"]
    assert 0 < west - longitude < east - longitude < 1e-4
    assert south < latitude < north


def assert_same(found: acerra.Run, run: acerra.Run) -> None:
    xr.testing.assert_identical(found.image, run.image)
    assert found.targets.equals(run.targets)
    assert found.record == run.record
    assert list(found.evidence) == list(run.evidence)
    assert found.noticed == run.noticed
    assert found.grid == run.grid
    assert found._repr_html_() == run._repr_html_()
    assert repr(found) == repr(run)


def test_a_run_is_pickled(run: acerra.Run) -> None:
    found = pickle.loads(pickle.dumps(run))
    assert_same(found, run)
    assert_same(pickle.loads(pickle.dumps(found)), run)
    with pytest.raises(acerra.AcerraError, match="pickle run.prepared.spectrum"):
        _ = found.prepared
    with pytest.raises(TypeError, match="pickle the Campaign"):
        pickle.dumps(run.prepared)


def test_a_campaign_is_pickled(demo: Path, run: acerra.Run) -> None:
    again: acerra.Campaign = pickle.loads(pickle.dumps(campaign(demo)))
    assert again.tables == campaign(demo).tables
    xr.testing.assert_identical(again.run().image, run.image)


@pytest.mark.filterwarnings("ignore")
def test_runs_come_from_other_processes(demo: Path, run: acerra.Run) -> None:
    joblib: Any = pytest.importorskip("joblib")
    dask: Any = pytest.importorskip("dask")
    chosen = campaign(demo)
    (by_joblib,) = joblib.Parallel(n_jobs=2)([joblib.delayed(chosen.run)()])
    (by_dask,) = dask.compute(dask.delayed(chosen.run)(), scheduler="processes", num_workers=1)
    for found in (by_joblib, by_dask):
        xr.testing.assert_identical(found.image, run.image)
        assert [f.value for f in found.evidence] == [f.value for f in run.evidence]
