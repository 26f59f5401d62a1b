"""The notebooks run from top to bottom, on data that anyone has."""

from __future__ import annotations

from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"
# Those that take half a minute and more; what they show is tested elsewhere, and in the gallery.
LONG = ("03_", "05_", "07_")


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.thorough] * path.name.startswith(LONG))
        for path in sorted(NOTEBOOKS.glob("*.ipynb"))
    ],
)
def test_notebook(path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    for host in ("open3d", "pymeshlab", "pythreejs"):
        pytest.importorskip(host)
    monkeypatch.setenv("OPEN3D_DISABLE_WEB_VISUALIZER", "true")
    monkeypatch.delenv("QGEO_DATA", raising=False)
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "commit notebooks without their outputs"
    # Raises, with the cell and its traceback, if a cell does.
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    assert all(cell.execution_count for cell in notebook.cells if cell.cell_type == "code")
    ends = [cell.outputs[-1] for cell in notebook.cells if cell.cell_type == "code" and cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in ends)
