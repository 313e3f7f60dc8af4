"""Simulated flights, and plans of real ones."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from . import _native
from .campaigns import Campaign
from .readers import PathLike


def simulate(
    scene: PathLike | Mapping[str, Any], directory: PathLike, *, seed: int | None = None
) -> Campaign:
    """Write the radar and GNSS logs that instruments would have written of a flight over a scene.

    Parameters
    ----------
    scene : path or mapping
        The scene file (``acerra simulate --example`` prints one), or its tables.
    directory : path
        Where the logs go.
    seed : int, optional
        Seed of everything random, instead of the scene's.

    Returns
    -------
    Campaign
        The campaign that images them.
    """
    if isinstance(scene, Mapping):
        text, is_tables, folder = json.dumps(scene), True, Path()
    else:
        path = Path(scene)
        text, is_tables, folder = path.read_text(encoding="utf-8"), False, path.parent
    _native.simulate(text, is_tables, folder, Path(directory), seed)
    return Campaign.read(Path(directory) / "campaign.toml")


def simulate_demo(directory: PathLike, *, track: Literal[1, 2] = 1) -> Campaign:
    """Write the logs of a track of the paper's campaign, as ``acerra demo`` flies it.

    Parameters
    ----------
    directory : path
        Where the logs go.
    track : {1, 2}
        Over the reflectors at 4 m, or 2 m beside them at 10 m.
    """
    if track not in (1, 2):
        raise ValueError(f"track: expected 1 or 2, found {track}")
    scene = _native.DEMO_SCENES[track - 1]
    _native.simulate(scene, False, Path(), Path(directory), None)
    return Campaign.read(Path(directory) / "campaign.toml")


@dataclass(frozen=True)
class FlightPlan:
    """Lines that can be flown.

    Attributes
    ----------
    summary : dict
        Height, speed, lines, batteries and what to expect of the image.
    geojson : dict
        Area and lines.
    missions : list of dict
        One ``.plan`` of QGroundControl for each flight.
    kml : str
        Area and lines for Google Earth.
    """

    summary: dict[str, Any]
    geojson: dict[str, Any]
    missions: list[dict[str, Any]]
    kml: str


def plan(area: PathLike | Mapping[str, Any]) -> FlightPlan:
    """Plan a flight: from an area and a wanted resolution to lines.

    Parameters
    ----------
    area : path or mapping
        The plan file (``acerra plan --example`` prints one), or its tables.
    """
    if isinstance(area, Mapping):
        text, is_tables, folder = json.dumps(area), True, Path()
    else:
        path = Path(area)
        text, is_tables, folder = path.read_text(encoding="utf-8"), False, path.parent
    said, kml = _native.plan_flight(text, is_tables, folder)
    return FlightPlan(**json.loads(said), kml=kml)
