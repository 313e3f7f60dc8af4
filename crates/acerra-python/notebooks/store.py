"""Runs the notebooks, stores their outputs, and writes them as pages of the guide.

usage: python notebooks/store.py [NAME…], in an environment with the package, its extras, nbclient and nbconvert
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import nbclient
import nbconvert
import nbformat

FOLDER = Path(__file__).parent
PAGES = FOLDER.parents[2] / "docs/guide/src/notebooks"


def executed(path: Path) -> Any:
    """A notebook with the outputs of a run, without what another run would change in vain."""
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": str(path.parent)}}
    ).execute()
    notebook.metadata = {"language_info": {"name": "python"}}
    for cell in notebook.cells:
        cell.metadata = {}
    return notebook


def page(notebook: Any, name: str) -> None:
    """A notebook as a page of the guide, its pictures beside it."""
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            # What is drawn by scripts and pictures is text on a page.
            if "<svg" in output.get("data", {}).get("text/html", ""):
                del output.data["text/html"]
    text, resources = nbconvert.MarkdownExporter().from_notebook_node(
        notebook, resources={"output_files_dir": f"{name}-files", "unique_key": name}
    )
    for file, content in resources["outputs"].items():
        place = PAGES / file
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    # Styles of tables are the guide's own.
    text = re.sub(r"<style scoped>.*?</style>\n?", "", text, flags=re.DOTALL)
    text = "\n".join(line.rstrip() for line in text.strip().splitlines())
    (PAGES / f"{name}.md").write_text(f"{text}\n", encoding="utf-8")


def main() -> None:
    """The notebooks of these names, or all."""
    PAGES.mkdir(parents=True, exist_ok=True)
    for path in sorted(FOLDER.glob("*.ipynb")):
        if sys.argv[1:] and path.stem not in sys.argv[1:]:
            continue
        notebook = executed(path)
        nbformat.write(notebook, path)
        page(notebook, path.stem)
        print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
