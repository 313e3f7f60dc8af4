"""Arguments as contiguous arrays of the type that the native module takes.

Real numbers of any width, byte order, stride and origin are converted; what would lose a meaning (complex
numbers for real ones, other units than those named) is refused. Arrays of JAX and Torch are taken as they lend
their buffers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._native import Plane, Surface, Tilted, Volume

# No radar that images works below; what is smaller was stated in another unit.
LOWEST_FREQUENCY_HZ = 1e6

Grid = Plane | Tilted | Surface | Volume
"""Pixels: a plane, a tilted plane, uneven ground or a volume."""

RealVector = npt.NDArray[np.float64]
RealMatrix = npt.NDArray[np.float64]
ComplexMatrix = npt.NDArray[np.complex128]
Image = npt.NDArray[np.complex64]


def _array(name: str, value: Any, units: str | None, kinds: str) -> npt.NDArray[Any]:
    found = getattr(value, "attrs", {}).get("units") if hasattr(value, "attrs") else None
    if units is not None and found is not None and found != units:
        raise ValueError(f'{name}: expected units "{units}", found "{found}"')
    array = _in_memory(name, value)
    if array.dtype.kind not in kinds:
        expected = "numbers" if "c" in kinds else "real numbers"
        raise TypeError(f"{name}: expected {expected}, found dtype {array.dtype}")
    return array


def _in_memory(name: str, value: Any) -> npt.NDArray[Any]:
    """The numbers of an array of any library, without a copy where it lends them (DLPack)."""
    lends = hasattr(value, "__dlpack__") and not hasattr(value, "__array__")
    try:
        return np.from_dlpack(value) if lends else np.asarray(value)
    except (BufferError, RuntimeError, TypeError) as refused:
        raise TypeError(
            f"{name}: expected an array in the processor's memory, found {type(value).__name__}: "
            f"{refused}"
        ) from refused


def _expect_dimensions(name: str, array: npt.NDArray[Any], expected: int) -> None:
    if array.ndim != expected:
        raise ValueError(f"{name}: expected {expected} dimensions, found shape {array.shape}")


def real_vector(name: str, value: Any, units: str | None = None) -> RealVector:
    """A vector of real numbers."""
    array = _array(name, value, units, "fiu")
    _expect_dimensions(name, array, 1)
    return np.ascontiguousarray(array, dtype=np.float64)


def real_matrix(name: str, value: Any, units: str | None = None) -> RealMatrix:
    """A matrix of real numbers."""
    array = _array(name, value, units, "fiu")
    _expect_dimensions(name, array, 2)
    return np.ascontiguousarray(array, dtype=np.float64)


def places(name: str, value: Any) -> RealMatrix:
    """Positions in metres, ``[n, 3]``."""
    array = real_matrix(name, value, "m")
    if array.shape[1] != 3:
        raise ValueError(f"{name}: expected shape (n, 3): x, y, z in metres, found {array.shape}")
    return array


def frequencies(name: str, value: Any) -> RealVector:
    """Frequencies in Hz."""
    array = real_vector(name, value, "Hz")
    low = array[(array > 0) & (array < LOWEST_FREQUENCY_HZ)]
    if low.size:
        raise ValueError(
            f"{name}: expected frequencies in Hz, of {LOWEST_FREQUENCY_HZ:g} Hz or more, found "
            f"{low[0]:g}; 1 GHz is 1e9 Hz"
        )
    return array


def grid(value: Any) -> Grid:
    """Pixels of one of the four kinds."""
    if not isinstance(value, Grid):
        raise TypeError(
            "grid: expected acerra.Plane, Tilted, Surface or Volume, such as "
            f"acerra.Plane([0, 9], [-2, 2], pixel_m=0.02), found {type(value).__name__}"
        )
    return value


def complex_matrix(name: str, value: Any) -> ComplexMatrix:
    """A matrix of complex numbers."""
    array = _array(name, value, None, "cfiu")
    _expect_dimensions(name, array, 2)
    return np.ascontiguousarray(array, dtype=np.complex128)


def image(name: str, value: Any, shape: tuple[int, ...]) -> Image:
    """An image of a grid's shape in complex single precision."""
    array = _array(name, value, None, "cfiu")
    if array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, that of the grid, found {array.shape}")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, dtype=np.complex64)


def weights(value: Any | None, pulses: int) -> RealVector:
    """Weights of the pulses; one each where none are given."""
    if value is None:
        return np.ones(pulses)
    array = real_vector("weight", value)
    if array.shape != (pulses,):
        raise ValueError(
            f"weight: expected shape ({pulses},), one for each position, found {array.shape}"
        )
    return array


def antennas(position_m: Any, frequency_hz: Any, weight: Any | None) -> dict[str, RealMatrix]:
    """Places, frequencies and weights of pulses."""
    positions = places("position_m", position_m)
    return {
        "position_m": positions,
        "frequency_hz": frequencies("frequency_hz", frequency_hz),
        "weight": weights(weight, len(positions)),
    }


def increasing(name: str, value: RealVector) -> RealVector:
    """Times that advance."""
    backwards = np.flatnonzero(~(np.diff(value) > 0))
    if backwards.size:
        k = int(backwards[0]) + 1
        raise ValueError(
            f"{name}: expected increasing times, found {value[k]} after {value[k - 1]} at index {k}"
        )
    return value
