"""Arrays with named coordinates and units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ._checks import Grid, increasing, places, real_vector
from ._native import Surface, Tilted, Volume
from ._storage import on_earth, storable

GPS_EPOCH = np.datetime64("1980-01-06T00:00:00", "ns")
"""Start of GPS week 0, GPS time."""


def _metres(name: str) -> dict[str, str]:
    return {"units": "m", "long_name": name}


def image_of(
    values: npt.NDArray[np.complex64],
    grid: Grid,
    attrs: dict[str, Any],
    origin_deg_m: Sequence[float] | None = None,
) -> xr.DataArray:
    """An image with the coordinates of its grid, and its place on the Earth where its origin is known."""
    dims, coords = _axes(grid)
    attrs = storable({"long_name": "reflectivity", **attrs})
    return on_earth(xr.DataArray(values, coords, dims, "image", attrs), origin_deg_m)


def _axes(grid: Grid) -> tuple[tuple[str, ...], dict[str, Any]]:
    """Dimensions and coordinates of a grid."""
    if isinstance(grid, Tilted):
        rows, columns = np.indices(grid.shape)
        steps = [
            o + columns * u + rows * v
            for o, u, v in zip(grid.origin_m, grid.u_m, grid.v_m, strict=True)
        ]
        dims = ("row", "column")
        return dims, {
            axis: (dims, step, _metres(axis)) for axis, step in zip("xyz", steps, strict=True)
        }
    coords: dict[str, Any] = {
        "x": ("x", grid.x_m, _metres("east")),
        "y": ("y", grid.y_m, _metres("north")),
    }
    if isinstance(grid, Volume):
        return ("z", "y", "x"), {**coords, "z": ("z", grid.z_m, _metres("up"))}
    z_dims = ("y", "x") if isinstance(grid, Surface) else ()
    return ("y", "x"), {**coords, "z": (z_dims, grid.z_m, _metres("up"))}


def radargram(
    samples: npt.ArrayLike,
    *,
    time_s: npt.ArrayLike,
    fast_time_start_s: float,
    fast_time_step_s: float,
    unit: str = "amplitude",
) -> xr.DataArray:
    """A radargram with its coordinates.

    Parameters
    ----------
    samples : array_like, shape (traces, samples)
        Real or complex samples.
    time_s : array_like, shape (traces,)
        Slow time of each trace, s, increasing.
    fast_time_start_s, fast_time_step_s : float
        Fast time of the first sample and from one sample to the next, s.
    unit : str
        Unit of the samples.

    Returns
    -------
    xarray.DataArray
        Dimensions ``trace`` and ``fast_time``; coordinates ``time`` and ``fast_time`` in s.

    Examples
    --------
    >>> import acerra
    >>> acerra.radargram(
    ...     [[0.0, 1.0], [0.5, 2.0]], time_s=[0, 0.1], fast_time_start_s=0, fast_time_step_s=61e-12
    ... ).sizes
    Frozen({'trace': 2, 'fast_time': 2})
    """
    array = np.asarray(samples)
    if array.ndim != 2:
        raise ValueError(f"samples: expected shape (traces, samples), found {array.shape}")
    if array.dtype.kind not in "cfiu":
        raise TypeError(f"samples: expected numbers, found dtype {array.dtype}")
    times = increasing("time_s", real_vector("time_s", time_s, "s"))
    if times.shape != array.shape[:1]:
        raise ValueError(
            f"time_s: expected shape ({array.shape[0]},), one for each trace, found {times.shape}"
        )
    fast_time = fast_time_start_s + fast_time_step_s * np.arange(array.shape[1])
    return xr.DataArray(
        array,
        {
            "time": ("trace", times, {"units": "s", "long_name": "slow time"}),
            "fast_time": ("fast_time", fast_time, {"units": "s", "long_name": "fast time"}),
        },
        ("trace", "fast_time"),
        "radargram",
        {
            "units": unit,
            "fast_time_start_s": fast_time_start_s,
            "fast_time_step_s": fast_time_step_s,
        },
    )


def radargram_arrays(labelled: xr.DataArray) -> dict[str, Any]:
    """A radargram as the native module takes it."""
    if not isinstance(labelled, xr.DataArray) or set(labelled.dims) != {"trace", "fast_time"}:
        raise TypeError(
            "radargram: expected a DataArray of trace and fast_time, as acerra.radargram and "
            "acerra.read_radar make it"
        )
    labelled = labelled.transpose("trace", "fast_time")
    wanted = np.complex64 if labelled.dtype.kind == "c" else np.float32
    with np.errstate(over="ignore"):
        samples = np.ascontiguousarray(labelled.values, dtype=wanted)
    start_s, step_s = _even(labelled)
    return {
        "samples": samples,
        "time_s": increasing("time", real_vector("time", labelled["time"], "s")),
        "fast_time_start_s": start_s,
        "fast_time_step_s": step_s,
    }


def _even(labelled: xr.DataArray) -> tuple[float, float]:
    """Start and step of fast time, which must be even."""
    fast_time = real_vector("fast_time", labelled["fast_time"], "s")
    if fast_time.size < 2:
        raise ValueError(f"fast_time: expected two samples or more, found {fast_time.size}")
    start_s = float(fast_time[0])
    step_s = float(fast_time[-1] - fast_time[0]) / (fast_time.size - 1)
    uneven = np.abs(fast_time - start_s - step_s * np.arange(fast_time.size)).max()
    if not uneven <= 1e-6 * abs(step_s):
        raise ValueError(f"fast_time: expected even steps, found {uneven:.3g} s off an even axis")
    # The attributes hold what the coordinates were computed from, unless samples were cut off.
    stated = labelled.attrs.get("fast_time_start_s"), labelled.attrs.get("fast_time_step_s")
    if stated[0] == start_s and stated[1] is not None and abs(stated[1] - step_s) <= 1e-9 * step_s:
        return start_s, float(stated[1])
    return start_s, step_s


def trajectory(
    position_m: npt.ArrayLike,
    *,
    time_s: npt.ArrayLike | None = None,
    sigma_m: npt.ArrayLike | None = None,
    status: list[str] | None = None,
    origin_deg_m: tuple[float, float, float] | None = None,
    gps_start: tuple[int, float] | None = None,
) -> xr.Dataset:
    """Positions with their coordinates.

    Parameters
    ----------
    position_m : array_like, shape (n, 3)
        East, north, up (or local x, y and z up) in metres.
    time_s : array_like, shape (n,), optional
        Times of the positions, s, increasing; without them the positions are those of the traces.
    sigma_m : array_like, shape (n, 3), optional
        Standard deviations, m.
    status : list of str, optional
        Solution status of each position: ``"fix"``, ``"float"``, ….
    origin_deg_m : tuple of float, optional
        Latitude, longitude (degrees) and ellipsoidal height (m) of the origin.
    gps_start : tuple of int and float, optional
        GPS week and second of week at which `time_s` is zero.

    Returns
    -------
    xarray.Dataset
        One column for each quantity, over the dimension ``epoch``: ``x``, ``y``, ``z`` and, where given,
        ``sigma_x``, ``sigma_y``, ``sigma_z`` in m and ``status``; the coordinate ``time`` in s and, with
        `gps_start`, ``gps_time``, GPS time as ``datetime64``. ``to_dataframe()`` is a table of one row
        for each epoch.

    Examples
    --------
    >>> import acerra
    >>> acerra.trajectory([[0, 0, 5], [1, 0, 5]], time_s=[0, 0.5]).to_dataframe()
             x    y    z  time
    epoch
    0      0.0  0.0  5.0   0.0
    1      1.0  0.0  5.0   0.5
    """
    position = places("position_m", position_m)
    data = _columns("", position, ("east", "north", "up"))
    coords: dict[str, Any] = {}
    if time_s is not None:
        times = increasing("time_s", real_vector("time_s", time_s, "s"))
        if times.shape != position.shape[:1]:
            raise ValueError(
                f"time_s: expected shape ({position.shape[0]},), one for each position, "
                f"found {times.shape}"
            )
        coords["time"] = ("epoch", times, {"units": "s"})
        if gps_start is not None:
            week, second = gps_start
            after_epoch = np.round(1e9 * times).astype("timedelta64[ns]")
            start = np.timedelta64(604_800 * int(week), "s") + np.timedelta64(
                round(1e9 * float(second)), "ns"
            )
            gps_time = GPS_EPOCH + start + after_epoch
            coords["gps_time"] = ("epoch", gps_time, {"long_name": "GPS time"}, _exactly(gps_time[0]))
    if sigma_m is not None:
        sigma = places("sigma_m", sigma_m)
        if sigma.shape != position.shape or not (sigma >= 0).all():
            raise ValueError(
                f"sigma_m: expected {position.shape} values of 0 m or more, found {sigma.shape}"
            )
        data |= _columns("sigma_", sigma, ("standard deviation",) * 3)
    if status is not None:
        data["status"] = ("epoch", list(status))
    attrs: dict[str, Any] = {}
    if gps_start is not None:
        attrs["gps_start"] = (int(gps_start[0]), float(gps_start[1]))
    return on_earth(xr.Dataset(data, coords, attrs), origin_deg_m)


def _columns(
    prefix: str, values: npt.NDArray[np.float64], names: tuple[str, str, str]
) -> dict[str, Any]:
    """Places or deviations, ``[n, 3]``, as a variable for each axis."""
    return {
        f"{prefix}{axis}": ("epoch", values[:, k].copy(), _metres(names[k]))
        for k, axis in enumerate("xyz")
    }


def _exactly(start: np.datetime64) -> dict[str, Any]:
    """How a file holds times to the nanosecond, also one without integers of 64 bits."""
    return {"units": f"nanoseconds since {start.astype('datetime64[s]')}", "dtype": "float64"}


def trajectory_of(arrays: dict[str, Any]) -> xr.Dataset:
    """A trajectory that the native module gives."""
    known = ("time_s", "sigma_m", "status", "origin_deg_m", "gps_start")
    return trajectory(arrays["position_m"], **{key: arrays[key] for key in known})


def trajectory_arrays(labelled: xr.Dataset) -> dict[str, Any]:
    """Positions as the native module takes them."""
    if not isinstance(labelled, xr.Dataset) or not set("xyz") <= set(labelled):
        raise TypeError(
            "trajectory: expected a Dataset with x, y and z, as acerra.trajectory, "
            "acerra.read_trajectory and acerra.ppk make it"
        )
    has_time = "time" in labelled.coords
    # Attributes that were read from a file are arrays.
    origin = labelled.attrs.get("origin_deg_m")
    start = labelled.attrs.get("gps_start")
    return {
        "position_m": _matrix("", labelled),
        "time_s": real_vector("time", labelled["time"], "s") if has_time else None,
        "sigma_m": _matrix("sigma_", labelled) if "sigma_x" in labelled else None,
        "status": [str(s) for s in labelled["status"].values] if "status" in labelled else None,
        "origin_deg_m": None if origin is None else tuple(map(float, origin)),
        "gps_start": None if start is None else (int(start[0]), float(start[1])),
    }


def _matrix(prefix: str, labelled: xr.Dataset) -> npt.NDArray[np.float64]:
    """The columns of the three axes as ``[n, 3]``."""
    names = [f"{prefix}{axis}" for axis in "xyz"]
    return np.column_stack([real_vector(name, labelled[name], "m") for name in names])
