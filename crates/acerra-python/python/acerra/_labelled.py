"""Arrays with named coordinates and units."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ._checks import increasing, places, real_matrix, real_vector
from ._native import Plane, Surface, Tilted, Volume

Grid = Plane | Tilted | Surface | Volume
"""Pixels: a plane, a tilted plane, uneven ground or a volume."""


GPS_EPOCH = np.datetime64("1980-01-06T00:00:00", "ns")
"""Start of GPS week 0, GPS time."""


def storable(attrs: dict[str, Any]) -> dict[str, Any]:
    """Attributes that NetCDF and Zarr can hold.

    An attribute without a value is left out, truth values become 0 or 1, mappings and lists of anything
    but numbers become JSON text.
    """
    stored: dict[str, Any] = {}
    for name, value in attrs.items():
        if isinstance(value, bool):
            stored[name] = int(value)
        elif isinstance(value, dict) or (
            isinstance(value, list | tuple)
            and not all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
        ):
            stored[name] = json.dumps(value)
        elif value is not None:
            stored[name] = value
    return stored


def _metres(name: str) -> dict[str, str]:
    return {"units": "m", "long_name": name}


def image_of(values: npt.NDArray[np.complex64], grid: Grid, attrs: dict[str, Any]) -> xr.DataArray:
    """An image with the coordinates of its grid."""
    attrs = storable({"long_name": "reflectivity", **attrs})
    if isinstance(grid, Tilted):
        rows, columns = np.indices(grid.shape)
        steps = [
            o + columns * u + rows * v
            for o, u, v in zip(grid.origin_m, grid.u_m, grid.v_m, strict=True)
        ]
        coords: dict[str, Any] = {
            axis: (("row", "column"), step, _metres(axis))
            for axis, step in zip("xyz", steps, strict=True)
        }
        return xr.DataArray(values, coords, ("row", "column"), "image", attrs)
    coords = {
        "x": ("x", grid.x_m, _metres("east")),
        "y": ("y", grid.y_m, _metres("north")),
    }
    if isinstance(grid, Volume):
        coords["z"] = ("z", grid.z_m, _metres("up"))
        return xr.DataArray(values, coords, ("z", "y", "x"), "image", attrs)
    z_dims = ("y", "x") if isinstance(grid, Surface) else ()
    coords["z"] = (z_dims, grid.z_m, _metres("up"))
    return xr.DataArray(values, coords, ("y", "x"), "image", attrs)


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
        Variables ``position`` and, where given, ``sigma`` and ``status``; with `time_s` and `gps_start`
        the coordinate ``gps_time``, GPS time as ``datetime64``.

    Examples
    --------
    >>> import acerra
    >>> acerra.trajectory([[0, 0, 5], [1, 0, 5]], time_s=[0, 0.5]).position.sizes
    Frozen({'epoch': 2, 'axis': 3})
    """
    position = places("position_m", position_m)
    data: dict[str, Any] = {"position": (("epoch", "axis"), position, {"units": "m"})}
    coords: dict[str, Any] = {"axis": ["x", "y", "z"]}
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
            coords["gps_time"] = ("epoch", GPS_EPOCH + start + after_epoch, {"long_name": "GPS time"})
    if sigma_m is not None:
        sigma = places("sigma_m", sigma_m)
        if sigma.shape != position.shape or not (sigma >= 0).all():
            raise ValueError(
                f"sigma_m: expected {position.shape} values of 0 m or more, found {sigma.shape}"
            )
        data["sigma"] = (("epoch", "axis"), sigma, {"units": "m"})
    if status is not None:
        data["status"] = ("epoch", list(status))
    attrs: dict[str, Any] = {}
    if origin_deg_m is not None:
        attrs["origin_deg_m"] = tuple(map(float, origin_deg_m))
    if gps_start is not None:
        attrs["gps_start"] = (int(gps_start[0]), float(gps_start[1]))
    return xr.Dataset(data, coords, attrs)


def trajectory_of(arrays: dict[str, Any]) -> xr.Dataset:
    """A trajectory that the native module gives."""
    known = ("time_s", "sigma_m", "status", "origin_deg_m", "gps_start")
    return trajectory(arrays["position_m"], **{key: arrays[key] for key in known})


def trajectory_arrays(labelled: xr.Dataset) -> dict[str, Any]:
    """Positions as the native module takes them."""
    if not isinstance(labelled, xr.Dataset) or "position" not in labelled:
        raise TypeError(
            "trajectory: expected a Dataset with position, as acerra.trajectory, "
            "acerra.read_trajectory and acerra.ppk make it"
        )
    has_time = "time" in labelled.coords
    # Attributes that were read from a file are arrays.
    origin = labelled.attrs.get("origin_deg_m")
    start = labelled.attrs.get("gps_start")
    return {
        "position_m": places("position", labelled["position"]),
        "time_s": real_vector("time", labelled["time"], "s") if has_time else None,
        "sigma_m": real_matrix("sigma", labelled["sigma"], "m") if "sigma" in labelled else None,
        "status": [str(s) for s in labelled["status"].values] if "status" in labelled else None,
        "origin_deg_m": None if origin is None else tuple(map(float, origin)),
        "gps_start": None if start is None else (int(start[0]), float(start[1])),
    }
