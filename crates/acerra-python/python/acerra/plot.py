"""Pictures with matplotlib, which is imported when one is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ._extras import needed


def _axes(ax: Any) -> Any:
    if ax is not None:
        return ax
    return needed("matplotlib.pyplot", "plot", "acerra.plot").subplots(layout="constrained")[1]


def image(labelled: xr.DataArray, *, floor_db: float = -40.0, ax: Any = None) -> Any:
    """Draw the level of an image in dB below its maximum; gives the axes."""
    if labelled.ndim != 2:
        raise ValueError(f"image: expected two dimensions, found {labelled.dims}")
    ax = _axes(ax)
    level = np.abs(labelled.values).astype(float)
    with np.errstate(divide="ignore"):
        level_db = 20 * np.log10(level / max(level.max(), np.finfo(float).tiny))
    x, y = labelled["x"], labelled["y"]
    mesh = ax.pcolormesh(x, y, level_db, vmin=floor_db, vmax=0, shading="nearest")
    ax.set(aspect="equal", xlabel="x, east (m)", ylabel="y, north (m)")
    ax.figure.colorbar(mesh, ax=ax, label="level (dB)")
    return ax


def radargram(labelled: xr.DataArray, *, ax: Any = None) -> Any:
    """Draw a radargram, fast time downwards; gives the axes."""
    ax = _axes(ax)
    samples = labelled.transpose("fast_time", "trace")
    values = np.abs(samples.values) if samples.dtype.kind == "c" else samples.values
    limit = float(np.percentile(np.abs(values), 99.5)) or 1.0
    mesh = ax.pcolormesh(
        np.arange(values.shape[1]),
        1e9 * labelled["fast_time"],
        values,
        vmin=-limit,
        vmax=limit,
        cmap="gray",
        shading="nearest",
    )
    ax.invert_yaxis()
    ax.set(xlabel="trace", ylabel="fast time (ns)")
    ax.figure.colorbar(mesh, ax=ax, label=labelled.attrs.get("units", "amplitude"))
    return ax


def trajectory(labelled: xr.Dataset, *, ax: Any = None) -> Any:
    """Draw a trajectory from above, coloured by solution status; gives the axes."""
    ax = _axes(ax)
    x, y = (labelled[axis].values for axis in "xy")
    if "status" in labelled:
        status = labelled["status"].values
        for name in dict.fromkeys(status):
            chosen = status == name
            ax.plot(x[chosen], y[chosen], ".", label=str(name))
        ax.legend()
    else:
        ax.plot(x, y, ".-")
    # A straight track is as long as the axes are wide.
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x, east (m)", ylabel="y, north (m)")
    return ax
