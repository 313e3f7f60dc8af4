"""The chain: from a campaign to prepared spectra, images and products."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from . import _checks as checks
from . import _native
from ._checks import Grid
from ._labelled import image_of, radargram, radargram_arrays, trajectory_arrays
from ._native import Surface, Volume
from ._progress import Progress, listener
from ._results import Results
from ._storage import on_earth
from .evidence import Evidence, warn_of
from .readers import PathLike

Weight = Literal["auto", "trace", "path"]
Sum = Literal["coherent", "incoherent"]


class Campaign:
    """Which logs, how they fit together, which image is wanted.

    Made by `Campaign.read`, `Campaign.parse` or `Campaign.of`.
    """

    def __init__(self, native: _native.Campaign) -> None:
        self._native = native

    def __reduce__(self) -> tuple[Any, tuple[str, str]]:
        return _campaign, (self._native.tables(), self._native.name)

    @classmethod
    def read(cls, file: PathLike) -> Campaign:
        """Read a campaign file (TOML); its paths are relative to its folder.

        Raises
        ------
        SettingsError
            Unknown keys and impossible values, with line and column.
        """
        path = Path(file)
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise _native.ReadError(f"{path}: {error.strerror}") from error
        return cls(_native.Campaign.parse(text, path.parent, path.stem))

    @classmethod
    def parse(cls, text: str, *, folder: PathLike = ".", name: str = "campaign") -> Campaign:
        """A campaign from the text of its file, with paths relative to `folder`.

        Examples
        --------
        >>> import acerra
        >>> acerra.Campaign.parse("[radar]\\nfiel = 'flight.npz'\\n")
        Traceback (most recent call last):
        acerra.SettingsError: line 2, column 1: unknown field `fiel`...
        """
        return cls(_native.Campaign.parse(text, Path(folder), name))

    @classmethod
    def of(
        cls, tables: Mapping[str, Any], *, folder: PathLike = ".", name: str = "campaign"
    ) -> Campaign:
        """A campaign from its tables, by the names that its file uses.

        Examples
        --------
        >>> import acerra
        >>> campaign = acerra.Campaign.of(
        ...     {"radar": {"file": "flight.npz"}, "image": {"x_m": [0, 9], "y_m": [-2, 2]}}
        ... )
        >>> campaign.tables["image"]["frequencies"]
        341
        """
        return cls(_native.Campaign.from_tables(json.dumps(tables), Path(folder), name))

    @property
    def tables(self) -> dict[str, Any]:
        """The campaign with every default filled in."""
        tables: dict[str, Any] = json.loads(self._native.tables())
        return tables

    def prepare(self, *, progress: bool | Progress | None = None) -> Prepared:
        """Read, position, align and clean; the spectra can then be imaged any number of times.

        Findings that do not agree with the settings are warned of (`AcerraWarning`).
        """
        prepared = Prepared(self._native.prepare(listener(progress)))
        warn_of(prepared.evidence, prepared.noticed)
        return prepared

    def run(self, *, progress: bool | Progress | None = None) -> Run:
        """Prepare, image, measure and weigh, as ``acerra focus`` does, without writing products.

        Raises
        ------
        EvidenceError
            What was found contradicts the settings, unless ``[checks] contradictions = "warn"``.
        """
        run = Run(self._native.run(listener(progress)))
        warn_of(run.evidence, run.noticed)
        return run


def _campaign(tables: str, name: str) -> Campaign:
    """A campaign out of a pickle; its paths are already in their folder."""
    return Campaign(_native.Campaign.from_tables(tables, Path(), name))


def focus(
    file: PathLike, output: PathLike | None = None, *, progress: bool | Progress | None = None
) -> Run:
    """Run a campaign file and write its products, as ``acerra focus file -o output`` does.

    Parameters
    ----------
    file : path
        The campaign file.
    output : path, optional
        Directory for the products; without it none are written.
    progress : bool or function, optional
        As in `acerra.adjoint`.
    """
    if output is None:
        return Campaign.read(file).run(progress=progress)
    run = Run(_native.focus(Path(file), Path(output), listener(progress)))
    warn_of(run.evidence, run.noticed)
    return run


def calibrate(
    file: PathLike,
    reflector_m: npt.ArrayLike,
    *,
    survey_sigma_m: float = 0.02,
    progress: bool | Progress | None = None,
) -> dict[str, Any]:
    """Calibrate delay, clock offset and lever arm on reflectors at known places.

    Parameters
    ----------
    file : path
        The campaign file of a flight over the reflectors.
    reflector_m : array_like, shape (reflectors, 3)
        Their phase centres: east, north, up in the frame of the positions, m.
    survey_sigma_m : float, optional
        Standard deviation of each coordinate of a reflector's surveyed place, m.
    progress : bool or function, optional
        As in `acerra.adjoint`.

    Returns
    -------
    dict
        ``estimates`` with standard deviations, ``correlation``, what the flight cannot tell (``singular``),
        how each reflector fits, and the ``keys`` that a campaign file takes from it.
    """
    places = checks.places("reflector_m", reflector_m)
    found = json.loads(
        _native.calibrate(Path(file), places.tolist(), float(survey_sigma_m), listener(progress))
    )
    return {**found["record"], "keys": found["keys"]}


def prepare(
    radargram: xr.DataArray,
    trajectory: xr.Dataset,
    /,
    *,
    progress: bool | Progress | None = None,
    **tables: Mapping[str, Any],
) -> Prepared:
    """Align and clean a radargram and a trajectory in memory.

    Parameters
    ----------
    radargram : xarray.DataArray
        As `acerra.radargram` and `acerra.read_radar` make it.
    trajectory : xarray.Dataset
        As `acerra.trajectory`, `acerra.read_trajectory` and `acerra.ppk` make it; without times its
        positions are those of the traces.
    progress : bool or function, optional
        As in `acerra.adjoint`.
    **tables
        Tables of a campaign: ``image={"x_m": [0, 9], "y_m": [-2, 2]}``, ``preprocess``, ``trajectory``
        (clock offset, lever arm, origin), ``radar`` (delay), …, without files.

    Returns
    -------
    Prepared
        Clean spectra at known places.
    """
    settings = {key: dict(value) for key, value in tables.items()}
    # The measurement itself is in memory: the name stands in for a file.
    settings["radar"] = {**settings.get("radar", {}), "file": "in memory"}
    native = _native.prepare_arrays(
        radargram_arrays(radargram),
        trajectory_arrays(trajectory),
        json.dumps(settings),
        listener(progress),
    )
    prepared = Prepared(native)
    warn_of(prepared.evidence, prepared.noticed)
    return prepared


class Prepared:
    """Clean spectra of one or more tracks at known places.

    Attributes
    ----------
    spectrum : xarray.Dataset
        ``spectrum`` (trace, frequency), ``position`` and, where stated, ``sigma`` (trace, axis).
    grid : Plane, Surface or Volume
        The pixels that the settings ask for.
    evidence : Evidence
        What was found of the settings.
    """

    def __init__(self, native: _native.Prepared) -> None:
        self._native = native

    def __reduce__(self) -> str:
        raise TypeError(
            "Prepared: expected a process to prepare spectra of its own; pickle the Campaign, or "
            "`spectrum`, which acerra.adjoint images"
        )

    @property
    def position_m(self) -> npt.NDArray[np.float64]:
        """Places of the phase centre, shape (traces, 3), m."""
        return self._native.position_m

    @property
    def frequency_hz(self) -> npt.NDArray[np.float64]:
        """Frequencies of the spectra, Hz."""
        return self._native.frequency_hz

    @property
    def light_speed_m_s(self) -> float:
        """Speed of light of the scene, m/s."""
        return self._native.light_speed_m_s

    @property
    def spectrum(self) -> xr.Dataset:
        """Spectra, places and times of the traces."""
        native = self._native
        data: dict[str, Any] = {
            "spectrum": (("trace", "frequency"), native.spectrum),
            "position": (("trace", "axis"), native.position_m, {"units": "m"}),
        }
        sigma_m = native.sigma_m
        if sigma_m is not None:
            data["sigma"] = (("trace", "axis"), sigma_m, {"units": "m"})
        coords = {
            "time": ("trace", native.time_s, {"units": "s"}),
            "number": ("trace", native.trace, {"long_name": "number of the trace in its log"}),
            "frequency": ("frequency", native.frequency_hz, {"units": "Hz"}),
            "axis": ["x", "y", "z"],
        }
        dataset = xr.Dataset(data, coords, {"light_speed_m_s": native.light_speed_m_s})
        return on_earth(dataset, native.origin_deg_m)

    @property
    def defaults(self) -> dict[str, Any]:
        """How images are made unless asked otherwise: accuracy, weight, sum, weight by incidence."""
        defaults: dict[str, Any] = json.loads(self._native.defaults)
        return defaults

    def weights(self, weight: Weight | None = None) -> npt.NDArray[np.float64]:
        """Weight of each trace in the sum, for `acerra.adjoint`; by default the settings'."""
        return self._native.weights(weight)

    @property
    def tracks(self) -> dict[str, slice]:
        """The traces of each track, by its name."""
        return {name: slice(start, end) for name, start, end in self._native.tracks}

    def settled(self, track: int = 0) -> dict[str, Any]:
        """Time offset, gate, delay and shift of a track as they were used."""
        settled: dict[str, Any] = json.loads(self._native.settled(track))
        return settled

    def radargram(
        self, kind: Literal["raw", "clean"] = "clean", track: int = 0
    ) -> xr.DataArray | None:
        """The traces of a track before or after cleaning; none where its log holds spectra."""
        arrays = self._native.radargram(track, kind)
        return None if arrays is None else radargram(**arrays)

    @property
    def grid(self) -> Grid:
        """The pixels that the settings ask for."""
        return self._native.grid

    @property
    def evidence(self) -> Evidence:
        """What was found of the settings."""
        return Evidence._from_json(self._native.findings)

    @property
    def noticed(self) -> list[str]:
        """What the stages noticed, in sentences."""
        return self._native.warnings

    def image(
        self,
        grid: Grid | None = None,
        *,
        accuracy: float | None = None,
        weight: Weight | None = None,
        sum: Sum | None = None,
        check_pixels: int | None = None,
        pulses: slice | None = None,
        progress: bool | Progress | None = None,
    ) -> xr.DataArray:
        """Image the spectra: as the settings say, unless asked otherwise.

        Parameters
        ----------
        grid : Plane, Surface or Volume, optional
            The pixels; those of the settings by default.
        accuracy : float, optional
            Relative L2 error allowed against the sum in double precision.
        weight : {"auto", "trace", "path"}, optional
            Weight of each trace.
        sum : {"coherent", "incoherent"}, optional
            What of several tracks is summed: amplitudes, or powers of their own images.
        check_pixels : int, optional
            Most pixels on which the plan checks itself.
        pulses : slice, optional
            The traces that make the image, counted over all tracks.
        progress : bool or function, optional
            As in `acerra.adjoint`.

        Returns
        -------
        xarray.DataArray of complex64
            The image over the grid's coordinates.
        """
        grid = self.grid if grid is None else checks.grid(grid)
        options = self._options(accuracy, weight, sum, check_pixels, pulses)
        values, said = self._native.image(grid, options, listener(progress))
        return image_of(values, grid, json.loads(said), self._native.origin_deg_m)

    def measure(
        self,
        grid: Grid | None = None,
        *,
        accuracy: float | None = None,
        weight: Weight | None = None,
        threshold_db: float = -12.0,
        max_targets: int = 50,
    ) -> dict[str, Any]:
        """Image the spectra, and find and measure the targets."""
        grid = self.grid if grid is None else checks.grid(grid)
        options = self._options(accuracy, weight, None, None, None)
        found: dict[str, Any] = json.loads(
            self._native.measure(grid, options, (threshold_db, max_targets), None)
        )
        return found

    def _options(
        self,
        accuracy: float | None,
        weight: str | None,
        sum: str | None,
        check_pixels: int | None,
        pulses: slice | None,
    ) -> dict[str, Any]:
        traces = len(self._native.time_s)
        chosen = None
        if pulses is not None:
            start, stop, step = pulses.indices(traces)
            if step != 1 or stop <= start:
                raise ValueError(f"pulses: expected a slice of 0 to {traces}, found {pulses}")
            chosen = (start, stop)
        return {
            "accuracy": accuracy,
            "weight": weight,
            "sum": sum,
            "check_pixels": check_pixels,
            "pulses": chosen,
        }

    def __repr__(self) -> str:
        tracks = ", ".join(f"{n}: {s.stop - s.start} traces" for n, s in self.tracks.items())
        return f"<Prepared: {tracks}; {len(self.frequency_hz)} frequencies; {self.grid!r}>"


class Run:
    """A finished run: image, targets, evidence, and what they were made of.

    A run is pickled with its results, pictures included, so that joblib and Dask hand it from one process
    to another; the spectra that it was made of (`prepared`) stay in the process that made it.
    """

    def __init__(self, native: _native.Run | Results) -> None:
        self._native = native

    def __reduce__(self) -> tuple[type[Run], tuple[Results]]:
        return Run, (Results.of(self._native),)

    @property
    def name(self) -> str:
        """What the run is called."""
        return self._native.name

    @property
    def image(self) -> xr.DataArray:
        """The image; of a volume as it is seen from above."""
        grid = self._native.grid
        pixels = grid.slice(0) if isinstance(grid, Volume) else grid
        image = self._labelled(self._native.image, pixels)
        # From above, the values of a volume come from many heights.
        return image.drop_vars("z") if isinstance(grid, Volume) else image

    def _labelled(self, values: npt.NDArray[np.complex64], grid: Grid) -> xr.DataArray:
        attrs = {"plan": self.record["plan"]}
        return image_of(values, grid, attrs, self._native.origin_deg_m)

    @property
    def volume(self) -> xr.DataArray | None:
        """The voxels; none of a plane, or where they were written to the products' directory."""
        values, grid = self._native.volume, self._native.grid
        if values is None or isinstance(grid, Surface):
            return None
        return self._labelled(values, grid)

    @property
    def grid(self) -> Grid:
        """The pixels."""
        return self._native.grid

    @property
    def prepared(self) -> Prepared:
        """The spectra that the image was made of; a run out of a pickle has none."""
        return Prepared(self._native.prepared())

    @property
    def record(self) -> dict[str, Any]:
        """``run.json``: what was done with which input, and what it cost."""
        record: dict[str, Any] = json.loads(self._native.record())
        return record

    @property
    def targets(self) -> pd.DataFrame:
        """The targets, strongest first: place, level, widths, sidelobes, ghost."""
        targets = json.loads(self._native.targets())["targets"]
        return pd.json_normalize(targets, sep="_")

    @property
    def evidence(self) -> Evidence:
        """What the run found of its own settings."""
        return Evidence._from_json(self._native.findings)

    @property
    def noticed(self) -> list[str]:
        """What the stages noticed, in sentences."""
        return self._native.warnings

    def png(
        self, kind: Literal["image", "radargram_raw", "radargram_clean"] = "image"
    ) -> bytes | None:
        """A picture of the report; none where the log holds spectra."""
        return self._native.picture(kind)

    def __repr__(self) -> str:
        return f"<Run {self.name}: {self.grid!r}, {len(self.targets)} targets, {self.evidence!r}>"

    def _repr_html_(self) -> str:
        kinds: tuple[Literal["image", "radargram_clean"], ...] = ("image", "radargram_clean")
        pictures = ((kind, self.png(kind)) for kind in kinds)
        shown = "".join(
            f'<img alt="{kind}" style="max-width:100%" '
            f'src="data:image/png;base64,{base64.b64encode(png).decode()}">'
            for kind, png in pictures
            if png is not None
        )
        targets = self.targets
        wanted = "x_m y_m z_m level_db along_rayleigh_m across_rayleigh_m pslr_db ghost_level place_deg_m"
        columns = [name for name in wanted.split() if name in targets]
        listed = targets[columns].to_html(float_format="{:.3f}".format)
        return f"{shown}{listed}{self.evidence._repr_html_()}"
