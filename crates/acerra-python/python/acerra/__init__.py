"""Acerra: from raw drone radar and GNSS logs to a focused, measured, georeferenced image of the ground.

The chain::

    campaign = acerra.Campaign.read("flight.toml")
    run = campaign.run()                    # what `acerra focus` does
    run.image, run.targets, run.evidence

Its parts::

    radargram = acerra.read_radar("flight.mrm")
    trajectory = acerra.ppk("rover.ubx", "base.ubx")
    prepared = acerra.prepare(radargram, trajectory, image={"x_m": [0, 18], "y_m": [-9, 9]})
    image = prepared.image(acerra.Plane([0, 18], [-9, 9], pixel_m=0.02))

Arrays of any origin::

    image = acerra.adjoint(position_m, frequency_hz, spectrum, grid)

Units are SI and stand in the names; positions are x east, y north, z up in metres; images are
``[rows, columns]`` with row 0 at the smallest y; an echo from range R has phase −4πfR/c.
"""

from . import plot
from ._checks import Grid
from ._labelled import radargram, trajectory
from ._native import (
    SPEED_OF_LIGHT_M_S,
    AcerraError,
    AlignError,
    CleanError,
    EvidenceError,
    ImagingError,
    Plane,
    PositionError,
    ReadError,
    SettingsError,
    Surface,
    Tilted,
    Volume,
    __version__,
)
from ._storage import join_complex, split_complex
from .campaigns import Campaign, Prepared, Run, calibrate, focus, prepare
from .evidence import AcerraWarning, Evidence, Finding
from .flights import FlightPlan, plan, simulate, simulate_demo
from .imaging import adjoint, forward, measure
from .readers import ppk, read_radar, read_trajectory
from .readers import read_radar as read
from .theory import PointSpread, resolution

__all__ = [
    "SPEED_OF_LIGHT_M_S",
    "AcerraError",
    "AcerraWarning",
    "AlignError",
    "Campaign",
    "CleanError",
    "Evidence",
    "EvidenceError",
    "Finding",
    "FlightPlan",
    "Grid",
    "ImagingError",
    "Plane",
    "PointSpread",
    "PositionError",
    "Prepared",
    "ReadError",
    "Run",
    "SettingsError",
    "Surface",
    "Tilted",
    "Volume",
    "__version__",
    "adjoint",
    "calibrate",
    "focus",
    "forward",
    "join_complex",
    "measure",
    "plan",
    "plot",
    "ppk",
    "prepare",
    "radargram",
    "read",
    "read_radar",
    "read_trajectory",
    "resolution",
    "simulate",
    "simulate_demo",
    "split_complex",
    "trajectory",
]
