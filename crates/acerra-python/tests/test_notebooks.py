"""The notebooks run from top to bottom, and what they print is what is stored of them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) == 4


def test_pages_of_the_guide_hold_the_notebooks() -> None:
    nbformat: Any = pytest.importorskip("nbformat")
    for path in NOTEBOOKS:
        pages = path.parents[3] / "docs/guide/src/notebooks"
        page = (pages / f"{path.stem}.md").read_text(encoding="utf-8")
        for cell in nbformat.read(path, as_version=4).cells:
            source = "\n".join(line.rstrip() for line in cell.source.strip().splitlines())
            assert source in page, f"{path.name}: write the page by notebooks/store.py"


def printed(cell: Any) -> str:
    """The text of a cell's outputs, with a sign for every number: times and last digits differ."""
    outputs = cell.get("outputs", [])
    texts = [
        output.get("text") or output.get("data", {}).get("text/plain", "") for output in outputs
    ]
    return re.sub(r"[-−–+]?\d[\d.e+-]*|\s+|-{2,}", "#", "".join(texts))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_as_it_is_stored(path: Path) -> None:
    nbformat: Any = pytest.importorskip("nbformat")
    nbclient: Any = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert any(cell.outputs for cell in cells), "store the outputs by notebooks/store.py"
    assert not any(output.output_type == "error" for cell in cells for output in cell.outputs)
    stored = [printed(cell) for cell in cells]
    nbclient.NotebookClient(
        notebook, timeout=300, resources={"metadata": {"path": str(path.parent)}}
    ).execute()
    for cell, text in zip(cells, stored, strict=True):
        assert printed(cell) == text, cell.source
