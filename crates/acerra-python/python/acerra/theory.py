"""What a flight can resolve, and what position errors do to it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from . import _checks as checks
from . import _native
from ._labelled import image_of
from ._native import SPEED_OF_LIGHT_M_S, Plane


def resolution(
    height_m: float,
    offset_m: float,
    *,
    half_aperture_m: float | None = None,
    band_hz: tuple[float, float] = (3.1e9, 4.8e9),
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
) -> dict[str, Any]:
    """What a straight track resolves: Eqs. (6) to (12) of Catapano et al. 2020.

    Parameters
    ----------
    height_m : float
        Height of the flight above the target.
    offset_m : float
        Horizontal distance of the target from the track.
    half_aperture_m : float, optional
        Half-length of the track abeam the target; without it there is no along-track figure.
    band_hz : tuple of float
        Lowest and highest frequency.
    light_speed_m_s : float
        Speed of light.

    Returns
    -------
    dict
        ``along_m``, ``range_m``, ``across_m``, ``across_bounds_m``, ``longest_step_m`` and ``caveats``.

    Examples
    --------
    >>> import acerra
    >>> found = acerra.resolution(10, 2, half_aperture_m=9)
    >>> round(found["across_m"], 2)  # Table 4: 0.41 m
    0.41
    """
    band = checks.frequencies("band_hz", band_hz).tolist()
    found: dict[str, Any] = json.loads(
        _native.resolution(height_m, offset_m, band, half_aperture_m, light_speed_m_s)
    )
    return found


class PointSpread:
    """How a flight images a point: Eqs. (4) and (5) of Catapano et al. 2020.

    Parameters
    ----------
    position_m : array_like, shape (pulses, 3)
        Phase centres of the antenna, m.
    frequency_hz : array_like, shape (frequencies,)
        Frequencies, Hz.
    weight : array_like, shape (pulses,), optional
        Weight of each pulse.
    light_speed_m_s : float
        Speed of light, m/s.

    Examples
    --------
    >>> import acerra, numpy as np
    >>> track = np.column_stack([np.linspace(-3, 3, 301), np.zeros(301), np.full(301, 5.0)])
    >>> spread = acerra.PointSpread(track, np.linspace(3.1e9, 4.8e9, 86))
    >>> found = spread.analyse([0, 2, 0])
    >>> abs(found["across"]["rayleigh_m"] - 0.247) < 0.005  # Table 1
    True
    """

    def __init__(
        self,
        position_m: npt.ArrayLike,
        frequency_hz: npt.ArrayLike,
        *,
        weight: npt.ArrayLike | None = None,
        light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
    ) -> None:
        places = checks.places("position_m", position_m)
        self._path_m = np.concatenate(
            [[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))]
        )
        self._native = _native.Spread(
            places,
            checks.weights(weight, len(places)),
            checks.frequencies("frequency_hz", frequency_hz),
            light_speed_m_s,
        )

    def image(self, target_m: npt.ArrayLike, grid: Plane) -> xr.DataArray:
        """The image of unit points at `target_m`, shape (points, 3)."""
        if not isinstance(grid, Plane):
            raise TypeError(f"grid: expected a Plane, found {type(grid).__name__}")
        values = self._native.image(checks.places("target_m", target_m), grid)
        return image_of(values, grid, {})

    def analyse(
        self, target_m: tuple[float, float, float] | list[float], *, plane_z_m: float | None = None
    ) -> dict[str, Any]:
        """Place, widths, sidelobes and ghost of the image of a unit point.

        Parameters
        ----------
        target_m : sequence of float
            The point, m.
        plane_z_m : float, optional
            Height of the image plane; the point's by default.
        """
        z_m = target_m[2] if plane_z_m is None else plane_z_m
        found: dict[str, Any] = json.loads(self._native.analyse(list(target_m), z_m))
        return found

    def blur(
        self,
        target_m: tuple[float, float, float] | list[float],
        sigma_m: float | npt.ArrayLike,
        *,
        correlation_m: float | None = None,
    ) -> dict[str, Any]:
        """What position errors do to the image of a unit point, by theory.

        Parameters
        ----------
        target_m : sequence of float
            The point, m.
        sigma_m : float or array_like, shape (pulses, 3)
            Standard deviations of the positions.
        correlation_m : float, optional
            Path over which errors stay alike (to 1/e); without it they are new at every pulse.

        Examples
        --------
        >>> import acerra, numpy as np
        >>> track = np.column_stack([np.linspace(-3, 3, 201), np.zeros(201), np.full(201, 5.0)])
        >>> spread = acerra.PointSpread(track, np.linspace(3.1e9, 4.8e9, 86))
        >>> bool(abs(spread.blur([0, 2, 0], 0.005)["peak_loss_db"] + 3) < 0.3)
        True
        """
        if np.ndim(sigma_m) == 0:
            sigma = np.full((len(self._path_m), 3), sigma_m, dtype=np.float64)
        else:
            sigma = checks.places("sigma_m", sigma_m)
        found: dict[str, Any] = json.loads(
            self._native.blur(list(target_m), sigma, self._path_m, correlation_m)
        )
        return found
