"""Flights that the tests share."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import acerra
import numpy as np
import pytest

# A short pass over one corner reflector, positions as a table.
SCENE = {
    "seed": 7,
    "flight": {
        "track_start_m": [0.0, 0.0],
        "track_end_m": [6.0, 0.0],
        "height_m": 4.0,
        "track_duration_s": 6.0,
        "ground_time_s": 0.0,
    },
    "ground": {"reflection": 0.08},
    "corner": [{"position_m": [3.0, 0.5, 0.0]}],
}


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The logs of the demo's Track 1, from one end of the track to the other, the offset told."""
    folder = tmp_path_factory.mktemp("track-1")
    acerra.simulate_demo(folder / "from-take-off", track=1)
    scene = (folder / "from-take-off" / "scene.toml").read_text()
    scene = scene.replace('record = "flight"', 'record = "track"')
    (folder / "scene.toml").write_text(scene.replace('offset = "auto"', 'offset = "exact"'))
    acerra.simulate(folder / "scene.toml", folder / "on-track")
    return folder / "on-track"


@pytest.fixture(scope="session")
def command() -> Path:
    """The command, built from the same sources."""
    root = Path(__file__).resolve().parents[3]
    stated = os.environ.get("ACERRA_BINARY")
    built = (root / "target" / profile / "acerra" for profile in ("debug", "release"))
    found = [Path(stated)] if stated else [path for path in built if path.is_file()]
    on_path = shutil.which("acerra")
    found += [Path(on_path)] if on_path else []
    if not found:
        pytest.skip("the command acerra is not built")
    version = subprocess.run([found[0], "--version"], capture_output=True, text=True, check=True)
    if acerra.__version__ not in version.stdout:
        pytest.skip(f"{found[0]} is of another version: {version.stdout.strip()}")
    return found[0]


class Echoes:
    """Spectra of a few points seen from a wavy track, by the textbook formula."""

    def __init__(self) -> None:
        random = np.random.default_rng(5)
        y = np.linspace(-2, 2, 61)
        self.position_m = np.column_stack(
            [0.2 * np.sin(y), y, 4 + 0.1 * random.normal(size=y.size)]
        )
        self.frequency_hz = np.linspace(3.1e9, 4.8e9, 86)
        self.target_m = np.array([[1.5, 0.2, 0.0], [2.1, -0.4, 0.1]])
        self.spectrum = self.echoes_of(self.target_m, np.array([1.0, 0.6]))

    def echoes_of(self, points_m: np.ndarray, values: np.ndarray) -> np.ndarray:
        """E(m, n) = Σ σ e^{−j4πfR/c} / R²."""
        spectrum = np.zeros((len(self.position_m), len(self.frequency_hz)), complex)
        for point, value in zip(points_m, values, strict=True):
            distance = np.linalg.norm(self.position_m - point, axis=1)[:, None]
            phase = -4 * np.pi * self.frequency_hz * distance / acerra.SPEED_OF_LIGHT_M_S
            spectrum += value * np.exp(1j * phase) / distance**2
        return spectrum

    def image_at(self, points_m: np.ndarray, spectrum: np.ndarray | None = None) -> np.ndarray:
        """Eq. (3) at points, in double precision."""
        spectrum = self.spectrum if spectrum is None else spectrum
        values = np.zeros(len(points_m), complex)
        for position, row in zip(self.position_m, spectrum, strict=True):
            distance = np.linalg.norm(points_m - position, axis=1)[:, None]
            phase = 4 * np.pi * self.frequency_hz * distance / acerra.SPEED_OF_LIGHT_M_S
            values += (np.exp(1j * phase) / distance**2) @ row
        return values


@pytest.fixture(scope="session")
def echoes() -> Echoes:
    return Echoes()
