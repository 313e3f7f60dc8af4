"""Imaging and modelling of arrays against the textbook sums in NumPy's double precision."""

from __future__ import annotations

from typing import Any

import acerra
import numpy as np
import pytest
import xarray as xr

GRIDS: dict[str, Any] = {
    "plane": acerra.Plane([1, 2.5], [-0.8, 0.8], z_m=0.0, pixel_m=0.05),
    "tilted": acerra.Tilted([1, -0.8, 0], [0.05, 0, 0.01], [0, 0.05, -0.005], shape=(33, 31)),
    "surface": acerra.Surface(
        [1, 2.5],
        [-0.8, 0.8],
        0.1 * np.sin(np.arange(33 * 31) / 50).reshape(33, 31),
        pixel_m=0.05,
    ),
    "volume": acerra.Volume([1, 2.5], [-0.8, 0.8], [-0.1, 0.2], pixel_m=0.05, step_m=0.1),
}


def points_of(image: xr.DataArray) -> np.ndarray:
    """The places of an image's values, in their order."""
    x, y, z = xr.broadcast(image["x"], image["y"], image["z"])
    return np.column_stack([axis.transpose(*image.dims).values.ravel() for axis in (x, y, z)])


def relative_l2(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


@pytest.mark.parametrize("kind", GRIDS)
@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_an_image_keeps_its_accuracy_on_every_grid(echoes: Any, kind: str, accuracy: float) -> None:
    grid = GRIDS[kind]
    image = acerra.adjoint(
        echoes.position_m, echoes.frequency_hz, echoes.spectrum, grid, accuracy=accuracy
    )
    assert image.shape == grid.shape
    expected = echoes.image_at(points_of(image))
    assert relative_l2(image.values.ravel(), expected) <= accuracy
    assert image.attrs["checked_error"] <= accuracy
    assert image.attrs["memory_bytes"] >= image.nbytes


@pytest.mark.parametrize("kind", GRIDS)
def test_the_forward_operator_models_the_textbook_echoes(echoes: Any, kind: str) -> None:
    grid = GRIDS[kind]
    scene = np.zeros(grid.shape, np.complex64)
    chosen = np.random.default_rng(3).choice(scene.size, 4, replace=False)
    scene.ravel()[chosen] = [1, 1j, -0.5, 2]
    spectrum = acerra.forward(scene, grid, echoes.position_m, echoes.frequency_hz, accuracy=1e-4)
    labelled = acerra.adjoint(echoes.position_m, echoes.frequency_hz, spectrum, grid)
    points = points_of(labelled)[chosen]
    assert relative_l2(spectrum, echoes.echoes_of(points, scene.ravel()[chosen])) < 1e-3


@pytest.mark.parametrize("kind", GRIDS)
def test_forward_and_adjoint_are_transposes(echoes: Any, kind: str) -> None:
    grid, random = GRIDS[kind], np.random.default_rng(8)
    image = random.normal(size=grid.shape) + 1j * random.normal(size=grid.shape)
    data = random.normal(size=echoes.spectrum.shape) + 1j * random.normal(
        size=echoes.spectrum.shape
    )
    weight = random.uniform(0.5, 2, len(echoes.position_m))
    same: dict[str, Any] = {"weight": weight, "accuracy": 1e-5}
    modelled = acerra.forward(image, grid, echoes.position_m, echoes.frequency_hz, **same)
    imaged = acerra.adjoint(echoes.position_m, echoes.frequency_hz, data, grid, **same)
    left, right = np.vdot(data, modelled), np.vdot(imaged.values, image)
    assert abs(left - right) < 1e-4 * np.linalg.norm(data) * np.linalg.norm(modelled)


def test_engines_and_spreading_are_those_asked_for(echoes: Any) -> None:
    arguments = (echoes.position_m, echoes.frequency_hz, echoes.spectrum, GRIDS["plane"])
    reference = acerra.adjoint(*arguments, engine="reference")
    assert "reference" in reference.attrs["plan"]
    double = acerra.adjoint(*arguments, accuracy=1e-6)
    assert "double precision" in double.attrs["plan"] and double.attrs["checked_error"] < 1e-6
    assert relative_l2(double.values, reference.values) <= 1e-6
    direct = acerra.adjoint(*arguments, engine="direct")
    assert relative_l2(direct.values, reference.values) <= 1e-3
    assert "direct" in direct.attrs["plan"]
    unweighted = acerra.adjoint(*arguments, spreading="none", engine="reference")
    assert abs(unweighted).max() > 10 * abs(reference).max()
    with pytest.raises(ValueError, match='engine: expected "auto".*found "gpu"'):
        acerra.adjoint(*arguments, engine="gpu")  # type: ignore[arg-type]


def test_targets_are_measured_where_they_stand(echoes: Any) -> None:
    grid = acerra.Plane([0.5, 3], [-1, 1], pixel_m=0.01)
    arrays = (echoes.position_m, echoes.frequency_hz, echoes.echoes_of([[1.5, 0.2, 0]], [1]))
    image = acerra.adjoint(*arrays, grid)
    found = acerra.measure(image, grid, *arrays)
    strongest = found["targets"][0]
    assert abs(strongest["x_m"] - 1.5) < 0.005 and abs(strongest["y_m"] - 0.2) < 0.005
    assert found["statistics"]["median_db"] < -10


def test_a_solver_of_scipy_recovers_the_scene(echoes: Any) -> None:
    linalg = pytest.importorskip("scipy.sparse.linalg")
    from acerra.operators import ScatteringOperator

    # Pixels of a resolution cell: the scene is determined.
    grid = acerra.Plane([1, 2.5], [-0.8, 0.8], pixel_m=0.3)
    operator = ScatteringOperator(echoes.position_m, echoes.frequency_hz, grid, accuracy=1e-6)
    scene = np.zeros(grid.shape, complex)
    scene[2, 2], scene[1, 4] = 1, 0.5j
    data = operator @ scene.ravel()
    solved = linalg.lsqr(operator, data, iter_lim=200, atol=1e-7, btol=1e-7)[0]
    assert relative_l2(solved, scene.ravel()) < 1e-3


def test_pylops_accepts_the_operator(echoes: Any) -> None:
    pylops = pytest.importorskip("pylops")
    from acerra.operators import ScatteringOperator

    grid = acerra.Plane([1.3, 1.7], [0, 0.4], pixel_m=0.05)
    scattering = ScatteringOperator(echoes.position_m, echoes.frequency_hz, grid, accuracy=1e-6)
    operator = pylops.LinearOperator(Op=scattering)
    assert pylops.utils.dottest(operator, *operator.shape, complexflag=3, rtol=1e-4)


def test_point_spread_and_theory_agree_with_the_paper() -> None:
    track = np.column_stack([np.linspace(-3, 3, 601), np.zeros(601), np.full(601, 5.0)])
    spread = acerra.PointSpread(track, np.linspace(3.1e9, 4.8e9, 341))
    found = spread.analyse([0, 2, 0])
    assert abs(found["across"]["rayleigh_m"] / 0.247 - 1) < 0.03  # Table 1
    grid = acerra.Plane([-0.5, 0.5], [1.5, 2.5], pixel_m=0.01)
    image = spread.image([[0, 2, 0]], grid)
    peak = image[abs(image).argmax(...)]
    assert abs(float(peak.x)) < 0.011 and abs(float(peak.y) - 2) < 0.011
    theory = acerra.resolution(10, 2, half_aperture_m=9)
    assert abs(theory["across_m"] - 0.41) < 0.005 and abs(theory["along_m"] - 0.03) < 0.005
