"""What is logged, and that nothing is printed."""

from __future__ import annotations

import ast
import logging
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from shapes import blob, fan

import qgeo_filters as qg
from qgeo_filters.caching import StageCache


def test_the_graph_and_the_cache_say_what_took_long(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, "qgeo_filters"):
        qg.distances(qg.Surface(*blob(2)), [0])
        cache = StageCache(max_bytes=800)
        for key in ("first", "first", "second"):
            cache.get(key, lambda: np.zeros(100))
    said = [record.getMessage() for record in caplog.records]
    assert any(line.startswith("graph of 162 vertices for accuracy 0.001: ") and line.endswith(" s") for line in said)
    assert [line for line in said if line == "first: in memory"] == ["first: in memory"]
    assert "first: dropped from memory, 800 bytes" in said
    assert all(record.name.startswith("qgeo_filters.") for record in caplog.records)


def test_repairs_are_told(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "qgeo_filters"):
        repaired = qg.repair_surface(fan(), force=True)
    assert repaired.report
    assert [record.getMessage() for record in caplog.records] == [f"repair: {line}" for line in repaired.report]


def test_it_is_silent_until_asked() -> None:
    """Warnings of a library without a handler go to stderr; ours wait for the user's."""
    code = "import logging, qgeo_filters; logging.getLogger('qgeo_filters.caching').warning('heard')"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout + ended.stderr == ""


def test_the_library_prints_nothing() -> None:
    package = Path(qg.__file__).parent
    found = [
        f"{path.relative_to(package)}:{node.lineno}"
        for path in package.rglob("*.py")
        if path.relative_to(package).parts[0] != "cli"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    ]
    assert found == []
