"""The guide's first script, word for word, in an environment of its own; other programs read what it wrote.

usage: python stranger.py GUIDE.md, in an empty folder, with the wheel, netCDF4, h5netcdf, SciPy and rasterio
installed and nothing of the sources on the path.
"""

from __future__ import annotations

import importlib
import sys
import warnings
from pathlib import Path
from typing import Any

HEADING = "## A first script"


def script(guide: str) -> str:
    """The first block of Python under the heading."""
    section = guide.split(f"{HEADING}\n", 1)[1]
    return section.split("```python\n", 1)[1].split("```", 1)[0]


def read_again(names: dict[str, Any]) -> None:
    """Reads the script's files with three engines of xarray and with GDAL."""
    import numpy as np
    import xarray as xr

    import acerra

    rasterio: Any = importlib.import_module("rasterio")

    image = names["run"].image
    abs(image).to_netcdf("classic.nc", engine="scipy")
    for engine, file in (("netcdf4", "level.nc"), ("h5netcdf", "level.nc"), ("scipy", "classic.nc")):
        level = xr.load_dataarray(file, engine=engine)
        xr.testing.assert_equal(level, abs(image))
        print(f"{file} by {engine}: {dict(level.sizes)}, equal")
    for engine in ("netcdf4", "h5netcdf"):
        read = acerra.join_complex(xr.load_dataset("image.nc", engine=engine))["image"]
        xr.testing.assert_equal(read, image)
        print(f"image.nc by {engine}: {read.dtype}, equal")
    table = names["table"]
    assert len(table) > 100 and table["gps_time"].dtype.kind == "M", table.dtypes
    with rasterio.open("products/image-db.tif") as file:
        band = file.read(1, masked=True)
        print(f"image-db.tif by GDAL {rasterio.__gdal_version__}: {file.crs}, nodata {file.nodata}, ")
        print(f"    {band.min():.1f} to {band.max():.1f} dB, {band.mask.mean():.1%} without data")
        assert file.crs.is_projected and file.nodata is not None
        assert 0 < band.mask.mean() < 1 and abs(float(band.max())) < 0.5
    with rasterio.open("netcdf:level.nc:image") as file:
        print(f"level.nc by GDAL: {file.shape}, {file.crs.to_dict()}")
        assert file.shape == image.shape and file.crs.is_projected
    assert np.isfinite(image.values).all()


def main() -> None:
    """Runs the script, and reads its files."""
    code = script(Path(sys.argv[1]).read_text(encoding="utf-8"))
    lines = [line for line in code.splitlines() if line.strip()]
    print(f"{len(lines)} lines of {sys.argv[1]}\n")
    names: dict[str, Any] = {"__name__": "__main__"}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        exec(compile(code, sys.argv[1], "exec"), names)
    print()
    read_again(names)


if __name__ == "__main__":
    main()
