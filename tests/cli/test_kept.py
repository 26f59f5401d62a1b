"""What commands keep for later ones, in a folder that is bounded, and only where the user wants it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from qgeo_filters.caching import cache
from qgeo_filters.cli import kept
from qgeo_filters.filters import stages

Qgeo = Callable[..., Result]


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A list that gets a word for each matrix that is computed; nothing is kept in memory."""
    calls: list[str] = []
    true = stages.distance_matrix
    monkeypatch.setattr(stages, "distance_matrix", lambda *a, **o: calls.append("matrix") or true(*a, **o))
    cache.clear()
    return calls


def ask(qgeo: Qgeo, *more: str) -> None:
    """Ask for a spectrum as a process of its own would: with nothing in memory."""
    result = qgeo("spectrum", "blob.off", "-k", 3, "--no-pictures", "-q", *more)
    assert (result.exit_code, result.stderr) == (0, "")
    assert cache.directory is None  # the library's own default is back
    cache.clear()


def test_a_later_command_computes_nothing_again(
    qgeo: Qgeo, computed: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(kept.VARIABLE, "kept")
    ask(qgeo)
    ask(qgeo)
    assert computed == ["matrix"]
    assert all(file.suffix == ".joblib" for file in Path("kept").iterdir())
    if os.name == "posix":
        assert Path("kept").stat().st_mode & 0o077 == 0  # what is read from it may run code
    ask(qgeo, "--no-cache")
    assert computed == ["matrix"] * 2
    monkeypatch.setenv(kept.VARIABLE, "")
    ask(qgeo)
    assert computed == ["matrix"] * 3


def test_the_folder_is_bounded(qgeo: Qgeo, computed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(kept.VARIABLE, "kept")
    monkeypatch.setattr(kept, "BOUND", 60_000)  # less than the matrix, of 162 x 162 float32
    ask(qgeo)
    left = list(Path("kept").iterdir())
    assert left
    assert sum(file.stat().st_size for file in left) <= 60_000
    assert not [file for file in left if file.name.startswith("matrix")]


def test_a_folder_that_cannot_be_had_is_said_and_the_command_goes_on(
    qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(kept.VARIABLE, "blob.off/kept")
    result = qgeo("spectrum", "blob.off", "-k", 3, "--no-pictures")
    assert result.exit_code == 0
    assert result.stderr.startswith("qgeo: results are not kept for later commands: ")
    assert result.stderr.count("\n") == 1


def test_the_users_cache_is_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(kept.VARIABLE)
    folder = kept.kept_folder()
    assert folder is not None
    assert folder.parts[-2:] == ("qgeo-filters", "stages") or "qgeo-filters" in folder.parts


def test_help_says_it(qgeo: Qgeo) -> None:
    said = " ".join(qgeo("match", "--help").stdout.replace("│", " ").split())
    assert "--no-cache" in said
    assert "up to 4 GiB in QGEO_CACHE_DIR" in said
