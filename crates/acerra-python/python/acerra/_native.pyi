from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
import numpy.typing as npt

_Real = npt.NDArray[np.float64]
_Image = npt.NDArray[np.complex64]
_Spectrum = npt.NDArray[np.complex128]
_Progress = Callable[[str, int, int], object] | None

__all__ = [
    "AcerraError",
    "AlignError",
    "Campaign",
    "CleanError",
    "DEMO_SCENES",
    "EvidenceError",
    "ImagingError",
    "Plane",
    "PositionError",
    "Prepared",
    "ReadError",
    "Run",
    "SPEED_OF_LIGHT_M_S",
    "Settings",
    "SettingsError",
    "Spread",
    "Surface",
    "Tilted",
    "Volume",
    "__version__",
    "adjoint",
    "calibrate",
    "focus",
    "forward",
    "measure",
    "part_of",
    "plan_flight",
    "ppk",
    "prepare_arrays",
    "promise",
    "read_radar",
    "read_trajectory",
    "resolution",
    "set_threads",
    "simulate",
]

__version__: str
SPEED_OF_LIGHT_M_S: float
DEMO_SCENES: tuple[str, str]

class AcerraError(Exception): ...
class SettingsError(AcerraError): ...
class ReadError(AcerraError): ...
class PositionError(AcerraError): ...
class AlignError(AcerraError): ...
class CleanError(AcerraError): ...
class ImagingError(AcerraError): ...
class EvidenceError(AcerraError): ...

@final
class Plane:
    def __new__(
        cls, x_m: Sequence[float], y_m: Sequence[float], *, z_m: float = 0.0, pixel_m: float
    ) -> Plane: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...
    @property
    def x_m(self) -> _Real: ...
    @property
    def y_m(self) -> _Real: ...
    @property
    def z_m(self) -> float: ...
    @property
    def pixel_m(self) -> float: ...
    @property
    def shape(self) -> tuple[int, int]: ...

@final
class Tilted:
    def __new__(
        cls,
        origin_m: Sequence[float],
        u_m: Sequence[float],
        v_m: Sequence[float],
        *,
        shape: tuple[int, int],
    ) -> Tilted: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...
    @property
    def origin_m(self) -> list[float]: ...
    @property
    def u_m(self) -> list[float]: ...
    @property
    def v_m(self) -> list[float]: ...
    @property
    def shape(self) -> tuple[int, int]: ...

@final
class Surface:
    def __new__(
        cls, x_m: Sequence[float], y_m: Sequence[float], heights_m: _Real, *, pixel_m: float
    ) -> Surface: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...
    @property
    def x_m(self) -> _Real: ...
    @property
    def y_m(self) -> _Real: ...
    @property
    def z_m(self) -> _Real: ...
    @property
    def pixel_m(self) -> float: ...
    @property
    def shape(self) -> tuple[int, int]: ...

@final
class Volume:
    def __new__(
        cls,
        x_m: Sequence[float],
        y_m: Sequence[float],
        z_m: Sequence[float],
        *,
        pixel_m: float,
        step_m: float | None = None,
    ) -> Volume: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...
    @property
    def x_m(self) -> _Real: ...
    @property
    def y_m(self) -> _Real: ...
    @property
    def z_m(self) -> _Real: ...
    @property
    def pixel_m(self) -> float: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    def slice(self, index: int) -> Plane: ...

_Grid = Plane | Tilted | Surface | Volume

@final
class Settings:
    def __new__(
        cls,
        accuracy: float,
        spreading: str,
        engine: str,
        memory_limit_bytes: int | None,
        check_pixels: int,
        light_speed_m_s: float,
    ) -> Settings: ...

def part_of(grid: _Grid, start: Sequence[int], stop: Sequence[int]) -> _Grid: ...
def promise(
    grid: _Grid, antennas: dict[str, _Real], spectrum: _Spectrum, settings: Settings
) -> str: ...
def set_threads(threads: int) -> bool: ...
def adjoint(
    grid: _Grid,
    antennas: dict[str, _Real],
    spectrum: _Spectrum,
    settings: Settings,
    progress: _Progress,
) -> tuple[_Image, str]: ...
def forward(
    grid: _Grid,
    image: _Image,
    antennas: dict[str, _Real],
    settings: Settings,
    progress: _Progress,
) -> _Spectrum: ...
def measure(
    grid: Plane,
    image: _Image,
    antennas: dict[str, _Real],
    spectrum: _Spectrum,
    limits: tuple[float, int, float],
) -> str: ...

@final
class Campaign:
    @staticmethod
    def parse(text: str, folder: Path, name: str) -> Campaign: ...
    @staticmethod
    def from_tables(tables: str, folder: Path, name: str) -> Campaign: ...
    def tables(self) -> str: ...
    def prepare(self, progress: _Progress) -> Prepared: ...
    def run(self, progress: _Progress) -> Run: ...

@final
class Prepared:
    @property
    def position_m(self) -> _Real: ...
    @property
    def sigma_m(self) -> _Real | None: ...
    @property
    def time_s(self) -> _Real: ...
    @property
    def trace(self) -> npt.NDArray[np.uint64]: ...
    @property
    def frequency_hz(self) -> _Real: ...
    @property
    def spectrum(self) -> _Spectrum: ...
    @property
    def defaults(self) -> str: ...
    @property
    def light_speed_m_s(self) -> float: ...
    @property
    def origin_deg_m(self) -> list[float] | None: ...
    @property
    def grid(self) -> Plane | Surface | Volume: ...
    @property
    def tracks(self) -> list[tuple[str, int, int]]: ...
    @property
    def findings(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    def weights(self, weight: str | None) -> _Real: ...
    def settled(self, track: int) -> str: ...
    def radargram(self, track: int, kind: str) -> dict[str, Any] | None: ...
    def image(
        self, grid: _Grid, options: dict[str, Any], progress: _Progress
    ) -> tuple[_Image, str]: ...
    def measure(
        self,
        grid: _Grid,
        options: dict[str, Any],
        limits: tuple[float, int],
        progress: _Progress,
    ) -> str: ...

@final
class Run:
    @property
    def name(self) -> str: ...
    @property
    def image(self) -> _Image: ...
    @property
    def volume(self) -> _Image | None: ...
    @property
    def grid(self) -> Plane | Surface | Volume: ...
    def record(self) -> str: ...
    def targets(self) -> str: ...
    def prepared(self) -> Prepared: ...
    def picture(self, kind: str) -> bytes | None: ...

def calibrate(file: Path, reflector_m: list[list[float]], progress: _Progress) -> str: ...
def focus(file: Path, directory: Path, progress: _Progress) -> Run: ...
def prepare_arrays(
    radargram: dict[str, Any], positions: dict[str, Any], tables: str, progress: _Progress
) -> Prepared: ...
def read_radar(file: Path, channel: str | None) -> dict[str, Any]: ...
def read_trajectory(
    file: Path, origin_deg_m: Sequence[float] | None, rigid_body: str | None
) -> dict[str, Any]: ...
def ppk(
    rover: list[Path],
    base: list[Path],
    navigation: list[Path],
    settings: str | None,
    base_ecef_m: Sequence[float] | None,
) -> tuple[dict[str, Any], str]: ...
def simulate(
    scene: str, is_tables: bool, folder: Path, directory: Path, seed: int | None
) -> str: ...
def plan_flight(plan: str, is_tables: bool) -> tuple[str, str]: ...
def resolution(
    height_m: float,
    offset_m: float,
    band_hz: Sequence[float],
    half_aperture_m: float | None,
    light_speed_m_s: float,
) -> str: ...

@final
class Spread:
    def __new__(
        cls, position_m: _Real, weight: _Real, frequency_hz: _Real, light_speed_m_s: float
    ) -> Spread: ...
    def image(self, target_m: _Real, grid: Plane) -> _Image: ...
    def analyse(self, target_m: Sequence[float], plane_z_m: float) -> str: ...
    def blur(
        self,
        target_m: Sequence[float],
        sigma_m: _Real,
        path_m: _Real,
        correlation_m: float | None,
    ) -> str: ...
