"""Results that cannot fit are refused before they are begun, whatever bounds the memory."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from shapes import grid

import qgeo_filters as qg
from qgeo_filters import memory

LIMITED = sys.platform == "linux"


def in_limited_process(code: str, gigabytes: float) -> subprocess.CompletedProcess[str]:
    """Run Python in a fresh process whose address space ends so many gigabytes beyond what it imports."""
    before = """
        import resource, numpy as np, qgeo_filters as qg
        from pathlib import Path
        from shapes import grid
        qg.distances(qg.Surface(*grid(4)), [0])  # loads what has to be loaded
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + int(%r * 1e9)
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    """
    surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}  # the tests' own shapes
    text = textwrap.dedent(before % gigabytes) + textwrap.dedent(code)
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False, env=surroundings)


def test_what_is_free_is_known_and_less_than_there_is() -> None:
    free = memory.available_memory()
    if free is None:
        pytest.skip("this system does not say how much memory is free")
    assert 1e6 < free < 1e14


def test_a_matrix_that_does_not_fit_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = qg.Surface(*grid(500))
    monkeypatch.setattr(memory, "available_memory", lambda: 20_000_000_000)
    with pytest.raises(
        MemoryError, match=r"all 251001 vertices would take 252 GB, and 20 GB of memory are free; .*out="
    ):
        qg.distance_matrix(surface)
    with pytest.raises(qg.TooLargeError, match=r"from 20000 to all 251001 vertices would take 40.2 GB.*fewer sources"):
        qg.distances(surface, np.arange(20_000))


def test_nothing_is_refused_where_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available_memory", lambda: None)
    assert memory.require_memory(1 << 60, "everything", "take less") is None


@pytest.mark.skipif(not LIMITED, reason="this system does not limit a process's address space")
def test_the_limit_of_the_process_counts() -> None:
    ended = in_limited_process(
        """
        from qgeo_filters.memory import available_memory
        assert 0 < available_memory() <= 5e8, available_memory()
        surface = qg.Surface(*grid(110))  # 0.6 GB
        try:
            qg.distance_matrix(surface)
        except qg.TooLargeError as error:
            print(error)
        """,
        0.5,
    )
    assert ended.returncode == 0, ended.stderr
    assert "the distances between all 12321 vertices would take 0.607 GB" in ended.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="control groups are Linux's")
def test_the_limit_of_a_container_counts(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, text in {"max": "5000000\n", "current": "3000000\n", "stat": "anon 1\ninactive_file 1000000\n"}.items():
        (tmp_path / f"memory.{name}").write_text(text)
    monkeypatch.setattr(memory, "CONTROL_GROUP", tmp_path)
    assert memory.available_memory() == 3_000_000
    (tmp_path / "memory.max").write_text("max\n")
    assert (memory.available_memory() or 0) > 3_000_000
