"""Downloads, from archives on this machine."""

from __future__ import annotations

import hashlib
import os
import shutil
import threading
import warnings
import zipfile
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError, MissingPackageError, ParameterError
from qgeo_filters.evaluation import IndexedDataset, VtsDataset, download, fetch
from qgeo_filters.evaluation.download import SOURCES, Source
from qgeo_filters.surface import Surface


class Quiet(SimpleHTTPRequestHandler):
    """Serves files and counts."""

    asked: list[str] = []

    def log_message(self, format: str, *args: object) -> None:
        self.asked.append(self.path)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[str]:
    """Address at which the folder ``served`` can be downloaded from."""
    (tmp_path / "served").mkdir()
    Quiet.asked = []
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path / "served"))) as one:
        threading.Thread(target=one.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{one.server_port}"
        one.shutdown()


@pytest.fixture
def poses(tmp_path: Path, server: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A data set of two poses and its template's points, in two archives; the URL of the first."""
    shape = Surface(*blob(1))
    for number in range(2):
        shape.write(tmp_path / f"pose{number}.off")
        np.savetxt(tmp_path / f"pose{number}.vts", np.arange(1, shape.n_vertices + 1), fmt="%d")
    for name, suffix in (("meshes", ".off"), ("points", ".vts")):
        with zipfile.ZipFile(tmp_path / f"served/{name}.zip", "w") as archive:
            archive.writestr("read me.txt", "nothing")
            archive.writestr(f"__MACOSX/deep/._pose0{suffix}", "shadow")
            for number in range(2):
                archive.write(tmp_path / f"pose{number}{suffix}", f"deep/folder/pose{number}{suffix}")
    urls = (f"{server}/meshes.zip", f"{server}/points.zip")
    source = Source(urls, {".off": "off", ".vts": "corres"}, VtsDataset, "nobody's")
    monkeypatch.setattr(download, "SOURCES", {"poses": source})
    return urls[0]


def hashes(tmp_path: Path, url: str) -> dict[str, str]:
    """Of both archives."""
    folder = tmp_path / "served"
    base = url.rsplit("/", 1)[0]
    return {f"{base}/{file.name}": hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}


def test_a_data_set_is_downloaded_once_and_read(tmp_path: Path, poses: str) -> None:
    known = hashes(tmp_path, poses)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = fetch("poses", tmp_path / "kept", known_hash=known)
    assert isinstance(data, VtsDataset)
    assert data.names() == ["pose0", "pose1"]
    truth = data.truth("pose0", "pose1")
    np.testing.assert_array_equal(truth.images, truth.points)
    assert len(Quiet.asked) == 2
    again = fetch("poses", tmp_path / "kept", known_hash=known)
    assert again.files == data.files
    assert len(Quiet.asked) == 2
    assert {path.name for path in (tmp_path / "kept").iterdir()} == {"archives", "poses"}


def test_without_a_known_hash_the_hash_is_told(tmp_path: Path, poses: str) -> None:
    with pytest.warns(UserWarning, match="was not held against a known hash") as told:
        fetch("poses", tmp_path / "kept")
    messages = [str(one.message) for one in told]
    for url, digest in hashes(tmp_path, poses).items():
        assert any(url in message and digest in message for message in messages)


def test_a_wrong_archive_is_refused(tmp_path: Path, poses: str) -> None:
    known = hashes(tmp_path, poses)
    with pytest.raises(ValueError, match="does not match the known hash"):
        fetch("poses", tmp_path / "kept", known_hash={**known, poses: "0" * 64})
    assert not (tmp_path / "kept/poses").exists()


@pytest.mark.filterwarnings("ignore:.*was not held")
@pytest.mark.parametrize("change", ["a file more", "a file changed", "a link", "a folder of the user's"])
def test_a_folder_that_holds_a_file_of_the_users_is_not_unpacked_anew(tmp_path: Path, poses: str, change: str) -> None:
    root = tmp_path / "kept/poses"
    if change != "a folder of the user's":
        fetch("poses", tmp_path / "kept")
    root.mkdir(parents=True, exist_ok=True)
    mine = root / ("off/pose0.off" if change == "a file changed" else "mine.off")
    mine.unlink(missing_ok=True)
    if change == "a link":
        mine.symlink_to(tmp_path / "pose0.off")
    else:
        mine.write_text("mine")
    before = {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
    asked = len(Quiet.asked)
    shutil.rmtree(tmp_path / "kept/archives", ignore_errors=True)
    with pytest.raises(ParameterError, match=rf"{mine.name} is not as it came from an archive.* move .*poses away"):
        fetch("poses", tmp_path / "kept")
    assert len(Quiet.asked) == asked  # said before anything is downloaded
    assert {path: path.read_bytes() for path in root.rglob("*") if path.is_file()} == before


@pytest.mark.filterwarnings("ignore:.*was not held")
def test_what_was_unpacked_and_not_changed_is_unpacked_anew(tmp_path: Path, poses: str) -> None:
    root = tmp_path / "kept/poses"
    fetch("poses", tmp_path / "kept")
    before = {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
    later = root.stat().st_mtime + 10
    for archive in (tmp_path / "kept/archives").glob("*.zip"):
        os.utime(archive, (later, later))
    inode = root.stat().st_ino
    fetch("poses", tmp_path / "kept")
    assert root.stat().st_ino != inode
    assert {path: path.read_bytes() for path in root.rglob("*") if path.is_file()} == before
    assert {path.name for path in (tmp_path / "kept").iterdir()} == {"archives", "poses"}
    os.utime(root, (0, 0))
    (root / "off/pose0.off").write_text("mine")
    with pytest.raises(ParameterError, match=r"pose0\.off is not as it came"):
        fetch("poses", tmp_path / "kept")
    assert (root / "off/pose0.off").read_text() == "mine"


def test_an_archive_that_is_another_one_is_not_replaced(tmp_path: Path, poses: str) -> None:
    known = hashes(tmp_path, poses)
    fetch("poses", tmp_path / "kept", known_hash=known)
    archive = next((tmp_path / "kept/archives").glob("*.zip"))
    archive.write_bytes(b"saved by other means")
    with pytest.raises(ParameterError, match=rf"{archive.name} does not match the known hash: move it away"):
        fetch("poses", tmp_path / "kept", known_hash=known)
    assert archive.read_bytes() == b"saved by other means"


@pytest.mark.filterwarnings("ignore:.*was not held")
def test_an_archive_without_meshes_leaves_nothing_behind(tmp_path: Path, poses: str) -> None:
    served = tmp_path / "served/points.zip"
    served.write_bytes(b"not a zip")
    with pytest.raises(MeshError, match="is no zip archive"):
        fetch("poses", tmp_path / "one")
    with zipfile.ZipFile(served, "w") as archive:
        archive.writestr("read me.txt", "nothing")
    with pytest.raises(MeshError, match=r"holds no \.off or \.vts files"):
        fetch("poses", tmp_path / "two")
    for name in ("one", "two"):
        assert [path.name for path in (tmp_path / name).iterdir()] == ["archives"]


def test_arguments(tmp_path: Path, poses: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="no data set 'cow': there are poses"):
        fetch("cow")
    with pytest.raises(ValueError, match="comes in 2 archives"):
        fetch("poses", tmp_path, known_hash="0" * 64)
    monkeypatch.setitem(__import__("sys").modules, "pooch", None)
    with pytest.raises(MissingPackageError, match=r"qgeo-filters\[download\]"):
        fetch("poses", tmp_path)


def test_the_sources_are_of_use() -> None:
    """Zip archives by https, read by a reader that knows their kind of file."""
    assert {"tosca", "faust-remeshed", "scape-remeshed"} <= set(SOURCES)
    for source in SOURCES.values():
        assert source.terms
        assert all(url.startswith("https://") and url.endswith(".zip") for url in source.urls)
        assert source.reader is not IndexedDataset or set(source.folders) & set(IndexedDataset.SUFFIXES)
