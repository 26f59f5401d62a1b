"""``qgeo fetch`` without a network: the download is played by a file of this machine."""

from __future__ import annotations

import hashlib
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from qgeo_filters.evaluation import BENCHMARKS, VtsDataset, download
from qgeo_filters.evaluation.download import SOURCES, Source

pooch = pytest.importorskip("pooch")
requests = pytest.importorskip("requests")

Qgeo = Callable[..., Result]
URL = "https://somewhere.example/poses.zip"


@pytest.fixture
def archive(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Archive of a data set "poses" of two shapes, which `pooch.retrieve` finds."""
    path = Path("kept.zip").absolute()
    np.savetxt("points.vts", np.arange(1, 163), fmt="%d")
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(2):
            archive.write("blob.off", f"poses/one{number}.off")
            archive.write("points.vts", f"poses/one{number}.vts")

    def retrieve(url: str, known: str | None, name: str, folder: Path, progressbar: bool) -> str:
        assert url == URL
        if known not in (None, hashlib.sha256(path.read_bytes()).hexdigest()):
            raise ValueError(f"SHA256 hash of downloaded file ({name}) does not match the known hash")
        folder.mkdir(parents=True, exist_ok=True)
        return str(shutil.copy(path, folder / name))

    monkeypatch.setattr(pooch, "retrieve", retrieve)
    source = Source((URL,), {".off": "off", ".vts": "corres"}, VtsDataset, "nobody's, for tests")
    monkeypatch.setattr(download, "SOURCES", {"poses": source})
    return path


def test_all_data_sets_are_listed_with_their_terms(qgeo: Qgeo) -> None:
    result = qgeo("fetch")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert len(lines) == len(SOURCES)
    for line, (name, source) in zip(lines, SOURCES.items(), strict=True):
        assert line.split(maxsplit=1) == [name, source.terms]


def test_a_data_set_is_put_where_evaluate_finds_it(qgeo: Qgeo, archive: Path) -> None:
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    result = qgeo("fetch", "poses", "--root", "sets")
    assert result.exit_code == 0
    assert "2 shapes in sets/poses (nobody's, for tests)" in result.stdout
    assert "qgeo evaluate vts --root sets/poses" in result.stdout
    assert digest in result.stderr
    assert "--sha256" in result.stderr
    assert "known_hash" not in result.stderr
    assert VtsDataset("sets/poses").names() == ["one0", "one1"]
    again = qgeo("fetch", "poses", "--root", "sets", "--sha256", digest)
    assert (again.exit_code, again.stderr) == (0, "")
    quiet = qgeo("fetch", "poses", "--root", "sets", "-q")
    assert (quiet.exit_code, quiet.output) == (0, "")


def test_the_benchmark_of_a_data_set_is_named(qgeo: Qgeo, archive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With its test pairs and published figures: 'vts' would measure every two of a hundred shapes."""
    assert {name: source.benchmark for name, source in SOURCES.items() if source.benchmark} == {
        "faust-remeshed": "faust_r", "scape-remeshed": "scape_r"
    }  # fmt: skip
    for name in ("faust-remeshed", "scape-remeshed"):
        known = replace(SOURCES[name], urls=(URL,))
        monkeypatch.setattr(download, "SOURCES", {name: known})
        result = qgeo("fetch", name, "--root", "sets")
        assert f"qgeo evaluate {known.benchmark} --root sets/{name}" in result.stdout
        pairs = list(BENCHMARKS[known.benchmark].read(Path("sets") / name).pairs())
        assert pairs == [("one0", "one1"), ("one1", "one0")]


def test_what_cannot_be_fetched_is_one_line(qgeo: Qgeo, archive: Path) -> None:
    for command, expected in (
        (["cow"], "no data set 'cow': there are poses"),
        (["poses", "--sha256", "0" * 64], "does not match the known hash"),
        (["poses", "--sha256", "0", "--sha256", "1"], "poses comes in 1 archives, 2 hashes are given"),
        (["poses", "--root", "blob.off"], "blob.off is not a folder"),
    ):
        result = qgeo("fetch", "--root", "sets", *command)
        assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
        assert expected in result.stderr
    assert not Path("sets/poses").exists()


@pytest.mark.parametrize(("status", "reason"), [(None, "no answer"), (404, "answers with status 404")])
def test_without_a_network_the_way_round_is_told(
    qgeo: Qgeo, archive: Path, monkeypatch: pytest.MonkeyPatch, status: int | None, reason: str
) -> None:
    def refuse(*arguments: object, **options: object) -> str:
        response = None
        if status is not None:
            response = requests.Response()
            response.status_code = status
        raise requests.ConnectionError("HTTPSConnectionPool(host='somewhere.example')", response=response)

    monkeypatch.setattr(pooch, "retrieve", refuse)
    result = qgeo("fetch", "poses", "--root", "sets")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert f"{URL} cannot be downloaded" in result.stderr
    assert reason in result.stderr
    assert str(Path("sets/archives/poses-").absolute()) in result.stderr
