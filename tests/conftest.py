"""Fixtures shared by all tests: real data where it is present, and read-only arrays."""

from __future__ import annotations

import gc
import os
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

# Commands keep results in the user's cache: not those of tests, in this process and in those that it starts.
os.environ["QGEO_CACHE_DIR"] = ""


# How long an example takes says how busy the machine is.
settings.register_profile("qgeo", deadline=None)
settings.load_profile("qgeo")


def shared_data() -> Path:
    """Folder of the evaluation data: $QGEO_DATA, or ../shared/data beside the checkout."""
    return Path(os.environ.get("QGEO_DATA", ROOT.parent / "shared" / "data"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--thorough``: the tests, too, that the gate has no time for."""
    parser.addoption("--thorough", action="store_true", help="also all tests that are marked slow or thorough")
    parser.addoption(
        "--quarter", type=int, choices=(0, 1, 2, 3), help="the quarter of the slow tests that a run of all tests takes"
    )


def pytest_report_header(config: pytest.Config) -> str:
    """Which of the slow tests are run."""
    if config.getoption("--thorough") or not _takes_all_files(config):
        return "slow tests: all that are named"
    return f"slow tests: --quarter={_quarter(config)} (--thorough runs all of them)"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out thorough tests that nobody asked for, and three of four slow ones; begin with files that take long."""
    slow = sorted((item for item in items if item.get_closest_marker("slow")), key=lambda item: item.nodeid)
    if not config.getoption("--thorough"):
        named = [arg for arg in config.args if "::" in arg]
        left_out = {
            item
            for item in items
            if item.get_closest_marker("thorough") and not any(item.nodeid.startswith(name) for name in named)
        }
        if _takes_all_files(config):
            slow = [item for item in slow if item not in left_out]
            quarter = _quarter(config)
            left_out.update(item for place, item in enumerate(slow) if place % 4 != quarter)
        config.hook.pytest_deselected(items=list(left_out))
        items[:] = [item for item in items if item not in left_out]
    # Files are handed out in this order; what takes long must not be what one process does while another has done.
    of_file = Counter(item.path for item in slow if item in items)
    items.sort(key=lambda item: -of_file[item.path])


def _takes_all_files(config: pytest.Config) -> bool:
    return [Path(config.invocation_params.dir, arg).resolve() for arg in config.args] == [ROOT / "tests"]


def _quarter(config: pytest.Config) -> int:
    """That which was asked for, or that of the commit: the next commit sees others."""
    asked = config.getoption("--quarter")
    if asked is not None:
        return int(asked)
    git = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    return int(git.stdout, 16) % 4 if git.returncode == 0 else 0


def pytest_collection_finish() -> None:
    """Modules stay: what looks for garbage, after each shape of a collection, need not go through all of them."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the evaluation data; the test is skipped, saying so, where it is absent."""
    folder = shared_data()
    if not folder.is_dir():
        pytest.skip(f"evaluation data not found at {folder} (set QGEO_DATA)")
    return folder
