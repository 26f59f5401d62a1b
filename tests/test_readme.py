"""The first lines of code that a new user copies from the README do what they say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

import qgeo_filters as qg


def test_the_first_snippet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As it stands, but for the window: a coloured mesh, a selection of some vertices, and a pipeline in a file."""
    open3d = pytest.importorskip("open3d")
    pytest.importorskip("pymeshlab")
    monkeypatch.chdir(tmp_path)
    drawn: list[Any] = []
    monkeypatch.setattr(open3d.visualization, "draw_geometries", drawn.extend)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    part = readme[readme.index("## In a notebook or a script") :]
    code = re.search(r"^```python\n(.*?)^```$", part, re.MULTILINE | re.DOTALL)
    assert code
    names: dict[str, Any] = {}
    exec(code[1], names)
    (shown,) = drawn
    assert shown.has_vertex_colors()
    assert len({tuple(color) for color in shown.vertex_colors}) > 100
    mesh = names["out"].current_mesh()
    assert 0.1 < mesh.selected_vertex_number() / mesh.vertex_number() < 0.9
    assert repr(qg.Pipeline.load("pipe.yaml")) == repr(names["pipe"])
