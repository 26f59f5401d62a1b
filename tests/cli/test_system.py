"""``qgeo info --system`` and ``python -m qgeo_filters``: what a report of a bug needs."""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from collections.abc import Callable

import pytest
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.cli import system

Qgeo = Callable[..., Result]


def test_every_package_is_listed_with_its_version(qgeo: Qgeo) -> None:
    result = qgeo("info", "--system")
    assert result.exit_code == 0, result.output
    said = dict(line.split(": ", 1) for line in result.stdout.splitlines())
    assert said["qgeo-filters"] == qg.__version__
    assert said["python"].startswith(sys.version.split()[0])
    for name in ("numpy", "scipy", "libigl", "open3d", "pymeshlab", "ipywidgets", "pythreejs", "zarr", "dask"):
        assert said[name] == importlib.metadata.version(name)
    assert not {"pytest", "ruff", "qgeo-filters[all]"} & said.keys()


def test_what_is_missing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "dependencies", lambda: ["numpy", "no-such-package"])
    assert "no-such-package: not installed" in system.system_information().splitlines()


def test_the_package_runs_as_a_module() -> None:
    run = [sys.executable, "-m", "qgeo_filters"]
    done = subprocess.run([*run, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"qgeo-filters {qg.__version__}\n"
    failed = subprocess.run([*run, "info", "none.off"], capture_output=True, text=True)
    assert failed.returncode == 2
    assert failed.stderr.startswith("qgeo: ")
