"""Imaging and modelling of arrays."""

from __future__ import annotations

import json
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from . import _checks as checks
from . import _native
from ._checks import Grid
from ._labelled import image_of
from ._native import SPEED_OF_LIGHT_M_S, Plane
from ._progress import Progress, listener

Engine = Literal["auto", "direct", "factorized", "double", "reference"]
Spreading = Literal["inverse-square", "none"]


def settings(
    *,
    accuracy: float = 1e-3,
    spreading: Spreading = "inverse-square",
    engine: Engine = "auto",
    memory_limit_bytes: int | None = None,
    check_pixels: int = 256,
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
) -> _native.Settings:
    """Requirements on an operator, as `adjoint` and `forward` describe them."""
    return _native.Settings(
        accuracy, spreading, engine, memory_limit_bytes, check_pixels, light_speed_m_s
    )


def adjoint(
    position_m: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    spectrum: npt.ArrayLike,
    grid: Grid,
    *,
    weight: npt.ArrayLike | None = None,
    accuracy: float = 1e-3,
    spreading: Spreading = "inverse-square",
    engine: Engine = "auto",
    memory_limit_bytes: int | None = None,
    check_pixels: int = 256,
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
    progress: bool | Progress | None = None,
) -> xr.DataArray:
    """Image spectra: the adjoint of the scattering operator, Eq. (3) of Catapano et al. 2020.

    Parameters
    ----------
    position_m : array_like, shape (pulses, 3)
        Phase centres of the antenna: x, y, z in metres.
    frequency_hz : array_like, shape (frequencies,)
        Frequencies, Hz.
    spectrum : array_like, shape (pulses, frequencies)
        Spectra; an echo from range R has phase −4πfR/c.
    grid : Plane, Tilted, Surface or Volume
        The pixels.
    weight : array_like, shape (pulses,), optional
        Weight of each pulse; one each by default.
    accuracy : float
        Relative L2 error allowed against the sum in double precision. The plan checks itself on
        random pixels.
    spreading : {"inverse-square", "none"}
        Weight by range: 1/R², or none.
    engine : {"auto", "direct", "factorized", "double", "reference"}
        Algorithm; chosen by cost by default.
    memory_limit_bytes : int, optional
        Most bytes that tables and image may take; the memory available by default.
    check_pixels : int
        Most pixels on which the plan checks itself.
    light_speed_m_s : float
        Speed of light, m/s.
    progress : bool or function, optional
        ``True`` for a bar (tqdm), or a function of step, units done and units in all.

    Returns
    -------
    xarray.DataArray of complex64
        The image over the grid's coordinates. Its attributes tell the plan, the memory promised
        (``memory_bytes``) and the error found (``checked_error``).

    Raises
    ------
    ImagingError
        Data or accuracy that cannot be; more memory than allowed.
    KeyboardInterrupt
        On Ctrl-C, within a fraction of a second.

    Examples
    --------
    >>> import acerra, numpy as np
    >>> track = np.column_stack([np.zeros(101), np.linspace(-1.5, 1.5, 101), np.full(101, 5.0)])
    >>> frequency = np.linspace(3.1e9, 4.8e9, 86)
    >>> distance = np.linalg.norm(track - [2.0, 0.2, 0.0], axis=1)
    >>> delay = 2 * distance / acerra.SPEED_OF_LIGHT_M_S
    >>> echoes = np.exp(-2j * np.pi * np.outer(delay, frequency)) / distance[:, None] ** 2
    >>> grid = acerra.Plane([1, 3], [-0.8, 1.2], pixel_m=0.02)
    >>> image = acerra.adjoint(track, frequency, echoes, grid)
    >>> peak = image[abs(image).argmax(...)]
    >>> round(float(peak.x), 2), round(float(peak.y), 2)
    (2.0, 0.2)
    """
    values, said = _native.adjoint(
        checks.grid(grid),
        checks.antennas(position_m, frequency_hz, weight),
        checks.complex_matrix("spectrum", spectrum),
        settings(
            accuracy=accuracy,
            spreading=spreading,
            engine=engine,
            memory_limit_bytes=memory_limit_bytes,
            check_pixels=check_pixels,
            light_speed_m_s=light_speed_m_s,
        ),
        listener(progress),
    )
    return image_of(values, grid, json.loads(said))


def forward(
    image: npt.ArrayLike,
    grid: Grid,
    position_m: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    *,
    weight: npt.ArrayLike | None = None,
    accuracy: float = 1e-3,
    spreading: Spreading = "inverse-square",
    engine: Engine = "auto",
    memory_limit_bytes: int | None = None,
    check_pixels: int = 256,
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
    progress: bool | Progress | None = None,
) -> npt.NDArray[np.complex128]:
    """Model echoes: the spectra that a scene would have given.

    The exact transpose of `adjoint` on the same pulses and grid, each within its accuracy. A volume is
    modelled slice by slice; uneven ground by the sum in double precision, which is slow for many pixels.

    Parameters
    ----------
    image : array_like
        Reflectivity over the grid, of the grid's shape.
    grid : Plane, Tilted, Surface or Volume
        The pixels.
    position_m, frequency_hz, weight
        As in `adjoint`.
    accuracy, spreading, engine, memory_limit_bytes, check_pixels, light_speed_m_s, progress
        As in `adjoint`.

    Returns
    -------
    numpy.ndarray of complex128, shape (pulses, frequencies)
        The spectra.

    Examples
    --------
    >>> import acerra, numpy as np
    >>> grid = acerra.Plane([0, 0.5], [0, 0.5], pixel_m=0.02)
    >>> scene = np.zeros(grid.shape)
    >>> scene[0, 0] = 1
    >>> echo = acerra.forward(scene, grid, [[0.0, -1.0, 5.0]], [3.1e9, 3.2e9])
    >>> bool(abs(abs(echo[0, 0]) * 26 - 1) < 1e-2)  # 26 m² is the squared range
    True
    """
    return _native.forward(
        grid,
        checks.image("image", image, checks.grid(grid).shape).ravel(),
        checks.antennas(position_m, frequency_hz, weight),
        settings(
            accuracy=accuracy,
            spreading=spreading,
            engine=engine,
            memory_limit_bytes=memory_limit_bytes,
            check_pixels=check_pixels,
            light_speed_m_s=light_speed_m_s,
        ),
        listener(progress),
    )


def measure(
    image: npt.ArrayLike,
    grid: Plane,
    position_m: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    spectrum: npt.ArrayLike,
    *,
    weight: npt.ArrayLike | None = None,
    threshold_db: float = -12.0,
    max_targets: int = 50,
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
) -> dict[str, Any]:
    """Find and measure the targets of an image.

    Parameters
    ----------
    image : array_like, shape (rows, columns)
        The image.
    grid : Plane
        Its pixels.
    position_m, frequency_hz, spectrum, weight
        What it was made of: expected widths, sidelobes and ghosts follow from them.
    threshold_db : float
        Peaks weaker than this relative to the strongest are not listed.
    max_targets : int
        At most so many targets are listed.
    light_speed_m_s : float
        Speed of light, m/s.

    Returns
    -------
    dict
        ``targets`` (place, level, widths along and across the track, sidelobes, ghost), ``statistics`` of
        the image, and how many maxima were taken for clutter, sidelobes and ghosts.
    """
    if not isinstance(grid, Plane):
        raise TypeError(f"grid: expected a Plane, found {type(grid).__name__}")
    found: dict[str, Any] = json.loads(
        _native.measure(
            grid,
            checks.image("image", image, grid.shape),
            checks.antennas(position_m, frequency_hz, weight),
            checks.complex_matrix("spectrum", spectrum),
            (threshold_db, max_targets, light_speed_m_s),
        )
    )
    return found
