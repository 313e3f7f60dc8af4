"""Every array of the package is saved and read again by every engine of xarray."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import acerra

ENGINES = ["scipy", "netcdf4", "h5netcdf"]


def arrays() -> dict[str, xr.DataArray | xr.Dataset]:
    """Arrays of a scene of one point, without a geodetic origin."""
    track = np.column_stack([np.linspace(-1, 1, 41), np.zeros(41), np.full(41, 2.0)])
    frequency = np.linspace(3.1e9, 4.8e9, 32)
    distance = np.linalg.norm(track - [0.1, 0.4, 0.0], axis=1)
    echoes = np.exp(-4j * np.pi * np.outer(distance, frequency) / acerra.SPEED_OF_LIGHT_M_S)
    image = acerra.adjoint(
        track, frequency, echoes, acerra.Plane([-0.5, 0.5], [0, 0.8], pixel_m=0.05)
    )
    return {
        "image": image,
        "level": abs(image).assign_attrs(image.attrs),
        "radargram": acerra.radargram(
            np.ones((3, 5), np.float32), time_s=[0, 1, 2], fast_time_start_s=0, fast_time_step_s=1e-9
        ),
        "trajectory": acerra.trajectory(
            [[0, 0, 5], [1, 0, 5]],
            time_s=[0, 0.5],
            sigma_m=[[0.01, 0.01, 0.02]] * 2,
            status=["fix", "float"],
            gps_start=(2075, 207000.5),
        ),
    }


# netCDF4 warns of its own build when imported, h5netcdf of complex numbers beyond the standard.
@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::UserWarning")
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", ["image", "level", "radargram", "trajectory"])
def test_arrays_are_saved_and_read_again(tmp_path: Path, name: str, engine: str) -> None:
    if engine != "scipy":
        pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    labelled: Any = arrays()[name]
    if engine == "scipy" and name == "image":
        pytest.skip("NetCDF-3 holds no complex numbers")
    options: dict[str, Any] = {}
    if name == "image":
        options = {"netcdf4": {"auto_complex": True}, "h5netcdf": {"invalid_netcdf": True}}[engine]
    file = tmp_path / f"{name}.nc"
    labelled.to_netcdf(file, engine=engine, **options)
    if isinstance(labelled, xr.DataArray):
        opening = {"auto_complex": True} if options.get("auto_complex") else {}
        read: Any = xr.load_dataarray(file, engine=engine, **opening)
    else:
        read = xr.load_dataset(file, engine=engine)
    xr.testing.assert_equal(read, labelled)
    assert set(labelled.attrs) <= set(read.attrs)


def test_gps_time_is_the_calendar_s() -> None:
    read = arrays()["trajectory"]
    # Week 2075, second 207000.5: Tuesday 15 October 2019, 09:30:00.5 GPS time.
    assert read["gps_time"].values[1] == np.datetime64("2019-10-15T09:30:01")
