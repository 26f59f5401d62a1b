"""A run of all tests takes a quarter of those that are marked slow; what is named is run whole."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = """
[pytest]
testpaths = tests
markers =
    slow: takes long
    thorough: takes longer
"""
QUICK = "def test_quick(): pass\n"
SLOW = """
import pytest

@pytest.mark.slow
@pytest.mark.parametrize("n", range(7))
def test_slow(n): pass

@pytest.mark.slow
@pytest.mark.thorough
def test_thorough(): pass
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("project")
    tests = root / "tests"
    tests.mkdir()
    shutil.copy(Path(__file__).with_name("conftest.py"), tests)
    (root / "pytest.ini").write_text(PROJECT)
    (tests / "test_a.py").write_text(QUICK)
    (tests / "test_b.py").write_text(SLOW + QUICK)
    return root


def collected(project: Path, *options: str) -> list[str]:
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", *options]
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": ""}
    done = subprocess.run(command, cwd=project, env=alone, capture_output=True, text=True, check=True)
    return [line.removeprefix("tests/") for line in done.stdout.splitlines() if "::" in line]


def test_four_runs_take_each_slow_test_once(project: Path) -> None:
    quarters = [collected(project, f"--quarter={quarter}") for quarter in range(4)]
    slow = [name for quarter in quarters for name in quarter if "slow" in name]
    assert sorted(slow) == [f"test_b.py::test_slow[{n}]" for n in range(7)]
    assert {sum("slow" in name for name in quarter) for quarter in quarters} == {1, 2}
    assert all({"test_a.py::test_quick", "test_b.py::test_quick"} <= set(quarter) for quarter in quarters)
    # What takes long is begun with.
    assert quarters[0][-1] == "test_a.py::test_quick"


def test_what_is_named_is_run_whole_and_all_if_asked(project: Path) -> None:
    assert sum("slow" in name for name in collected(project, "tests/test_b.py")) == 7
    assert collected(project, "tests/test_b.py::test_thorough") == ["test_b.py::test_thorough"]
    assert len(collected(project, "--thorough")) == 2 + 7 + 1
    assert collected(project) == collected(project, "--quarter=0")  # without a commit
