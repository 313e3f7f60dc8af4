"""The scattering operator and its adjoint for others' solvers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks as checks
from . import _native
from ._checks import Grid
from ._extras import needed
from .imaging import settings

needed("scipy.sparse.linalg", "operators", "acerra.operators")
from scipy.sparse.linalg import LinearOperator  # noqa: E402


class ScatteringOperator(LinearOperator):
    """Spectra of an image, and the image of spectra, as a linear operator of SciPy's kind.

    ``operator @ image.ravel()`` models echoes and ``operator.H @ spectrum.ravel()`` images them; SciPy's
    and PyLops' solvers take it as it is. Each product keeps `accuracy`, so that solvers converge to about
    that residual.

    Parameters
    ----------
    position_m : array_like, shape (pulses, 3)
        Phase centres of the antenna, m.
    frequency_hz : array_like, shape (frequencies,)
        Frequencies, Hz.
    grid : Plane, Tilted, Surface or Volume
        The pixels.
    weight : array_like, shape (pulses,), optional
        Weight of each pulse.
    accuracy : float
        Relative L2 error allowed for each product.
    **requirements
        `spreading`, `engine`, `memory_limit_bytes`, `check_pixels`, `light_speed_m_s` as in
        `acerra.adjoint`.

    Examples
    --------
    >>> import acerra, numpy as np
    >>> from acerra.operators import ScatteringOperator
    >>> track = np.column_stack([np.zeros(41), np.linspace(-1, 1, 41), np.full(41, 4.0)])
    >>> grid = acerra.Plane([1, 1.5], [0, 0.5], pixel_m=0.02)
    >>> L = ScatteringOperator(track, np.linspace(3.1e9, 4.8e9, 35), grid, accuracy=1e-5)
    >>> random = np.random.default_rng(1)
    >>> x = random.normal(size=L.shape[1]) + 0j
    >>> y = random.normal(size=L.shape[0]) + 0j
    >>> left, right = np.vdot(y, L @ x), np.vdot(L.H @ y, x)
    >>> bool(abs(left - right) < 1e-4 * np.linalg.norm(L @ x) * np.linalg.norm(y))
    True
    """

    def __init__(
        self,
        position_m: npt.ArrayLike,
        frequency_hz: npt.ArrayLike,
        grid: Grid,
        *,
        weight: npt.ArrayLike | None = None,
        accuracy: float = 1e-5,
        **requirements: Any,
    ) -> None:
        self._antennas = checks.antennas(position_m, frequency_hz, weight)
        self.grid = checks.grid(grid)
        self._settings = settings(accuracy=accuracy, **requirements)
        self._spectrum_shape = tuple(
            len(self._antennas[axis]) for axis in ("position_m", "frequency_hz")
        )
        rows = int(np.prod(self._spectrum_shape))
        # The stubs of SciPy know its factory alone.
        super().__init__(np.dtype(np.complex128), (rows, int(np.prod(grid.shape))))  # type: ignore[call-arg]

    def _matvec(self, x: npt.NDArray[Any]) -> npt.NDArray[np.complex128]:
        image = np.ascontiguousarray(np.ravel(x), dtype=np.complex64)
        spectra = _native.forward(self.grid, image, self._antennas, self._settings, None)
        return spectra.ravel()

    def _rmatvec(self, x: npt.NDArray[Any]) -> npt.NDArray[np.complex128]:
        spectrum = np.ascontiguousarray(np.reshape(x, self._spectrum_shape), dtype=np.complex128)
        image, _ = _native.adjoint(self.grid, self._antennas, spectrum, self._settings, None)
        return image.ravel().astype(np.complex128)
