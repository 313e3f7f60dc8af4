"""Radar logs, trajectories and GNSS logs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from . import _native
from ._labelled import radargram, trajectory_of
from ._storage import on_earth, storable
from .evidence import Evidence, warn_of

PathLike = str | os.PathLike[str]


def read_radar(file: PathLike, *, channel: str | None = None) -> xr.DataArray | xr.Dataset:
    """Read a radar log of any format that the command reads.

    Parameters
    ----------
    file : path
        MRM capture, MRM-RET ``.csv``, Acerra's ``.npz``, CPHD, SEG-Y, DZT, DT1, rd3, gprMax, HDF5, MATLAB,
        Touchstone or FMCW.
    channel : str, optional
        The channel of a log that has several.

    Returns
    -------
    xarray.DataArray or xarray.Dataset
        A radargram (dimensions ``trace``, ``fast_time``); of a log of spectra a dataset with ``spectrum``
        and, where the file brings them, ``position``.

    Raises
    ------
    ReadError
        A file that cannot be read, with the place.
    """
    arrays = _native.read_radar(Path(file), channel)
    warn_of(Evidence(()), arrays["warnings"])
    attrs = {"summary": arrays["summary"]}
    origin_deg_m = arrays.get("origin_deg_m")
    if "samples" in arrays:
        labelled = radargram(
            arrays["samples"],
            time_s=arrays["time_s"],
            fast_time_start_s=arrays["fast_time_start_s"],
            fast_time_step_s=arrays["fast_time_step_s"],
            unit=arrays["unit"],
        ).assign_attrs(attrs)
        if "position_m" in arrays:
            labelled = labelled.assign_coords(
                position=(("trace", "axis"), arrays["position_m"], {"units": "m"})
            )
        return on_earth(labelled, origin_deg_m)
    data = {"spectrum": (("trace", "frequency"), arrays["spectrum"], {"units": arrays["unit"]})}
    if "position_m" in arrays:
        data["position"] = (("trace", "axis"), arrays["position_m"], {"units": "m"})
    coords = {
        "time": ("trace", arrays["time_s"], {"units": "s"}),
        "frequency": ("frequency", arrays["frequency_hz"], {"units": "Hz"}),
    }
    return on_earth(xr.Dataset(data, coords, attrs), origin_deg_m)


def read_trajectory(
    file: PathLike,
    *,
    origin_deg_m: tuple[float, float, float] | None = None,
    rigid_body: str | None = None,
) -> xr.Dataset:
    """Read a trajectory: RTKLIB ``.pos``, CSV with a header, NMEA or an OptiTrack export.

    Parameters
    ----------
    file : path
        The file.
    origin_deg_m : tuple of float, optional
        Latitude, longitude (degrees) and ellipsoidal height (m) of the local frame's origin.
    rigid_body : str, optional
        Which rigid body of a motion-capture file.

    Returns
    -------
    xarray.Dataset
        As `acerra.trajectory` makes it.
    """
    return trajectory_of(_native.read_trajectory(Path(file), origin_deg_m, rigid_body))


def ppk(
    rover: PathLike | Sequence[PathLike],
    base: PathLike | Sequence[PathLike] = (),
    navigation: PathLike | Sequence[PathLike] = (),
    *,
    settings: Mapping[str, Any] | PathLike | None = None,
    base_ecef_m: tuple[float, float, float] | None = None,
) -> xr.Dataset:
    """Positions by post-processed carrier-phase GNSS, as `acerra ppk` computes them.

    Parameters
    ----------
    rover, base, navigation : path or sequence of paths
        RINEX, UBX or RTCM logs of the rover and the base, broadcast or precise ephemerides.
    settings : mapping or path, optional
        RTKLIB's settings by their names (``{"pos1-posmode": "kinematic"}``), or a ``.conf`` file: what
        they do not name is as RTKLIB has it. By default the command's: Kinematic, Fix-and-hold, combined.
    base_ecef_m : tuple of float, optional
        Place of the base's antenna, ECEF (m).

    Returns
    -------
    xarray.Dataset
        The trajectory as `acerra.trajectory` makes it, with the figures of ``acerra ppk --json`` as attributes, such as
        ``fixed_percent``; lists and tables among them are JSON text.

    Raises
    ------
    PositionError
        Whatever makes a solution impossible.
    """
    text: str | None
    if settings is None:
        text = None
    elif isinstance(settings, Mapping):
        text = "".join(f"{key} = {value}\n" for key, value in settings.items())
    else:
        text = Path(settings).read_text(encoding="utf-8")
    arrays, said = _native.ppk(_paths(rover), _paths(base), _paths(navigation), text, base_ecef_m)
    summary = json.loads(said)
    warn_of(Evidence(()), summary["warnings"])
    return trajectory_of(arrays).assign_attrs(storable(summary))


def _paths(files: PathLike | Sequence[PathLike]) -> list[Path]:
    if isinstance(files, (str, os.PathLike)):
        return [Path(files)]
    return [Path(file) for file in files]
