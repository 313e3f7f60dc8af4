"""What is installed: licence, metadata, types, and nothing that does not belong there."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import acerra


def test_licence_and_metadata() -> None:
    described = metadata.metadata("acerra")
    assert described["License-Expression"] == "MIT OR Apache-2.0"
    assert described["Version"] == acerra.__version__
    assert described["Requires-Python"] == ">=3.10"
    named = {line.split(";")[0].split(">")[0] for line in metadata.requires("acerra") or []}
    assert {"numpy", "pandas", "xarray"} <= named
    licences = described.get_all("License-File") or []
    assert sorted(Path(name).name for name in licences) == ["LICENSE-APACHE", "LICENSE-MIT"]


def test_the_package_holds_modules_types_and_the_native_module() -> None:
    folder = Path(acerra.__file__).parent
    held = {path.name for path in folder.iterdir() if path.name != "__pycache__"}
    assert {"py.typed", "_native.pyi", "__init__.py"} <= held
    native = [name for name in held if name.startswith("_native.abi3.")]
    assert len(native) == 1
    others = held - set(native)
    assert all(name.endswith((".py", ".pyi")) or name == "py.typed" for name in others)


def test_every_public_name_is_described() -> None:
    for name in acerra.__all__:
        value = getattr(acerra, name)
        if callable(value) or isinstance(value, type):
            assert value.__doc__, name
