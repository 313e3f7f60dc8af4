"""Times backprojection as others do it on the scene that `common_scene -- dump=DIR` wrote.

Prints one line a program: Gbp/s (10^9 pixel x pulse contributions a second) on one thread and on all,
and the relative L2 error against the double-precision sum at every 17th pixel.
"""

import sys
import time
from pathlib import Path

import numpy as np

C = 299_792_458.0
folder = Path(sys.argv[1])
position = np.fromfile(folder / "position_m.f64").reshape(-1, 3)
frequency = np.fromfile(folder / "frequency_hz.f64")
spectrum = np.fromfile(folder / "spectrum.c128", np.complex128).reshape(len(position), -1)
expected = np.fromfile(folder / "expected.c128", np.complex128)
N, X0, PIXEL = 1800, -9.0, 0.01
# Pixels from one compared with the double-precision sum to the next, and those compared along an axis.
SPARSE = 17
COMPARED = N // SPARSE
GBP = N * N * len(position) * 1e-9
CENTRE = len(frequency) // 2
STEP = frequency[1] - frequency[0]


def profiles(bins):
    """Range profiles about the centre frequency, and the width of a bin in metres."""
    padded = np.zeros((len(position), bins), np.complex128)
    padded[:, np.arange(len(frequency)) - CENTRE] = spectrum
    return (np.fft.ifft(padded, axis=1) * bins).astype(np.complex64), C / (2 * STEP) / bins


def error(image):
    found = image[::SPARSE, ::SPARSE][:COMPARED, :COMPARED].ravel()
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


def report(name, interpolation, one, both, err):
    show = lambda v: f"{v:8.3f}" if v else "       -"
    print(f"| {name:34} | {interpolation:22} | {show(one)} | {show(both)} | {err:.1e} |", flush=True)


def best(run, repeats=3):
    took = []
    for _ in range(repeats):
        start = time.perf_counter()
        image = run()
        took.append(time.perf_counter() - start)
    return GBP / min(took), image


def numpy_lines(bins=4096, rows=60):
    """np.interp row by row; a few rows only, it takes minutes otherwise."""
    profile, width = profiles(bins)
    x = X0 + PIXEL * np.arange(N)
    wave = 4 * np.pi * frequency[CENTRE] / C
    image = np.zeros((N, N), np.complex64)
    chosen = np.arange(0, N, SPARSE)[: rows // SPARSE + 1]
    start = time.perf_counter()
    for j in chosen:
        y = X0 + PIXEL * j
        for p, row in zip(position, profile):
            r = np.sqrt((x - p[0]) ** 2 + (y - p[1]) ** 2 + p[2] ** 2)
            t = np.mod(r / width, bins)
            at = np.arange(bins + 1)
            closed = np.append(row, row[0])
            value = np.interp(t, at, closed.real) + 1j * np.interp(t, at, closed.imag)
            image[j] += (value * np.exp(1j * wave * r)).astype(np.complex64)
    took = time.perf_counter() - start
    found = image[chosen][:, ::SPARSE][:, :COMPARED].ravel()
    want = expected.reshape(COMPARED, COMPARED)[chosen // SPARSE].ravel()
    err = np.linalg.norm(found - want) / np.linalg.norm(want)
    report("NumPy, np.interp", f"linear, {bins} bins", len(chosen) * N * len(position) * 1e-9 / took, None, err)


def numba_loops():
    try:
        import numba
    except ImportError:
        print("| numba: not installed")
        return

    @numba.njit(parallel=True, fastmath=True)
    def backproject(profile, width, position, wave, out):
        bins = profile.shape[1]
        for j in numba.prange(out.shape[0]):
            y = np.float32(X0 + PIXEL * j)
            for i in range(out.shape[1]):
                x = np.float32(X0 + PIXEL * i)
                total = np.complex64(0)
                for m in range(position.shape[0]):
                    dx, dy, dz = x - position[m, 0], y - position[m, 1], position[m, 2]
                    r = np.sqrt(dx * dx + dy * dy + dz * dz)
                    t = r / width
                    k = int(t)
                    d = np.float32(t - k)
                    a, b = profile[m, k % bins], profile[m, (k + 1) % bins]
                    phase = wave * r
                    turn = np.complex64(complex(np.cos(phase), np.sin(phase)))
                    total += (a + (b - a) * d) * turn
                out[j, i] = total

    for bins in (2048, 4096):
        profile, width = profiles(bins)
        wave = 4 * np.pi * frequency[CENTRE] / C
        rates = []
        for threads in (1, numba.config.NUMBA_NUM_THREADS):
            numba.set_num_threads(threads)
            out = np.zeros((N, N), np.complex64)
            backproject(profile, width, position, wave, out[:2])
            rate, image = best(lambda: (backproject(profile, width, position, wave, out), out)[1], 1)
            rates.append(rate)
        report(f"numba {numba.__version__}, parallel, fastmath", f"linear, {bins} bins", *rates, error(image))


def torchbp_cart():
    try:
        import torch
        import torchbp
    except ImportError:
        print("| torchbp: not installed (it needs PyTorch and a compiler)")
        return
    for bins in (2048, 4096):
        profile, _ = profiles(bins)
        data = torch.from_numpy(profile)[None]
        grid = {"x": (X0, X0 + PIXEL * N), "y": (X0, X0 + PIXEL * N), "nx": N, "ny": N}
        where = torch.from_numpy(position.astype(np.float32))
        width = C / (2 * STEP) / bins
        rates = []
        for threads in (1, torch.get_num_threads()):
            torch.set_num_threads(threads)
            rate, image = best(
                lambda: torchbp.ops.backprojection_cart_2d(
                    data, grid, frequency[CENTRE], width, where
                )
            )
            rates.append(rate)
        image = image[0].numpy().T.conj()
        report("torchbp, backprojection_cart_2d", f"linear, {bins} bins", *rates, error(image))


print("| program                            | interpolation          |   1 core |     all  | error |")
print("| --- | --- | --- | --- | --- |")
numpy_lines()
numba_loops()
torchbp_cart()
