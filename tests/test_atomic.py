"""Files that are whole or not there, and errors that name them, whatever fails on the way."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from qgeo_filters import atomic
from qgeo_filters.atomic import atomic_path, atomic_write


def raising(number: int, *names: object) -> Callable[..., Any]:
    """Function that fails as the system does, with or without a file's name."""

    def fail(*arguments: object, **options: object) -> None:
        raise OSError(number, os.strerror(number), *names)

    return fail


def write(target: Path, fail: Callable[[], Any]) -> None:
    """Half a file, after which something fails."""
    with atomic_write(target) as file:
        file.write(b"half of it")
        fail()


def interrupt() -> None:
    raise KeyboardInterrupt


def test_a_file_is_replaced_whole_or_stays_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "kept.bin"
    target.write_bytes(b"before")
    with pytest.raises(KeyboardInterrupt):
        write(target, interrupt)
    assert target.read_bytes() == b"before"
    with atomic_write(target) as file:
        file.write(b"after")
    assert target.read_bytes() == b"after"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS])
@pytest.mark.parametrize("where", ["write", "temporary", "replace"])
def test_what_the_system_says_names_the_target(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, where: str
) -> None:
    target = tmp_path / "result.npz"
    if where == "temporary":
        monkeypatch.setattr(tempfile, "mkstemp", raising(number, str(tmp_path / ".result-x.npz")))
    if where == "replace":
        monkeypatch.setattr(atomic.os, "replace", lambda source, goal: raising(number, source, None, str(goal))())
    with pytest.raises(OSError, match=r"result\.npz'$") as caught:
        write(target, raising(number) if where == "write" else lambda: None)
    assert (caught.value.errno, caught.value.filename, caught.value.filename2) == (number, str(target), None)
    assert list(tmp_path.iterdir()) == []


def test_a_write_that_falls_short_names_the_target(tmp_path: Path) -> None:
    short = "800 requested and 0 written"  # what NumPy says of a full disk
    with pytest.raises(OSError, match=rf"cannot write .*field\.npy: {short}"), atomic_path(tmp_path / "field.npy"):
        raise OSError(short)
    with pytest.raises(OSError, match=r"cannot write .*field\.npy: OSError$"), atomic_path(tmp_path / "field.npy"):
        raise OSError


def test_an_error_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, atomic_write(tmp_path / "copy.bin") as file:
        file.write((tmp_path / "nowhere.bin").read_bytes())
    assert caught.value.filename == str(tmp_path / "nowhere.bin")


@pytest.mark.parametrize("character", ["a", "é", "😀"])
def test_a_name_as_long_as_names_may_be(tmp_path: Path, character: str) -> None:
    target = tmp_path / (character * ((255 - 4) // len(character.encode())) + ".ply")
    with atomic_write(target) as file:
        file.write(b"whole")
    assert target.read_bytes() == b"whole"
    with pytest.raises(OSError, match="too long") as caught, atomic_write(tmp_path / ("a" * 252 + ".ply")) as file:
        file.write(b"whole")
    assert caught.value.filename == str(tmp_path / ("a" * 252 + ".ply"))
    assert list(tmp_path.iterdir()) == [target]
