"""Jobs of tiles: complete, resumable, on a cluster whose workers and store fail."""

from __future__ import annotations

import dataclasses
import http.client
import http.server
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import acerra
import numpy as np
import pytest

pytest.importorskip("zarr")
pytest.importorskip("obstore")

from acerra import jobs  # noqa: E402

PLANE = acerra.Plane([1, 2.5], [-0.8, 0.8], pixel_m=0.02)
VOLUME = acerra.Volume([1, 2], [-0.5, 0.5], [-0.2, 0.21], pixel_m=0.02, step_m=0.02)


def arrays(echoes: Any) -> tuple[Any, Any, Any]:
    return echoes.position_m, echoes.frequency_hz, echoes.spectrum


def image_in(store: Any) -> np.ndarray:
    from acerra.dask import open_image

    return np.asarray(open_image(store)["image"].values)


def test_tiles_cover_a_grid_once(echoes: Any, tmp_path: Path) -> None:
    job = jobs.plan(*arrays(echoes), PLANE, store=tmp_path / "job.zarr", chunks=(30, 32))
    counted = np.zeros(PLANE.shape, int)
    for tile in job.tiles:
        counted[tile.slices] += 1
    assert (counted == 1).all() and len(job.tiles) == 9


@pytest.mark.parametrize("grid", [PLANE, VOLUME], ids=["plane", "volume"])
@pytest.mark.parametrize("group", [None, 20])
def test_shares_of_a_job_make_the_image(
    echoes: Any, tmp_path: Path, grid: Any, group: int | None
) -> None:
    store = tmp_path / "job.zarr"
    chunks = (30, 32) if grid is PLANE else (4, 51, 51)
    job = jobs.plan(*arrays(echoes), grid, store=store, chunks=chunks, group=group, accuracy=1e-5)
    with pytest.raises(jobs.JobError, match="tiles are missing, the first at"):
        jobs.finish(job)
    for share in ("1/2", "2/2"):
        assert jobs.main([str(store), share, "--threads", "2"]) == 0
    assert jobs.main([str(store), "finish"]) == 0
    whole = acerra.adjoint(*arrays(echoes), grid, accuracy=1e-5).values
    found = image_in(store)
    difference = np.linalg.norm(found - whole) / np.linalg.norm(whole)
    # Slices are imaged as in one run; squares of a plane and groups are planned by themselves.
    assert difference < (1e-6 if grid is VOLUME and group is None else 3e-5)


def test_a_job_goes_on_where_it_stopped(echoes: Any, tmp_path: Path) -> None:
    store = tmp_path / "job.zarr"
    job = jobs.plan(*arrays(echoes), PLANE, store=store, chunks=(40, 40))
    for tile in job.tiles[:2]:
        assert jobs.image_tile(job, tile)["made"]
    again = jobs.plan(*arrays(echoes), PLANE, store=store, chunks=(40, 40))
    assert again == job
    assert [t.start for t in again.missing()] == [t.start for t in job.tiles[2:]]
    assert not jobs.image_tile(again, job.tiles[0])["made"]
    with pytest.raises(jobs.JobError, match="expected job .* found another"):
        jobs.plan(*arrays(echoes), PLANE, store=store, chunks=(40, 40), accuracy=1e-4)
    with pytest.raises(jobs.JobError, match="expected a job, found none"):
        jobs.open_job(tmp_path / "empty.zarr")


def test_jobs_over_other_terrain_are_other_jobs(echoes: Any, tmp_path: Path) -> None:
    heights = np.zeros((81, 76))
    flat = acerra.Surface([1, 2.5], [-0.8, 0.8], heights, pixel_m=0.02)
    heights[40, 40] = 0.05
    hill = acerra.Surface([1, 2.5], [-0.8, 0.8], heights, pixel_m=0.02)
    jobs.plan(*arrays(echoes), flat, store=tmp_path / "job.zarr")
    with pytest.raises(jobs.JobError, match="found another"):
        jobs.plan(*arrays(echoes), hill, store=tmp_path / "job.zarr")


def test_keys_of_a_store_are_not_kept_in_it(echoes: Any, tmp_path: Path) -> None:
    job = jobs.plan(*arrays(echoes), PLANE, store=tmp_path / "job.zarr")
    secret = jobs.Store(job.store.url, {"config": {"secret_access_key": "hidden"}})
    text = dataclasses.replace(job, store=secret).to_json()
    assert "hidden" not in text and "store" not in json.loads(text)
    assert jobs.Job.from_json(text, job.store) == job


def test_memory_is_promised_and_bounds_the_groups(echoes: Any, tmp_path: Path) -> None:
    places, frequencies, spectrum = arrays(echoes)
    # 12,200 pulses, whose tables fill some hundred megabytes.
    many = np.tile(places, (200, 1)), frequencies, np.tile(spectrum, (200, 1))
    free = jobs.plan(*many, PLANE, store=tmp_path / "free.zarr")
    assert free.group == len(many[0]) and free.seconds > 0
    allowed = int(0.8 * free.memory_bytes)
    tight = jobs.plan(*many, PLANE, store=tmp_path / "tight.zarr", memory_limit_bytes=allowed)
    assert tight.group < free.group and tight.memory_bytes <= allowed
    with pytest.raises(jobs.JobError, match="choose smaller chunks or allow more"):
        jobs.plan(*many, PLANE, store=tmp_path / "no.zarr", memory_limit_bytes=100_000)


def test_errors_of_the_command_are_one_line(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "acerra.jobs", str(tmp_path / "none.zarr"), "1/2"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert "expected a job, found none" in ended.stderr and "Traceback" not in ended.stderr


class FailingStore(http.server.BaseHTTPRequestHandler):
    """Hands requests on to the real store, and refuses some of the chunks."""

    upstream = ("127.0.0.1", 0)
    refuse_chunks: list[int] = []
    chunks = 0
    lock = threading.Lock()

    def _forward(self) -> None:
        length = int(self.headers.get("content-length") or 0)
        body = self.rfile.read(length)
        if self.command == "PUT" and "/image/c/" in self.path:
            with self.lock:
                type(self).chunks += 1
                refused = self.chunks in self.refuse_chunks
            if refused:
                self.send_response(400)
                self.send_header("content-length", "0")
                self.end_headers()
                return
        upstream = http.client.HTTPConnection(*self.upstream)
        upstream.request(self.command, self.path, body, dict(self.headers))
        answer = upstream.getresponse()
        content = answer.read()
        self.send_response(answer.status)
        for name, value in answer.getheaders():
            if name.lower() not in ("transfer-encoding", "connection", "content-length"):
                self.send_header(name, value)
        stated = answer.getheader("content-length") if self.command == "HEAD" else len(content)
        self.send_header("content-length", str(stated))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    do_GET = do_PUT = do_POST = do_HEAD = do_DELETE = _forward

    def log_message(self, *_: Any) -> None:
        """Says nothing."""


@pytest.fixture()
def bucket() -> Iterator[jobs.Store]:
    """A bucket of an S3 server on the loopback interface that refuses two chunks."""
    moto = pytest.importorskip("moto.server")
    s3 = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    s3.start()
    port = s3.get_host_and_port()[1]
    FailingStore.upstream, FailingStore.chunks = ("127.0.0.1", port), 0
    FailingStore.refuse_chunks = [3, 7]
    proxy = http.server.ThreadingHTTPServer(("127.0.0.1", 0), FailingStore)
    threading.Thread(target=proxy.serve_forever, daemon=True).start()
    creation = http.client.HTTPConnection("127.0.0.1", port)
    creation.request("PUT", "/flights", headers={"Host": f"127.0.0.1:{port}"})
    assert creation.getresponse().status == 200
    config = {
        "endpoint": f"http://127.0.0.1:{proxy.server_port}",
        "access_key_id": "testing",
        "secret_access_key": "testing",
        "region": "us-east-1",
    }
    options = {"config": config, "client_options": {"allow_http": True}}
    yield jobs.Store("s3://flights/job.zarr", options)
    proxy.shutdown()
    s3.stop()


def peak_bytes() -> int:
    """Most memory that this process has held; 0 where the system does not tell."""
    # getrusage counts what the process held that this one was forked from.
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.is_file() else []
    found = [int(line.split()[1]) for line in lines if line.startswith("VmHWM:")]
    return 1024 * max(found, default=0)


# 512³ voxels and 2,000 pulses take minutes: with ACERRA_SLOW=1.
SIZE = (512, 2000) if os.environ.get("ACERRA_SLOW") else (64, 120)


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_whose_workers_and_store_fail(bucket: jobs.Store, tmp_path: Path) -> None:
    distributed = pytest.importorskip("dask.distributed")
    from acerra.dask import WORKER_BYTES, focus_arrays, open_image

    voxels, pulses = SIZE
    random = np.random.default_rng(2)
    y = np.linspace(-4, 4, pulses)
    position_m = np.column_stack([0.1 * np.sin(y), y, 6 + 0.05 * random.normal(size=pulses)])
    frequency_hz = np.linspace(3.1e9, 4.8e9, 86)
    distance = np.linalg.norm(position_m - [2.0, 0.1, 0.2], axis=1)[:, None]
    wave = -4 * np.pi * frequency_hz / acerra.SPEED_OF_LIGHT_M_S
    spectrum = np.exp(1j * distance * wave) / distance**2
    spectrum += 0.01 * (
        random.normal(size=spectrum.shape) + 1j * random.normal(size=spectrum.shape)
    )
    step = 2.0 / (voxels - 1)
    grid = acerra.Volume([1, 3], [-1, 1], [-0.5, 1.5], pixel_m=step, step_m=step)
    assert grid.shape == (voxels,) * 3

    heard: list[tuple[str, int, int]] = []
    killed: list[int] = []
    with (
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            memory_limit="2GiB",
            local_directory=str(tmp_path),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):

        def progress(step: str, done: int, total: int) -> None:
            heard.append((step, done, total))
            if len(killed) < 2 and done >= (len(killed) + 1) * total // 4:
                workers = client.run(os.getpid)
                victim = next(pid for pid in workers.values() if pid not in killed)
                killed.append(victim)
                os.kill(victim, signal.SIGKILL)

        begin = time.monotonic()
        made = focus_arrays(
            position_m,
            frequency_hz,
            spectrum,
            grid,
            client=client,
            store=bucket,
            chunks=(4, voxels, voxels),
            memory_limit_bytes=1 << 30,
            progress=progress,
        )
        seconds = time.monotonic() - begin
        peaks = client.run(peak_bytes)
    assert len(killed) == 2
    promised = WORKER_BYTES + jobs.open_job(bucket).memory_bytes
    assert max(peaks.values()) <= promised, f"{peaks}, promised {promised}"
    assert FailingStore.chunks >= 7, "the store has refused twice"
    tiles = voxels // 4
    assert heard[-1] == ("tiles", tiles, tiles)
    listed = [e["path"] for part in bucket.open().store.list(prefix="image/c/") for e in part]
    assert len(listed) == len(set(listed)) == tiles

    begin = time.monotonic()
    whole = acerra.adjoint(position_m, frequency_hz, spectrum, grid).values
    alone_seconds = time.monotonic() - begin
    found = np.asarray(made["image"].values)
    assert np.isfinite(found).all()
    assert np.linalg.norm(found - whole) <= 1e-6 * np.linalg.norm(whole)
    assert open_image(bucket)["z"].attrs["units"] == "m"
    peak = max(peaks.values())
    said = {"cluster_s": seconds, "alone_s": alone_seconds, "peak": peak, "promised": promised}
    print(json.dumps(said))


@pytest.mark.filterwarnings("ignore")
def test_tasks_that_do_not_fit_the_workers_are_refused(echoes: Any, tmp_path: Path) -> None:
    distributed = pytest.importorskip("dask.distributed")
    from acerra.dask import focus_arrays

    with (
        distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            dashboard_address=None,
            memory_limit="200MiB",
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        with pytest.raises(jobs.JobError, match="choose smaller chunks"):
            focus_arrays(*arrays(echoes), PLANE, client=client, store=tmp_path / "job.zarr")


@pytest.mark.filterwarnings("ignore")
def test_a_survey_is_imaged_as_its_settings_say(demo: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("dask.distributed")
    from acerra.dask import focus

    tables = acerra.Campaign.read(demo / "campaign.toml").tables
    tables["image"] = {"x_m": [3, 5], "y_m": [-1, 1], "pixel_m": 0.05, "accuracy": 1e-4}
    prepared = acerra.Campaign.of(tables).prepare()
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        made = focus(
            prepared, prepared.grid, client=client, store=tmp_path / "a.zarr", chunks=(20, 41)
        )
        whole = prepared.image().values
        difference = np.linalg.norm(made["image"].values - whole) / np.linalg.norm(whole)
        assert difference < 2e-4
        tables["image"]["max_incidence_deg"] = 40.0
        weighted = acerra.Campaign.of(tables).prepare()
        with pytest.raises(jobs.JobError, match="without weights by incidence"):
            focus(weighted, weighted.grid, client=client, store=tmp_path / "b.zarr")
