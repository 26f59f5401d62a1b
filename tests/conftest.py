"""Fixtures shared by all tests: real data where it is present, and read-only arrays."""

from __future__ import annotations

import gc
import os
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
    parser.addoption("--thorough", action="store_true", help="also the tests that are marked thorough")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out thorough tests that nobody asked for; measure no coverage in slow ones."""
    if not config.getoption("--thorough"):
        named = [arg for arg in config.args if "::" in arg]
        left_out = [
            item
            for item in items
            if item.get_closest_marker("thorough") and not any(item.nodeid.startswith(name) for name in named)
        ]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
    for item in items:
        if item.get_closest_marker("slow"):
            # Coverage makes them a third slower, and quick ones run the same lines.
            item.add_marker("no_cover")


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
