"""The chain from Python gives what the command gives."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import acerra
import numpy as np
import pytest
import xarray as xr

TABLES: dict[str, dict[str, Any]] = {
    "incidence": {
        "x_m": [2, 6],
        "y_m": [-2, 2],
        "z_m": 0.0,
        "pixel_m": 0.1,
        "max_incidence_deg": 40.0,
        "accuracy": 1e-4,
        "weight": "path",
    },
    "plane": {"x_m": [2, 6], "y_m": [-2, 2], "z_m": 0.0, "pixel_m": 0.04},
    "volume": {"x_m": [3, 5], "y_m": [-1, 1], "z_m": [-0.2, 0.2], "pixel_m": 0.1},
    "looks": {"x_m": [2, 6], "y_m": [-2, 2], "z_m": 0.0, "pixel_m": 0.1, "looks": 3},
}


def campaign_with(demo: Path, image: dict[str, Any]) -> tuple[str, acerra.Campaign]:
    """The demo's campaign with other pixels, as the text of a file and as an object."""
    text = (demo / "campaign.toml").read_text()
    before = text[: text.index("[image]")]
    after = text[text.index("[image]") :].split("\n[", 1)
    rest = f"\n[{after[1]}" if len(after) > 1 else ""
    table = "".join(f"{key} = {json.dumps(value)}\n" for key, value in image.items())
    text = f"{before}[image]\n{table}{rest}"
    return text, acerra.Campaign.parse(text, folder=demo)


@pytest.mark.parametrize("kind", TABLES)
def test_a_run_is_the_command_s_bit_for_bit(
    demo: Path, command: Path, tmp_path: Path, kind: str
) -> None:
    text, campaign = campaign_with(demo, TABLES[kind])
    file = demo / f"{kind}.toml"
    file.write_text(text)
    products = tmp_path / "products"
    subprocess.run([command, "focus", file, "-o", products], check=True, capture_output=True)
    run = campaign.run()
    written = np.load(products / "image.npz")
    assert np.array_equal(run.image.values, written["image"])
    targets = json.loads((products / "targets.json").read_text())["targets"]
    assert run.targets["x_m"].tolist() == [target["x_m"] for target in targets]
    findings = json.loads((products / "run.json").read_text())["evidence"]
    assert [f.name for f in run.evidence] == [finding["name"] for finding in findings]
    if kind == "volume":
        assert run.volume is not None
        assert np.array_equal(run.volume.values, np.load(products / "volume.npz")["volume"])
        assert np.array_equal(run.prepared.image().values, run.volume.values)
    else:
        assert np.array_equal(run.prepared.image().values, run.image.values)


def test_terrain_is_imaged_as_by_the_command(demo: Path, command: Path, tmp_path: Path) -> None:
    rows = ["ncols 5", "nrows 5", "xllcorner -20", "yllcorner -20", "cellsize 10"]
    heights = "\n".join(" ".join(f"{0.02 * (i - j):.3f}" for i in range(5)) for j in range(5))
    (demo / "terrain.asc").write_text("\n".join(rows) + "\n" + heights + "\n")
    image = {"x_m": [3, 5], "y_m": [-1, 1], "pixel_m": 0.1, "terrain": "terrain.asc"}
    image["terrain_crs"] = "local"
    text, campaign = campaign_with(demo, image)
    file = demo / "terrain.toml"
    file.write_text(text)
    products = tmp_path / "products"
    subprocess.run([command, "focus", file, "-o", products], check=True, capture_output=True)
    run = campaign.run()
    assert isinstance(run.grid, acerra.Surface)
    assert np.array_equal(run.image.values, np.load(products / "image.npz")["image"])


def test_positions_are_corrected_as_by_the_command(
    demo: Path, command: Path, tmp_path: Path
) -> None:
    text, _ = campaign_with(demo, TABLES["plane"])
    text += "\n[autofocus]\nenabled = true\n"
    file = demo / "corrected.toml"
    file.write_text(text)
    products = tmp_path / "products"
    subprocess.run([command, "focus", file, "-o", products], check=True, capture_output=True)
    prepared = acerra.Campaign.parse(text, folder=demo).prepare()
    assert np.array_equal(prepared.image().values, np.load(products / "image.npz")["image"])
    findings = json.loads((products / "run.json").read_text())["evidence"]
    said = [f["name"] for f in findings if f["name"].startswith("autofocus")]
    assert [f.name for f in prepared.evidence if f.name.startswith("autofocus")] == said != []


def test_focus_writes_the_command_s_products(demo: Path, tmp_path: Path) -> None:
    text, _ = campaign_with(demo, TABLES["plane"])
    file = demo / "written.toml"
    file.write_text(text)
    run = acerra.focus(file, tmp_path / "products")
    written = np.load(tmp_path / "products" / "image.npz")
    assert np.array_equal(run.image.values, written["image"])
    assert (tmp_path / "products" / "report.html").is_file()
    assert np.array_equal(acerra.focus(file).image.values, written["image"])


def test_arrays_in_memory_go_the_way_of_files(demo: Path) -> None:
    _, campaign = campaign_with(demo, TABLES["plane"])
    prepared = campaign.prepare()
    # The same radargram and the positions that the chain gave its traces, all in memory.
    raw = acerra.read_radar(demo / "radar.mrm")
    assert isinstance(raw, xr.DataArray)
    chosen = raw.isel(trace=prepared.spectrum["number"].values.astype(int))
    again = acerra.prepare(
        chosen,
        acerra.trajectory(prepared.position_m),
        image=TABLES["plane"],
        radar={"delay_ns": campaign.tables["radar"]["delay_ns"]},
        preprocess={"gate_ns": prepared.settled()["gate_ns"]},
    )
    difference = again.image() - prepared.image()
    assert float(abs(difference).max()) < 1e-3 * float(abs(prepared.image()).max())


def test_a_part_of_the_pulses_and_other_pixels(demo: Path) -> None:
    _, campaign = campaign_with(demo, TABLES["plane"])
    prepared = campaign.prepare()
    grid = acerra.Plane([3, 5], [-1, 1], pixel_m=0.05)
    whole = prepared.image(grid, accuracy=1e-5)
    traces = len(prepared.position_m)
    halves = [
        prepared.image(grid, accuracy=1e-5, pulses=part, weight="trace")
        for part in (slice(0, traces // 2), slice(traces // 2, None))
    ]
    expected = prepared.image(grid, accuracy=1e-5, weight="trace")
    difference = abs(halves[0] + halves[1] - expected).max() / abs(expected).max()
    assert float(difference) < 1e-4
    by_arrays = acerra.adjoint(
        prepared.position_m,
        prepared.frequency_hz,
        prepared.spectrum["spectrum"],
        grid,
        weight=prepared.weights(),
        accuracy=1e-5,
        light_speed_m_s=prepared.light_speed_m_s,
    )
    assert np.array_equal(by_arrays.values, whole.values)
    with pytest.raises(ValueError, match="pulses: expected a slice of 0 to"):
        prepared.image(grid, pulses=slice(5, 5))


def test_positions_by_carrier_phase(demo: Path) -> None:
    tables = acerra.Campaign.read(demo / "campaign.toml").tables
    found = acerra.ppk(
        demo / "rover.ubx", demo / "base.ubx", base_ecef_m=tables["gnss"]["base_ecef_m"]
    )
    assert found.attrs["fixed_percent"] > 95
    assert found.sizes["epoch"] == found.attrs["epochs"]
    assert found["gps_time"].dtype.kind == "M"
    assert float(found["sigma_x"].median()) < 0.02
    raw = acerra.read_radar(demo / "radar.mrm")
    assert isinstance(raw, xr.DataArray)
    moved = acerra.prepare(
        raw,
        found,
        image=TABLES["plane"],
        trajectory={
            key: tables["trajectory"][key]
            for key in ("time_offset_s", "origin_deg_m", "lever_arm_m")
        },
    )
    image = abs(moved.image())
    peak = image[image.argmax(...)]
    assert abs(float(peak.x) - 4) < 0.1 and abs(float(peak.y)) < 0.3


def test_wrong_settings_are_warned_of_or_refused(demo: Path) -> None:
    _, right = campaign_with(demo, TABLES["plane"])
    tables = right.tables
    # The radar's true delay is 10 ns.
    tables["radar"]["delay_ns"] = 16.0
    campaign = acerra.Campaign.of(tables)
    with pytest.warns(acerra.AcerraWarning, match="delay"):
        prepared = campaign.prepare()
    assert any(f.verdict == "contradicts" for f in prepared.evidence)
    with pytest.raises(acerra.EvidenceError, match="contradicts the settings"):
        campaign.run()


def test_views_of_a_run(demo: Path) -> None:
    _, campaign = campaign_with(demo, TABLES["plane"])
    run = campaign.run()
    png = run.png()
    assert png is not None and png.startswith(b"\x89PNG")
    shown = run._repr_html_()
    assert "data:image/png" in shown and "coupling_delay" in shown
    assert "<script" not in shown
    plt = pytest.importorskip("matplotlib")
    plt.use("Agg")
    raw = run.prepared.radargram("raw")
    assert raw is not None
    acerra.plot.image(run.image)
    acerra.plot.radargram(raw)


def test_matplotlib_and_scipy_are_not_imported_before_use() -> None:
    import sys

    code = "import acerra, sys; sys.exit(any(m in sys.modules for m in ('matplotlib', 'scipy', 'dask')))"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_plan_has_lines_and_missions() -> None:
    made = acerra.plan(
        {
            "area": {
                "corners_deg": [
                    [40.9595, 14.3695],
                    [40.9595, 14.3705],
                    [40.9600, 14.3705],
                    [40.9600, 14.3695],
                ]
            },
            "want": {"along_m": 0.05, "across_m": 0.6},
        }
    )
    assert made.summary["lines"] >= 1
    assert made.geojson["type"] == "FeatureCollection"
    assert made.missions[0]["fileType"] == "Plan"
    assert made.kml.startswith("<?xml")


def test_files_and_lever_arms_that_would_be_left_out_are_refused(echoes: Any) -> None:
    rows = acerra.radargram(
        np.ones((3, 8)), time_s=[0, 1, 2], fast_time_start_s=0, fast_time_step_s=1e-10
    )
    places = acerra.trajectory(np.ones((3, 3)))
    with pytest.raises(acerra.SettingsError, match="gnss: expected none"):
        acerra.prepare(rows, places, gnss={"rover": "a.ubx", "base": "b.ubx"})
    with pytest.raises(acerra.PositionError, match="lever"):
        acerra.prepare(rows, places, trajectory={"lever_arm_m": [1, 0, 0]})


def test_calibration_finds_the_delay_of_the_demo(demo: Path) -> None:
    found = acerra.calibrate(demo / "campaign.toml", [[4, 0, 0], [14, 0, 0]])
    delay = next(e for e in found["estimates"] if "delay" in e["name"])
    assert abs(delay["value"] - 10) < max(4 * (delay["sigma"] or 0), 0.2)
    assert len(found["reflectors"]) == 2 and found["keys"]
    with pytest.raises(ValueError, match=r"reflector_m: expected shape \(n, 3\)"):
        acerra.calibrate(demo / "campaign.toml", [[4, 0]])
