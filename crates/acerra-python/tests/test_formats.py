"""Radar files that other programs wrote: every sample is theirs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import xarray as xr

import acerra

TRACES, SAMPLES = 7, 30


@pytest.fixture
def values() -> npt.NDArray[np.float32]:
    return np.random.default_rng(1).normal(size=(TRACES, SAMPLES)).astype(np.float32)


def read(file: Path) -> npt.NDArray[Any]:
    found = acerra.read(file)
    if isinstance(found, xr.Dataset):
        return np.asarray(found["spectrum"])
    return np.asarray(found)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("endian", ["big", "little"])
@pytest.mark.parametrize("code", [1, 2, 3, 5])
def test_segy_of_segyio(
    tmp_path: Path, values: npt.NDArray[np.float32], code: int, endian: str
) -> None:
    segyio: Any = pytest.importorskip("segyio")
    file = tmp_path / "line.sgy"
    spec = segyio.spec()
    spec.format, spec.endian = code, endian
    spec.samples, spec.tracecount = np.arange(SAMPLES), TRACES
    kind = {1: "f4", 2: "i4", 3: "i2", 5: "f4"}[code]
    with segyio.create(str(file), spec) as out:
        out.text[0] = segyio.tools.create_text_header({1: "GPR"})
        out.bin.update(hdt=100, hns=SAMPLES, format=code)
        for i, row in enumerate(values):
            out.header[i] = {segyio.su.ns: SAMPLES, segyio.su.dt: 100}
            out.trace[i] = (100 * row).astype(kind)
    with segyio.open(str(file), ignore_geometry=True, endian=endian) as back:
        expected = back.trace.raw[:]
    np.testing.assert_array_equal(read(file), expected)


@pytest.mark.filterwarnings("ignore")
def test_matlab_of_scipy(tmp_path: Path, values: npt.NDArray[np.float32]) -> None:
    io: Any = pytest.importorskip("scipy.io")
    file = tmp_path / "line.mat"
    arrays = {"data": values, "fast_time_s": 1e-10 * np.arange(SAMPLES), "time_s": np.arange(TRACES)}
    for is_packed in (False, True):
        io.savemat(file, arrays, do_compression=is_packed)
        np.testing.assert_array_equal(read(file), values)
    turned = {"spectrum": (values + 1j * values).T, "frequency_hz": 1e9 + 1e6 * np.arange(SAMPLES)}
    io.savemat(file, turned)
    np.testing.assert_array_equal(read(file), values + 1j * values)


@pytest.mark.filterwarnings("ignore")
def test_hdf5_of_h5py(tmp_path: Path, values: npt.NDArray[np.float32]) -> None:
    h5py: Any = pytest.importorskip("h5py")
    file = tmp_path / "line.h5"
    whole = (1000 * values).astype("i2")
    with h5py.File(file, "w") as out:
        out.create_dataset("data", data=whole, compression="gzip", chunks=(2, 8))
        out["sample_interval_s"] = 1e-10
        out["time_s"] = np.arange(TRACES)
    np.testing.assert_array_equal(read(file), whole)


@pytest.mark.filterwarnings("ignore")
def test_touchstone_of_scikit_rf(tmp_path: Path) -> None:
    skrf: Any = pytest.importorskip("skrf")
    random = np.random.default_rng(2)
    matrix = random.normal(size=(11, 2, 2)) + 1j * random.normal(size=(11, 2, 2))
    band = skrf.Frequency(1, 2, 11, "ghz")
    skrf.Network(frequency=band, s=matrix, name="sweep").write_touchstone("sweep", dir=str(tmp_path))
    found = acerra.read(tmp_path / "sweep.s2p", channel="S21")
    assert isinstance(found, xr.Dataset)
    np.testing.assert_allclose(np.asarray(found["spectrum"])[0], matrix[:, 1, 0], rtol=1e-6)
