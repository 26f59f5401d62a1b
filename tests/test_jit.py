"""Compiled kernels: none runs old code after an edit, none is compiled once `warmup` has been."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import shapes

CALLEE = """
from qgeo_filters.jit import {decorator}
{constants}
@{decorator}
def step(x):
    return {step}
"""
CALLER = """
from callee import step
from qgeo_filters.jit import KERNELS, njit

@njit()
def total(x):
    return step(x) + later(x)

@njit()
def later(x):
    return 0.0

print(total(2.0), sum(sum(kernel._cache_misses.values()) for kernel in KERNELS.values()))
"""


def run(folder: Path, program: str, cache: Path | None = None) -> str:
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(folder), *sys.path]),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    environment.pop("NUMBA_CACHE_DIR", None)
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    done = subprocess.run([sys.executable, program], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("decorator", ["inner", "kernel"])
def test_a_caller_sees_the_edit_of_what_it_calls(tmp_path: Path, decorator: str) -> None:
    """Only the callee's file is touched: its code, then a constant that it takes from its module; then nothing."""
    (tmp_path / "caller.py").write_text(CALLER)

    def write(step: str, constants: str = "") -> None:
        (tmp_path / "callee.py").write_text(CALLEE.format(decorator=decorator, step=step, constants=constants))

    write("x + 1.0")
    assert run(tmp_path, "caller.py") == "3.0 3\n"
    write("x * FACTOR", "FACTOR = 5.0")
    assert run(tmp_path, "caller.py").split()[0] == "10.0"
    write("x * FACTOR", "FACTOR = 7.0")
    assert run(tmp_path, "caller.py").split()[0] == "14.0"
    assert run(tmp_path, "caller.py") == "14.0 0\n"  # from the cache
    # What the old code left is gone: one file for each of the three functions.
    assert len(list((tmp_path / "__pycache__").glob("*.nbc"))) == 3
    assert not list((tmp_path / "__pycache__").glob("*.tmp"))


@pytest.mark.slow
def test_processes_of_different_code_do_not_take_each_others(tmp_path: Path) -> None:
    """Two copies of the callee behind one caller and one cache, many processes at once: each gets its own result."""
    (tmp_path / "caller.py").write_text(CALLER)
    for name, step in (("a", "x + 1.0"), ("b", "x + 10.0")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "callee.py").write_text(CALLEE.format(decorator="inner", step=step, constants=""))
    processes = {}
    for turn in range(6):
        name = "ab"[turn % 2]
        path = os.pathsep.join([str(tmp_path / name), *sys.path])
        processes[turn] = subprocess.Popen(
            [sys.executable, "caller.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path},
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    for turn, process in processes.items():
        output, error = process.communicate()
        assert process.returncode == 0, error
        assert output.split()[0] == ("3.0", "12.0")[turn % 2]


WARM = """
import json, sys, warnings
import numpy as np
import qgeo_filters as qg
from qgeo_filters.jit import KERNELS
import shapes

qg.warmup()
warm = {name: len(kernel.signatures) for name, kernel in KERNELS.items()}
surface = qg.Surface(*shapes.blob(2))
lifted = qg.lifted_metric(surface)
for metric in (lifted, "cartesian"):
    qg.distance_matrix(surface, metric)
    for method in ("graph", "exact", "edges"):
        qg.distances(surface, [0, 5], metric, method)
    for initial in ("exact", "edges"):
        qg.quasi_geodesic(surface, 0, 100, metric, initial=initial)
qg.DistanceOperator(surface) @ np.ones((162, 2), np.float32)
qg.DistanceOperator(surface) @ np.ones(162)


def report():
    print(json.dumps([warm, {name: len(kernel.signatures) for name, kernel in KERNELS.items()}]))


report()
"""


def test_warmup_leaves_nothing_to_compile_to_distances_and_paths(tmp_path: Path) -> None:
    (tmp_path / "warm.py").write_text(WARM)
    warm, after = json.loads(run(tmp_path, "warm.py"))
    assert after == warm


@pytest.mark.slow
@pytest.mark.thorough
def test_warmup_leaves_no_kernel_uncompiled(tmp_path: Path) -> None:
    """Without a cache: every kernel that the package has, found by reading its files; nothing new in a match."""
    package = Path(shapes.__file__).parents[1] / "qgeo_filters"
    marks = ("@njit(", "@inner\n", "@kernel\n")
    files = [file.read_text() for file in package.rglob("*.py") if file.name != "jit.py"]
    written = sum(text.count(f"\n{mark}") for text in files for mark in marks)
    (tmp_path / "warm.py").write_text(WARM + "qg.match(surface, qg.Surface(*shapes.blob(2, seed=3)))\nreport()\n")
    output = run(tmp_path, "warm.py", cache=tmp_path / "cache")
    warm, after = json.loads(output.splitlines()[-1])
    assert len(warm) == written > 60
    assert [name for name, count in warm.items() if not count] == []
    assert after == warm


def test_without_a_folder_for_the_cache_it_works_and_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from numba.core.caching import FunctionCache

    from qgeo_filters import jit

    def refuse(self: object, function: object) -> None:
        raise RuntimeError("no locator available for file 'x.py'")

    monkeypatch.setattr(FunctionCache, "__init__", refuse)
    monkeypatch.setattr(jit, "KERNELS", {})

    def twice(x: float) -> float:
        return 2 * x

    with caplog.at_level("WARNING", logger="qgeo_filters"):
        assert jit.njit()(twice)(4.0) == 8.0
    assert "set NUMBA_CACHE_DIR to a folder: no locator available" in caplog.text
