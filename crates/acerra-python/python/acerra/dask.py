"""Large images on a Dask cluster, into a Zarr store."""

from __future__ import annotations

import os
from typing import Any

import numpy.typing as npt
import xarray as xr

from . import jobs
from ._checks import Grid
from ._extras import needed
from ._progress import Progress, listener
from .campaigns import Prepared, Weight
from .jobs import Job, JobError, Store

# What a worker holds before its first task: the interpreter, Dask, NumPy, Zarr and Acerra.
WORKER_BYTES = 300 << 20


def focus(
    survey: Prepared,
    grid: Grid,
    *,
    client: Any,
    store: Store | str | os.PathLike[str],
    weight: Weight | None = None,
    progress: bool | Progress | None = None,
    retries: int = 10,
    **options: Any,
) -> xr.Dataset:
    """Image prepared spectra on a cluster.

    Parameters
    ----------
    survey : Prepared
        Spectra of one or more tracks.
    grid : Plane, Surface or Volume
        The pixels.
    client : dask.distributed.Client
        The cluster.
    store : Store or path
        Where image and echoes go; every worker must reach it. A job that is there goes on.
    weight : {"auto", "trace", "path"}, optional
        Weight of each trace; the settings' by default.
    progress : bool or function, optional
        As in `acerra.adjoint`; its units are tiles.
    retries : int
        How often a task is tried again, when a worker or the store fails.
    **options
        `chunks`, `group`, `memory_limit_bytes`, `accuracy`, `check_pixels` of `acerra.jobs.plan`.

    Returns
    -------
    xarray.Dataset
        The store, opened; ``image`` is read as it is used.

    Raises
    ------
    JobError
        Tasks that do not fit the workers' memory; a store that holds another job; settings that jobs do
        not follow (weights by incidence, sums of powers, methods other than the adjoint).
    """
    defaults = survey.defaults
    is_power_sum = defaults["sum"] == "incoherent" and len(survey.tracks) > 1
    if defaults["weighs_incidence"] or is_power_sum or defaults["method"] != "adjoint":
        raise JobError(
            "jobs of tiles make the adjoint's coherent sum without weights by incidence; the settings ask "
            f"for {defaults}"
        )
    options.setdefault("accuracy", defaults["accuracy"])
    spectrum = survey.spectrum
    job = jobs.plan(
        survey.position_m,
        survey.frequency_hz,
        spectrum["spectrum"].values,
        grid,
        store=store,
        weight=survey.weights(weight),
        light_speed_m_s=survey.light_speed_m_s,
        **options,
    )
    run(job, client=client, progress=progress, retries=retries)
    return open_image(job.store)


def focus_arrays(
    position_m: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    spectrum: npt.ArrayLike,
    grid: Grid,
    *,
    client: Any,
    store: Store | str | os.PathLike[str],
    progress: bool | Progress | None = None,
    retries: int = 10,
    **options: Any,
) -> xr.Dataset:
    """Image spectra in arrays on a cluster; arguments as in `acerra.jobs.plan` and `focus`."""
    job = jobs.plan(position_m, frequency_hz, spectrum, grid, store=store, **options)
    run(job, client=client, progress=progress, retries=retries)
    return open_image(job.store)


def run(
    job: Job,
    *,
    client: Any,
    progress: bool | Progress | None = None,
    retries: int = 10,
) -> None:
    """Run the tiles of a job that are not there yet, and check that all are."""
    as_completed = needed("dask.distributed", "dask", "acerra.dask").as_completed

    _check_memory(job, client)
    tell = listener(progress)
    missing, all_tiles = job.missing(), len(job.tiles)
    done = all_tiles - len(missing)
    futures = [
        client.submit(
            _image_tile,
            job,
            tile,
            # Echoes of one job at a time are held by a worker: another try is another task.
            key=f"acerra-{job.identity[:16]}-{'-'.join(map(str, tile.start))}",
            retries=retries,
            pure=False,
        )
        for tile in missing
    ]
    try:
        for future in as_completed(futures):
            future.result()
            done += 1
            if tell is not None:
                tell("tiles", done, all_tiles)
    except BaseException:
        client.cancel(futures)
        raise
    jobs.finish(job)


def _image_tile(job: Job, tile: jobs.Tile) -> dict[str, Any]:
    """A tile, by as many threads as the worker has."""
    from dask.distributed import get_worker

    return jobs.image_tile(job, tile, get_worker().state.nthreads)


def _check_memory(job: Job, client: Any) -> None:
    """Refuses a job whose tasks do not fit the workers' memory."""
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        limit = worker["memory_limit"]
        # A worker runs as many tasks at once as it has threads; they share the echoes.
        needed = WORKER_BYTES + worker["nthreads"] * job.memory_bytes
        if limit and needed > limit:
            raise JobError(
                f"worker {address}: {worker['nthreads']} tasks at once need {needed} bytes, its limit is "
                f"{limit}: choose smaller chunks, a smaller group, or fewer threads a worker"
            )


def open_image(store: Store | str | os.PathLike[str]) -> xr.Dataset:
    """The image of a store, as xarray reads it."""
    place = Store.of(store)
    opened: xr.Dataset = xr.open_zarr(
        place.open(), consolidated=False, zarr_format=3, chunks=None, mask_and_scale=False
    )
    return opened
