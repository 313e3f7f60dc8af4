"""Large images as jobs of independent tiles, in a Zarr store that any cluster's workers reach.

A job is the grid cut into tiles, each a chunk of the store's array ``image``. A tile is imaged with all
pulses, group by group, and written by one task in one piece; a tile that is there is not made again, so that
a job goes on after any failure where it stopped. `acerra.dask.focus` runs jobs on Dask;
``python -m acerra.jobs STORE K/N`` runs a share of one, for Slurm's arrays and Kubernetes' indexed jobs.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import itertools
import json
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _checks as checks
from . import _native
from ._checks import Grid
from ._extras import needed
from ._labelled import image_of
from ._native import SPEED_OF_LIGHT_M_S, AcerraError, Plane, Surface, Tilted, Volume
from .imaging import settings as requirements

# Tables of a tile may need finer steps than those of the tiles that were planned beforehand: twice, where the
# first choice misses the accuracy, and a little for the geometry.
MARGIN = 3
LEAST_ENGINE_BYTES = 64 << 20

GRIDS = {kind.__name__: kind for kind in (Plane, Surface, Tilted, Volume)}


class JobError(AcerraError):
    """A job that cannot be, or is not complete."""


@dataclass(frozen=True)
class Store:
    """Where a job lives: a path, or a URL of S3, Google Cloud or Azure with the store's options.

    Attributes
    ----------
    url : str
        ``/data/job.zarr``, ``s3://bucket/job.zarr``, ``gs://…``, ``az://…``.
    options : dict
        Options of the store as `obstore` names them: ``{"region": …, "endpoint": …}``, and
        ``client_options``.
    """

    url: str
    options: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, store: Store | str | os.PathLike[str]) -> Store:
        """A store from its path or URL."""
        if isinstance(store, Store):
            return store
        text = os.fspath(store)
        return cls(text if "://" in text else str(Path(text).resolve()))

    def open(self) -> Any:
        """The store as Zarr takes it."""
        from obstore.store import LocalStore, from_url
        from zarr.storage import ObjectStore

        if "://" not in self.url:
            return ObjectStore(LocalStore(self.url, mkdir=True))
        return ObjectStore(from_url(self.url, **self.options))


@dataclass(frozen=True)
class Tile:
    """A part of the grid: from index `start` to before `stop`, in the order of its shape."""

    start: tuple[int, ...]
    stop: tuple[int, ...]

    @property
    def slices(self) -> tuple[slice, ...]:
        """The part of the array that the tile fills."""
        return tuple(slice(a, b) for a, b in zip(self.start, self.stop, strict=True))


@dataclass(frozen=True)
class Job:
    """Everything that a worker needs to know of a job.

    Attributes
    ----------
    store : Store
        Where its echoes are and its image goes.
    grid_kind, grid_arguments : str, tuple
        The grid.
    chunks : tuple of int
        Shape of a tile.
    group : int
        Pulses that are imaged at once.
    accuracy, light_speed_m_s, check_pixels
        As in `acerra.adjoint`.
    engine_bytes, memory_bytes : int
        What the engine may take in a task, and what the whole task takes beside the interpreter and the
        libraries it imports.
    seconds : float
        What all tasks take together on one worker with this machine's threads, by timed samples.
    identity : str
        Digest of echoes, grid and requirements.
    """

    store: Store
    grid_kind: str
    grid_arguments: tuple[tuple[Any, ...], dict[str, Any]]
    chunks: tuple[int, ...]
    group: int
    accuracy: float
    light_speed_m_s: float
    check_pixels: int
    engine_bytes: int
    memory_bytes: int
    seconds: float = field(compare=False)
    identity: str

    @property
    def grid(self) -> Grid:
        """The pixels."""
        positional, named = self.grid_arguments
        if self.grid_kind == "Surface":
            *ranges, heights = positional
            positional = (*ranges, np.asarray(heights, dtype=np.float64))
        grid: Grid = GRIDS[self.grid_kind](*positional, **named)
        return grid

    @property
    def tiles(self) -> list[Tile]:
        """The tiles, in the order of the store's chunks."""
        shape = self.grid.shape
        starts = (range(0, n, c) for n, c in zip(shape, self.chunks, strict=True))
        return [
            Tile(
                start,
                tuple(min(a + c, n) for a, c, n in zip(start, self.chunks, shape, strict=True)),
            )
            for start in itertools.product(*starts)
        ]

    def missing(self) -> list[Tile]:
        """The tiles that the store does not hold."""
        held = set(_chunk_keys(self.store))
        return [tile for tile in self.tiles if _chunk_key(tile, self.chunks) not in held]

    def to_json(self) -> str:
        """The job as the store keeps it: without the store's own address and keys."""
        fields = {key: value for key, value in asdict(self).items() if key != "store"}
        return json.dumps(fields, default=lambda value: np.asarray(value).tolist())

    @classmethod
    def from_json(cls, text: str, store: Store) -> Job:
        """A job as a store keeps it."""
        fields = json.loads(text)
        fields["store"] = store
        fields["chunks"] = tuple(fields["chunks"])
        positional, named = fields["grid_arguments"]
        fields["grid_arguments"] = (tuple(positional), named)
        return cls(**fields)


def _chunk_key(tile: Tile, chunks: Sequence[int]) -> str:
    numbers = (a // c for a, c in zip(tile.start, chunks, strict=True))
    return "image/c/" + "/".join(map(str, numbers))


def _is_made(job: Job, tile: Tile) -> bool:
    """Whether the store holds a tile."""
    try:
        job.store.open().store.head(_chunk_key(tile, job.chunks))
    except FileNotFoundError:
        return False
    return True


def _chunk_keys(store: Store) -> Iterator[str]:
    opened = store.open().store
    for listed in opened.list(prefix="image/c/"):
        yield from (entry["path"] for entry in listed)


def plan(
    position_m: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    spectrum: npt.ArrayLike,
    grid: Grid,
    *,
    store: Store | str | os.PathLike[str],
    weight: npt.ArrayLike | None = None,
    chunks: Sequence[int] | None = None,
    group: int | None = None,
    memory_limit_bytes: int = 2 << 30,
    accuracy: float = 1e-3,
    check_pixels: int = 256,
    light_speed_m_s: float = SPEED_OF_LIGHT_M_S,
) -> Job:
    """Plan a job and put its echoes into the store; one that is there already goes on.

    Parameters
    ----------
    position_m, frequency_hz, spectrum, grid, weight
        As in `acerra.adjoint`.
    store : Store or path
        Where the job lives.
    chunks : sequence of int, optional
        Shape of a tile; by default whole slices of a volume, or squares of 1024 pixels.
    group : int, optional
        Pulses that are imaged at once; by default as many as the memory lets.
    memory_limit_bytes : int
        Most that a task may take beside the interpreter and the libraries it imports.
    accuracy, check_pixels, light_speed_m_s
        As in `acerra.adjoint`. Each group of pulses keeps the accuracy against its own sum.

    Returns
    -------
    Job
        With the memory that each task takes (``memory_bytes``) and the time of all (``seconds``).

    Raises
    ------
    JobError
        A store that holds another job; tiles that do not fit the memory.
    """
    antennas = checks.antennas(position_m, frequency_hz, weight)
    echoes = checks.complex_matrix("spectrum", spectrum)
    place = Store.of(store)
    shape = checks.grid(grid).shape
    tile_shape = tuple(chunks) if chunks is not None else _default_chunks(shape)
    if len(tile_shape) != len(shape) or min(tile_shape) < 1:
        raise JobError(f"chunks: expected {len(shape)} positive numbers, found {tile_shape}")
    tile_shape = tuple(min(c, n) for c, n in zip(tile_shape, shape, strict=True))
    tiles = math.prod(math.ceil(n / c) for n, c in zip(shape, tile_shape, strict=True))
    pulses = len(echoes)
    group = pulses if group is None else min(group, pulses)
    wanted = requirements(
        accuracy=accuracy, check_pixels=check_pixels, light_speed_m_s=light_speed_m_s
    )
    samples = _sample_tiles(grid, tile_shape)
    tile_bytes = 8 * math.prod(tile_shape)
    while True:
        parts = (slice(0, group), slice(pulses - group, pulses))
        said = [
            json.loads(_native.promise(tile, _chosen(antennas, part), echoes[part], wanted))
            for tile in samples
            for part in (parts if group < pulses else parts[:1])
        ]
        # The engine's tables and image, the echoes as they are read and a group of them, the sum of the
        # groups, and the chunk on its way to the store.
        engine = max(LEAST_ENGINE_BYTES, MARGIN * max(one["memory_bytes"] for one in said))
        sums = 2 * tile_bytes if group < pulses else 0
        needed = engine + echoes.nbytes + 16 * group * echoes.shape[1] + sums + 2 * tile_bytes
        if needed <= memory_limit_bytes:
            break
        if group <= 32:
            raise JobError(
                f"a tile of {tile_shape} pixels needs {needed} bytes, {memory_limit_bytes} are allowed: "
                "choose smaller chunks or allow more"
            )
        group = math.ceil(group / 2)
    seconds = sum(one["seconds"] for one in said) / len(said)
    kind = type(grid).__name__
    arguments = grid.__getnewargs_ex__()
    digest = hashlib.sha256()
    heights = [value for value in arguments[0] if isinstance(value, np.ndarray)]
    for array in (*antennas.values(), echoes, *heights):
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).data)
    # Heights are told by their bytes: NumPy shortens the text of large arrays.
    named = [value for value in arguments[0] if not isinstance(value, np.ndarray)]
    grid_stated = (kind, named, arguments[1])
    stated = (*grid_stated, tile_shape, group, accuracy, check_pixels, light_speed_m_s)
    digest.update(repr(stated).encode())
    job = Job(
        store=place,
        grid_kind=kind,
        grid_arguments=arguments,
        chunks=tile_shape,
        group=group,
        accuracy=accuracy,
        light_speed_m_s=light_speed_m_s,
        check_pixels=check_pixels,
        memory_bytes=int(needed),
        seconds=seconds * tiles * math.ceil(pulses / group),
        engine_bytes=int(engine),
        identity=digest.hexdigest(),
    )
    _lay_out(job, antennas, echoes)
    return job


def _chosen(antennas: Mapping[str, Any], part: slice) -> dict[str, Any]:
    """Some of the pulses."""
    return {
        "position_m": antennas["position_m"][part],
        "frequency_hz": antennas["frequency_hz"],
        "weight": antennas["weight"][part],
    }


def _sample_tiles(grid: Grid, chunks: tuple[int, ...]) -> list[Grid]:
    """The first, the middle and the last tile."""
    places = []
    for share in (0.0, 0.5, 1.0):
        counts = (math.ceil(n / c) for n, c in zip(grid.shape, chunks, strict=True))
        start = tuple(c * round(share * (k - 1)) for c, k in zip(chunks, counts, strict=True))
        places.append(start)
    return [
        _native.part_of(
            grid, start, [min(a + c, n) for a, c, n in zip(start, chunks, grid.shape, strict=True)]
        )
        for start in dict.fromkeys(places)
    ]


def _default_chunks(shape: tuple[int, ...]) -> tuple[int, ...]:
    if len(shape) == 2:
        return (1024, 1024)
    plane = shape[1] * shape[2]
    # Whole slices, as the engine images them: 16 MB a chunk.
    return (max(1, min(shape[0], (2 << 20) // plane)), shape[1], shape[2])


def _lay_out(job: Job, antennas: Mapping[str, Any], echoes: npt.NDArray[np.complex128]) -> None:
    """Arrays, coordinates and echoes of a job, unless they are there."""
    zarr = needed("zarr", "dask", "acerra.jobs")

    opened = job.store.open()
    try:
        held = zarr.open_group(opened, mode="r").attrs.get("job")
    except FileNotFoundError:
        held = None
    if held is not None:
        found = Job.from_json(str(held), job.store).identity
        if found != job.identity:
            raise JobError(
                f"{job.store.url}: expected job {job.identity[:12]}, found another, {found[:12]}; "
                "name another store, or remove it"
            )
        return
    group = zarr.create_group(opened)
    # The labels of a volume's or plane's axes do not need its values.
    empty = np.broadcast_to(np.complex64(0), job.grid.shape)
    labelled = image_of(empty, job.grid, {})
    for name, coordinate in labelled.coords.items():
        group.create_array(
            str(name),
            data=np.asarray(coordinate.values),
            attributes=dict(coordinate.attrs),
            dimension_names=[str(dim) for dim in coordinate.dims],
        )
    group.create_array(
        "image",
        shape=job.grid.shape,
        chunks=job.chunks,
        dtype=np.complex64,
        fill_value=complex("nan+nanj"),
        dimension_names=[str(dim) for dim in labelled.dims],
        attributes={"long_name": "reflectivity", "coordinates": "x y z"},
        config={"write_empty_chunks": True},
    )
    stored = group.create_group("echoes")
    for name, array in {**antennas, "spectrum": echoes}.items():
        stored.create_array(name, data=np.asarray(array))
    # Last: a store without it is not a job yet.
    group.attrs["job"] = job.to_json()


def open_job(store: Store | str | os.PathLike[str]) -> Job:
    """The job that a store holds."""
    zarr = needed("zarr", "dask", "acerra.jobs")

    place = Store.of(store)
    try:
        held = zarr.open_group(place.open(), mode="r").attrs.get("job")
    except FileNotFoundError:
        held = None
    if held is None:
        raise JobError(f"{place.url}: expected a job, found none")
    return Job.from_json(str(held), place)


@functools.lru_cache(maxsize=1)
def _echoes(url: str, options: str, identity: str) -> dict[str, npt.NDArray[Any]]:
    """The echoes of a job, read once by each process."""
    zarr = needed("zarr", "dask", "acerra.jobs")

    stored = zarr.open_group(Store(url, json.loads(options)).open(), mode="r")["echoes"]
    assert isinstance(stored, zarr.Group)
    return {str(name): np.asarray(array[...]) for name, array in stored.arrays()}


def image_tile(job: Job, tile: Tile, threads: int | None = None) -> dict[str, Any]:
    """Image a tile and write it; one that is there is left.

    Returns
    -------
    dict
        ``tile``, ``made`` (whether it was not there), and ``checked_error`` of the plans.
    """
    zarr = needed("zarr", "dask", "acerra.jobs")

    if threads is not None:
        _native.set_threads(threads)
    if _is_made(job, tile):
        return {"tile": tile.start, "made": False, "checked_error": None}
    echoes = _echoes(job.store.url, json.dumps(dict(job.store.options)), job.identity)
    grid = _native.part_of(job.grid, tile.start, tile.stop)
    # As many pixels of each slice check themselves as in one run over all slices.
    share = tile.stop[0] - tile.start[0] if isinstance(grid, Volume) else 1
    whole = job.grid.shape[0] if isinstance(grid, Volume) else 1
    wanted = requirements(
        accuracy=job.accuracy,
        check_pixels=max(8, job.check_pixels // whole) * share,
        light_speed_m_s=job.light_speed_m_s,
        memory_limit_bytes=job.engine_bytes,
    )
    pulses = len(echoes["spectrum"])
    groups = [slice(k, min(k + job.group, pulses)) for k in range(0, pulses, job.group)]
    errors = []
    total: npt.NDArray[Any] | None = None
    for chosen in groups:
        spectrum = echoes["spectrum"][chosen]
        image, said = _native.adjoint(grid, _chosen(echoes, chosen), spectrum, wanted, None)
        errors.append(json.loads(said)["checked_error"])
        if len(groups) == 1:
            total = image
        elif total is None:
            total = image.astype(np.complex128)
        else:
            total += image
    array = zarr.open_group(job.store.open(), mode="r+")["image"]
    assert isinstance(array, zarr.Array)
    assert total is not None
    array.with_config({"write_empty_chunks": True})[tile.slices] = total
    checked = [error for error in errors if error is not None]
    return {"tile": tile.start, "made": True, "checked_error": max(checked, default=None)}


def finish(job: Job) -> None:
    """Check that every tile is there, and mark the store as complete.

    Raises
    ------
    JobError
        Tiles are missing.
    """
    zarr = needed("zarr", "dask", "acerra.jobs")

    missing = job.missing()
    if missing:
        raise JobError(
            f"{job.store.url}: {len(missing)} of {len(job.tiles)} tiles are missing, the first at "
            f"{missing[0].start}"
        )
    group = zarr.open_group(job.store.open(), mode="r+")
    group.attrs["complete"] = True


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a share of a job, or checks that it is complete."""
    parser = argparse.ArgumentParser(prog="python -m acerra.jobs", description=main.__doc__)
    parser.add_argument("store", help="path or URL of the job")
    parser.add_argument("share", help="K/N: every Nth tile from the Kth, counted from 1; or finish")
    parser.add_argument("--options", default="{}", help="options of the store, as JSON")
    parser.add_argument("--threads", type=int, help="threads of this process")
    given = parser.parse_args(arguments)
    try:
        job = open_job(Store(Store.of(given.store).url, json.loads(given.options)))
        if given.share == "finish":
            finish(job)
            return 0
        number, _, of = given.share.partition("/")
        if not (number.isdigit() and of.isdigit() and 1 <= int(number) <= int(of)):
            raise JobError(
                f"share: expected K/N with K from 1 to N, or finish, found {given.share}"
            )
        for tile in job.tiles[int(number) - 1 :: int(of)]:
            image_tile(job, tile, given.threads)
    except (AcerraError, OSError, ValueError) as error:
        print(f"acerra.jobs: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
