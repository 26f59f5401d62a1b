"""Fixtures shared by all tests: real data where it is present, and read-only arrays."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# Commands keep results in the user's cache: not those of tests, in this process and in those that it starts.
os.environ["QGEO_CACHE_DIR"] = ""


def shared_data() -> Path:
    """Folder of the evaluation data: $QGEO_DATA, or ../shared/data beside the checkout."""
    return Path(os.environ.get("QGEO_DATA", ROOT.parent / "shared" / "data"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Coverage is not measured in slow tests, which it makes a third slower: quick ones run the same lines."""
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker("no_cover")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the evaluation data; the test is skipped, saying so, where it is absent."""
    folder = shared_data()
    if not folder.is_dir():
        pytest.skip(f"evaluation data not found at {folder} (set QGEO_DATA)")
    return folder
