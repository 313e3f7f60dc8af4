"""Wrong and unusual arguments: exceptions that say what was expected, or right results."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
import time
from typing import Any

import acerra
import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

GRID = acerra.Plane([1, 1.4], [0, 0.4], pixel_m=0.1)


def image(echoes: Any, **changed: Any) -> xr.DataArray:
    arguments = {
        "position_m": echoes.position_m,
        "frequency_hz": echoes.frequency_hz,
        "spectrum": echoes.spectrum,
        "grid": GRID,
        **changed,
    }
    return acerra.adjoint(**arguments)


def test_byte_order_stride_and_protection_change_nothing(echoes: Any) -> None:
    expected = image(echoes).values
    swapped = echoes.spectrum.astype(">c16")
    strided = np.repeat(echoes.spectrum, 2, axis=1)[:, ::2]
    column_major = np.asfortranarray(echoes.spectrum)
    protected = echoes.spectrum.copy()
    protected.flags.writeable = False
    labelled = xr.DataArray(echoes.spectrum, dims=("trace", "frequency"))
    for spectrum in (swapped, strided, column_major, protected, labelled):
        assert np.array_equal(image(echoes, spectrum=spectrum).values, expected)
    reversed_twice = echoes.position_m[::-1][::-1].astype(">f8")
    assert np.array_equal(image(echoes, position_m=reversed_twice).values, expected)


class Lent:
    """An array of another library that only lends its buffer."""

    def __init__(self, array: Any, refused: str | None = None) -> None:
        self.array, self.refused = array, refused

    def __dlpack__(self, **wanted: Any) -> Any:
        if self.refused is not None:
            raise BufferError(self.refused)
        return self.array.__dlpack__(**wanted)

    def __dlpack_device__(self) -> tuple[int, int]:
        device: tuple[int, int] = self.array.__dlpack_device__()
        return device


def test_lent_buffers_are_taken(echoes: Any) -> None:
    expected = image(echoes).values
    lent = image(echoes, spectrum=Lent(echoes.spectrum), position_m=Lent(echoes.position_m))
    assert np.array_equal(lent.values, expected)
    assert np.array_equal(np.from_dlpack(lent.values), expected)
    with pytest.raises(TypeError, match="spectrum: expected an array in the processor's memory.*GPU"):
        image(echoes, spectrum=Lent(echoes.spectrum, "on the GPU"))


@pytest.mark.parametrize("library", ["torch", "jax.numpy"])
def test_tensors_are_taken(echoes: Any, library: str) -> None:
    tensors = pytest.importorskip(library)
    spectrum = tensors.asarray(echoes.spectrum)
    # JAX keeps single precision unless told otherwise.
    made, expected = image(echoes, spectrum=spectrum).values, image(echoes).values
    assert np.linalg.norm(made - expected) < 1e-5 * np.linalg.norm(expected)


@pytest.mark.parametrize(
    ("changed", "kind", "message"),
    [
        ({"position_m": np.zeros((61, 2))}, ValueError, r"position_m: expected shape \(n, 3\)"),
        ({"position_m": np.zeros(3)}, ValueError, "position_m: expected 2 dimensions"),
        ({"position_m": np.zeros((61, 3), complex)}, TypeError, "expected real numbers"),
        ({"position_m": [["a", "b", "c"]]}, TypeError, "expected real numbers, found dtype"),
        ({"position_m": np.full((61, 3), np.nan)}, acerra.ImagingError, "position_m"),
        ({"frequency_hz": np.zeros(86)}, acerra.ImagingError, "frequency_hz.*above 0 Hz"),
        ({"frequency_hz": np.full(85, 1e9)}, ValueError, r"spectrum: expected shape \[61, 85\]"),
        ({"spectrum": np.zeros((86, 61))}, ValueError, r"spectrum: expected shape \[61, 86\]"),
        ({"spectrum": np.full((61, 86), np.inf)}, acerra.ImagingError, "spectrum"),
        ({"weight": np.ones(60)}, ValueError, r"weight: expected shape \(61,\)"),
        ({"accuracy": 0.0}, acerra.ImagingError, "accuracy"),
        ({"memory_limit_bytes": 10}, acerra.ImagingError, "10 bytes|memory"),
        ({"light_speed_m_s": -1.0}, acerra.ImagingError, "light_speed_m_s.*above 0"),
        ({"grid": "plane"}, TypeError, "grid: expected acerra.Plane.*found str"),
        ({"grid": {"x_m": [0, 1]}}, TypeError, "grid: expected acerra.Plane.*found dict"),
    ],
)
def test_what_cannot_be_is_named(
    echoes: Any, changed: dict[str, Any], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        image(echoes, **changed)


def test_units_are_compared_with_those_of_the_names(echoes: Any) -> None:
    gigahertz = xr.DataArray(echoes.frequency_hz / 1e9, attrs={"units": "GHz"})
    with pytest.raises(ValueError, match='frequency_hz: expected units "Hz", found "GHz"'):
        image(echoes, frequency_hz=gigahertz)


def test_frequencies_in_other_units_are_refused(echoes: Any) -> None:
    for scale in (1e9, 1e6):
        with pytest.raises(ValueError, match="frequency_hz: expected frequencies in Hz"):
            image(echoes, frequency_hz=echoes.frequency_hz / scale)
        with pytest.raises(ValueError, match="frequency_hz: expected frequencies in Hz"):
            acerra.PointSpread(echoes.position_m, echoes.frequency_hz / scale)
    with pytest.raises(ValueError, match="band_hz: expected frequencies in Hz.*found 3.1;"):
        acerra.resolution(10, 2, band_hz=(3.1, 4.8))


def test_packages_that_are_missing_are_named(
    echoes: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("tqdm", "tqdm.auto", "matplotlib", "matplotlib.pyplot", "zarr"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=r"tqdm, which.*pip install 'acerra\[progress\]'"):
        image(echoes, progress=True)
    with pytest.raises(ImportError, match=r"matplotlib, which.*pip install 'acerra\[plot\]'"):
        acerra.plot.image(image(echoes))
    from acerra import jobs

    with pytest.raises(ImportError, match=r"zarr, which.*pip install 'acerra\[dask\]'"):
        jobs.open_job("no-such-store")


def test_times_that_go_back_are_refused() -> None:
    with pytest.raises(ValueError, match=r"time_s: expected increasing times.*index 2"):
        acerra.trajectory(np.zeros((3, 3)), time_s=[0, 2, 1])
    with pytest.raises(ValueError, match=r"time_s: expected increasing.*nan"):
        acerra.radargram(
            np.zeros((2, 4)), time_s=[0, np.nan], fast_time_start_s=0, fast_time_step_s=1e-10
        )
    with pytest.raises(ValueError, match="fast_time: expected even steps"):
        rows = acerra.radargram(
            np.zeros((2, 4)), time_s=[0, 1], fast_time_start_s=0, fast_time_step_s=1e-10
        )
        rows = rows.assign_coords(fast_time=("fast_time", [0, 1e-10, 2e-10, 4e-10]))
        acerra.prepare(rows, acerra.trajectory(np.zeros((2, 3))), image={})


def test_grids_that_cannot_be() -> None:
    for make in (
        lambda: acerra.Plane([1, 0], [0, 1], pixel_m=0.1),
        lambda: acerra.Plane([0, 1], [0, 1], pixel_m=0.0),
        lambda: acerra.Plane([0, 1e9], [0, 1e9], pixel_m=0.001),
        lambda: acerra.Plane([0, np.nan], [0, 1], pixel_m=0.1),
        lambda: acerra.Tilted([0, 0, 0], [0, 0, 0], [0, 1, 0], shape=(3, 3)),
    ):
        with pytest.raises(acerra.ImagingError):
            make()
    with pytest.raises(TypeError, match="(?s)expected two numbers.*found 18.*x_m"):
        acerra.Plane(18, 9, pixel_m=0.1)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"(?s)expected two numbers.*found \[1, 2, 3\].*y_m"):
        acerra.Volume([0, 1], [1, 2, 3], [0, 1], pixel_m=0.1)
    for kind in (acerra.Plane, acerra.Surface, acerra.Volume, acerra.Tilted):
        assert "Parameters" in (kind.__doc__ or "")
    with pytest.raises(ValueError, match="heights_m: expected shape"):
        acerra.Surface([0, 1], [0, 1], np.zeros((3, 3)), pixel_m=0.1)
    with pytest.raises(ValueError, match="z_m: expected a range upwards"):
        acerra.Volume([0, 1], [0, 1], [1, 0], pixel_m=0.1)


def test_files_that_cannot_be_read(tmp_path: Any) -> None:
    with pytest.raises(acerra.ReadError, match="no-such.mrm"):
        acerra.read_radar(tmp_path / "no-such.mrm")
    with pytest.raises(acerra.ReadError, match=r"no-such.toml: No such file"):
        acerra.Campaign.read(tmp_path / "no-such.toml")
    (tmp_path / "junk.pos").write_bytes(b"\x00\xff" * 100)
    with pytest.raises(acerra.ReadError, match="junk.pos"):
        acerra.read_trajectory(tmp_path / "junk.pos")
    with pytest.raises(acerra.SettingsError, match="unknown field"):
        acerra.Campaign.of({"radar": {"fiel": "x"}})
    with pytest.raises(acerra.PositionError):
        acerra.ppk(tmp_path / "junk.pos", tmp_path / "junk.pos")
    assert issubclass(acerra.ReadError, acerra.AcerraError)


def test_ctrl_c_stops_the_sum_early(echoes: Any) -> None:
    grid = acerra.Plane([0.5, 3], [-2, 2], pixel_m=0.001)
    started = threading.Event()

    def interrupt() -> None:
        started.wait()
        _thread.interrupt_main()

    progressed: list[tuple[str, int, int]] = []

    def progress(*step: Any) -> None:
        progressed.append(step)
        started.set()

    waiting = threading.Thread(target=interrupt)
    waiting.start()
    # Shells start background commands with Ctrl-C ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with pytest.raises(KeyboardInterrupt):
        # The double-precision sum over ten million pixels takes seconds.
        acerra.adjoint(
            echoes.position_m,
            echoes.frequency_hz,
            echoes.spectrum,
            grid,
            engine="reference",
            progress=progress,
        )
    waiting.join()
    signal.signal(signal.SIGINT, before)
    _, done, total = progressed[-1]
    assert done < 0.5 * total


def test_progress_is_told_and_its_exceptions_end_the_work(echoes: Any) -> None:
    grid = acerra.Plane([0.5, 3], [-2, 2], pixel_m=0.01)
    heard: list[tuple[str, int, int]] = []
    arguments = (echoes.position_m, echoes.frequency_hz, echoes.spectrum, grid)
    acerra.adjoint(*arguments, progress=lambda *said: heard.append(said))
    step, done, total = heard[-1]
    assert step == "image" and done == total == 61 * grid.shape[0] * grid.shape[1]

    def fail(step: str, done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        acerra.adjoint(*arguments, engine="reference", progress=fail)
    with pytest.raises(TypeError, match="progress: expected True or a function"):
        acerra.adjoint(*arguments, progress=3)  # type: ignore[arg-type]


def test_other_threads_run_while_an_image_is_made(echoes: Any) -> None:
    # A lock held for the whole sum leaves no tick in the middle half of the call.
    grid = acerra.Plane([0.5, 3], [-2, 2], pixel_m=0.005)
    ticks: list[float] = []
    stop = threading.Event()

    def count() -> None:
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    counting = threading.Thread(target=count)
    counting.start()
    begin = time.monotonic()
    acerra.adjoint(
        echoes.position_m, echoes.frequency_hz, echoes.spectrum, grid, engine="reference"
    )
    end = time.monotonic()
    stop.set()
    counting.join()
    quarter = (end - begin) / 4
    assert any(begin + quarter < tick < end - quarter for tick in ticks)


# 10⁵ calls take half an hour: with ACERRA_SLOW=1.
EXAMPLES = 40_000 if os.environ.get("ACERRA_SLOW") else 2_000

any_array = hnp.arrays(
    dtype=st.one_of(
        hnp.floating_dtypes(endianness="?"),
        hnp.complex_number_dtypes(endianness="?"),
        hnp.integer_dtypes(endianness="?"),
        hnp.boolean_dtypes(),
        hnp.unicode_string_dtypes(),
    ),
    shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5),
)
numbers = st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=3))


@settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True
)
@given(any_array, any_array, any_array, st.one_of(st.none(), any_array), numbers)
def test_no_arrays_crash_the_interpreter(
    position: Any, frequency: Any, spectrum: Any, weight: Any, accuracy: Any
) -> None:
    try:
        made = acerra.adjoint(position, frequency, spectrum, GRID, weight=weight, accuracy=accuracy)
    except (ValueError, TypeError, OverflowError, acerra.AcerraError):
        return
    assert made.shape == GRID.shape and np.isfinite(made.values).all()


@settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True
)
@given(any_array, any_array, numbers, numbers, any_array)
def test_no_radargram_crashes_the_interpreter(
    samples: Any, times: Any, start: Any, step: Any, position: Any
) -> None:
    try:
        rows = acerra.radargram(
            samples, time_s=times, fast_time_start_s=start, fast_time_step_s=step
        )
        acerra.prepare(
            rows,
            acerra.trajectory(position),
            image={"x_m": [0, 1], "y_m": [0, 1], "pixel_m": 0.5},
        )
    except (ValueError, TypeError, OverflowError, acerra.AcerraError):
        return


@settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True
)
@given(
    st.lists(numbers, max_size=3),
    st.lists(numbers, max_size=3),
    numbers,
    numbers,
    st.tuples(st.integers(-3, 5), st.integers(-3, 5)),
)
def test_no_grid_crashes_the_interpreter(x: Any, y: Any, z: Any, pixel: Any, shape: Any) -> None:
    for make in (
        lambda: acerra.Plane(x, y, z_m=z, pixel_m=pixel),
        lambda: acerra.Volume(x, y, [z, z], pixel_m=pixel, step_m=pixel),
        lambda: acerra.Tilted([z] * 3, x, y, shape=shape),
    ):
        try:
            made = make()
        except (ValueError, TypeError, OverflowError, acerra.AcerraError):
            continue
        assert min(made.shape) >= 1
