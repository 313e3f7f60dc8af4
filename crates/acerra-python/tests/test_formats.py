"""Radar files that other programs wrote: every sample is theirs."""

from __future__ import annotations

import struct
import subprocess
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
@pytest.mark.parametrize("bits", [8, 16, 32])
@pytest.mark.parametrize("channels", [1, 2])
def test_dzt_by_readgssi(tmp_path: Path, bits: int, channels: int) -> None:
    dzt: Any = pytest.importorskip("readgssi.dzt")
    kind = {8: "u1", 16: "<u2", 32: "<i4"}[bits]
    limits = np.iinfo(kind)
    random = np.random.default_rng(3)
    shape = (TRACES, channels, SAMPLES)
    written = random.integers(limits.min, limits.max, shape, endpoint=True).astype(kind)
    written[:, :, 1] = 0  # marks
    head = bytearray(1024 * channels)
    struct.pack_into("<5h", head, 0, 0xFF, channels, SAMPLES, bits, 0)
    struct.pack_into("<5f", head, 10, 20.0, 50.0, 0.0, 0.0, 30.0)
    struct.pack_into("<h", head, 52, channels)
    struct.pack_into("<f", head, 54, 9.0)
    file = tmp_path / "line.DZT"
    file.write_bytes(bytes(head) + written.tobytes())
    header, theirs, _ = dzt.readdzt(str(file))
    assert header["rhf_range"] == 30.0
    middle = {8: 128, 16: 32768, 32: 0}[bits]
    for channel in range(channels):
        name = None if channels == 1 else str(channel + 1)
        found = acerra.read(file, channel=name)
        assert isinstance(found, xr.DataArray)
        expected = np.asarray(theirs[channel]).T.astype(np.float64) - middle
        # The first two samples are no echoes.
        np.testing.assert_array_equal(np.asarray(found)[:, 2:], expected[:, 2:].astype(np.float32))
        interval_s = np.diff(np.asarray(found["fast_time"], dtype=float))
        np.testing.assert_allclose(interval_s, 30e-9 / SAMPLES, rtol=1e-6)


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


@pytest.fixture
def converted(tmp_path: Path, command: Path, values: npt.NDArray[np.float32]) -> Path:
    """The folder to which `acerra convert` wrote traces of HDF5, with places: line.sgy and line.h5."""
    h5py: Any = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "line.h5", "w") as out:
        out["data"] = values
        out["fast_time_s"] = 2e-9 + 100e-12 * np.arange(SAMPLES)
        out["position_m"] = np.array([(0.25 * i, -3.5, 2.0) for i in range(TRACES)])
    convert = [str(command), "convert", "line.h5", "--formats", "segy,hdf5", "-o", "converted"]
    subprocess.run(convert, check=True, capture_output=True, cwd=tmp_path)
    return tmp_path / "converted"


@pytest.mark.filterwarnings("ignore")
def test_converted_segy_by_segyio(converted: Path, values: npt.NDArray[np.float32]) -> None:
    segyio: Any = pytest.importorskip("segyio")
    with segyio.open(str(converted / "line.sgy"), ignore_geometry=True) as back:
        assert np.array_equal(back.trace.raw[:], values)
        # Picoseconds where the standard counts microseconds.
        assert back.bin[segyio.BinField.Interval] == 100
        assert back.bin[segyio.BinField.Format] == 5
        for i in range(TRACES):
            header = back.header[i]
            scalar = header[segyio.su.scalco]
            scale = 1 / -scalar if scalar < 0 else max(scalar, 1)
            assert header[segyio.su.sx] * scale == pytest.approx(0.25 * i, abs=1e-3)
            assert header[segyio.su.sy] * scale == pytest.approx(-3.5, abs=1e-3)


def test_converted_hdf5_by_h5py(converted: Path, values: npt.NDArray[np.float32]) -> None:
    h5py: Any = pytest.importorskip("h5py")
    with h5py.File(converted / "line.h5") as back:
        assert np.array_equal(back["data"][:], values)
        assert back["sample_interval_s"][()] == pytest.approx(100e-12, rel=1e-12)
        assert back["fast_time_start_s"][()] == pytest.approx(2e-9, rel=1e-12)
        assert np.allclose(back["position_m"][:, 0], 0.25 * np.arange(TRACES))
