"""Nothing of the user's is lost: commands replace and remove only what an earlier command made and nobody changed."""

from __future__ import annotations

import hashlib
import json
import os
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.cli import mesh as info_command
from qgeo_filters.cli.job_text import numbered
from qgeo_filters.cli.outputs import OutputFolder, listed_digests, same_file
from qgeo_filters.errors import ParameterError

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


def content(folder: Path) -> dict[str, bytes | str]:
    """All that is below a folder: the bytes of files, where links lead."""
    return {
        str(path.relative_to(folder)): os.readlink(path) if path.is_symlink() else path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or path.is_file()
    }


def refused(result: Result, *words: str) -> None:
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.output
    for word in (*words, "-o"):
        assert word in result.stderr


@pytest.fixture
def unread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails where a mesh is read: what is refused is refused before."""

    def read(*arguments: object) -> None:
        raise AssertionError("a mesh was read before the command was refused")

    monkeypatch.setattr(qg.Surface, "read", read)


COMMANDS = {
    "info": ("info", "sphere.ply"),
    "info --repair": ("info", "sphere.ply", "--repair"),
    "distances": ("distances", "sphere.ply"),
    "spectrum": ("spectrum", "sphere.ply"),
    "symmetry": ("symmetry", "sphere.ply"),
    "path": ("path", "sphere.ply", 0, 1),
    "match": ("match", "blob.off", "sphere.ply"),
    "compatibility": ("compatibility", "blob.off", "sphere.ply"),
    "run": ("run", "pipe.yaml", "sphere.ply"),
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_no_command_writes_over_its_input(qgeo: Qgeo, unread: None, command: tuple[object, ...]) -> None:
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    before = content(Path())
    refused(qgeo(*command, "-o", "."), "sphere.ply is read by this command")
    assert content(Path()) == before


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("name", ["result.json", "result.npz", "report.html", "sphere.ply"])
def test_no_command_writes_over_a_file_that_it_did_not_make(
    qgeo: Qgeo, unread: None, command: tuple[object, ...], name: str
) -> None:
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    Path("mine").mkdir()
    Path("mine", name).write_text("{}")
    before = content(Path())
    refused(qgeo(*command, "-o", "mine"), f"mine/{name} is not listed as a file that qgeo made")
    assert content(Path()) == before


@pytest.mark.parametrize(
    ("command", "picture"),
    [
        ("info sphere.ply", "surface.png"),
        ("distances sphere.ply", "mean_distance.png"),
        ("distances sphere.ply -s 3", "distance_3.png"),
        ("spectrum sphere.ply", "eigenfunctions.png"),
        ("symmetry sphere.ply", "asymmetry.png"),
        ("path sphere.ply 0 1", "path.png"),
        ("match blob.off sphere.ply", "regions.png"),
        ("match blob.off sphere.ply", "match_log.md"),
        ("match blob.off sphere.ply --truth t.txt", "errors.png"),
        ("compatibility blob.off sphere.ply", "c_xy.png"),
        ("run pipe.yaml sphere.ply", "qgeo_distance.png"),
        ("demo", "scalar.png"),
    ],
)
def test_pictures_that_come_late_are_looked_for_first(qgeo: Qgeo, unread: None, command: str, picture: str) -> None:
    if command == "demo":
        pytest.importorskip("pymeshlab")
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    Path("mine", picture).parent.mkdir(parents=True)
    Path("mine", picture).write_bytes(b"a texture, say")
    refused(qgeo(*command.split(), "-o", "mine"), f"mine/{picture} is not listed")
    assert Path("mine", picture).read_bytes() == b"a texture, say"


def test_pictures_that_are_not_wanted_are_in_nobodys_way(qgeo: Qgeo) -> None:
    Path("surface.png").write_bytes(b"mine")
    assert qgeo("info", "blob.off", "-o", ".", "--no-pictures").exit_code == 0
    assert Path("surface.png").read_bytes() == b"mine"


def test_results_may_stand_beside_other_files(qgeo: Qgeo) -> None:
    before = content(Path())
    assert qgeo("info", "blob.off", "-o", ".").exit_code == 0
    assert {name: content(Path())[name] for name in before} == before
    refused(qgeo("info", "sphere.ply", "-o", "."), "sphere.ply is read by this command")
    assert qgeo("info", "square.obj", "-o", ".", "--no-pictures").exit_code == 0
    after = content(Path())
    assert set(after) == {*before, "result.json", "result.npz", "square.ply", "report.html"}
    assert {name: after[name] for name in before} == before


def test_the_same_command_again_replaces_its_own_files(qgeo: Qgeo, loaded: Loaded) -> None:
    for number in (3, 5):
        assert qgeo("spectrum", "blob.off", "-k", number).exit_code == 0
        _, arrays = loaded(Path("qgeo-out/spectrum-blob"))
        assert len(arrays["eigenvalues"]) == number


def test_another_command_removes_what_the_earlier_one_left_and_nothing_else(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("distances", "sphere.ply", "-o", "out").exit_code == 0
    Path("out/notes.txt").write_text("mine")
    assert qgeo("info", "blob.off", "-o", "out").exit_code == 0
    assert Path("out/notes.txt").read_text() == "mine"
    Path("out/notes.txt").unlink()
    assert loaded(Path("out"))[0]["command"] == "info"  # the files are those of the second command and no others


def test_a_file_that_was_changed_since_is_the_users(qgeo: Qgeo) -> None:
    command = ("info", "blob.off", "-o", "out", "--no-pictures")
    assert qgeo(*command).exit_code == 0
    with Path("out/blob.ply").open("ab") as file:
        file.write(b"\n")
    before = content(Path("out"))
    refused(qgeo(*command), "out/blob.ply was changed since qgeo made it", "move it away")
    assert content(Path("out")) == before
    other = qgeo("info", "sphere.ply", "-o", "out", "--no-pictures")
    assert (other.exit_code, other.stderr) == (
        0,
        "qgeo: out/blob.ply was changed since qgeo made it: it is left as it is\n",
    )
    assert Path("out/blob.ply").read_bytes() == before["blob.ply"]
    refused(qgeo(*command), "out/blob.ply is not listed")


def test_a_file_of_the_same_name_made_after_ours_was_moved_away(qgeo: Qgeo) -> None:
    assert qgeo("info", "blob.off", "-o", "out", "--no-pictures").exit_code == 0
    Path("out/blob.ply").rename("kept.ply")
    Path("out/blob.ply").write_text("mine")
    assert qgeo("info", "sphere.ply", "-o", "out", "--no-pictures").exit_code == 0
    assert Path("out/blob.ply").read_text() == "mine"


def test_a_listing_that_was_changed_gives_no_right_to_anything(qgeo: Qgeo) -> None:
    assert qgeo("info", "blob.off", "-o", "out", "--no-pictures").exit_code == 0
    listing = Path("out/result.json")
    written = json.loads(listing.read_text(encoding="utf-8"))
    Path("out/letter.txt").write_text("mine")
    digest = hashlib.sha256(b"mine").hexdigest()
    forged = {**written, "files": [*written["files"], "letter.txt"]}
    forged["sha256"] = {"letter.txt": digest, **written["sha256"]}
    listing.write_text(json.dumps(forged, indent=2) + "\n", encoding="utf-8")
    before = content(Path("out"))
    refused(qgeo("info", "sphere.ply", "-o", "out"), "out/result.json is not listed")
    assert content(Path("out")) == before


@pytest.mark.parametrize(
    "listing",
    [
        {"qgeo_filters": "0.1", "files": ["result.json", "letter.txt"]},
        {"qgeo_filters": "0.1", "files": ["letter.txt"], "sha256": {"letter.txt": "0" * 64}},
        {"sha256": ["letter.txt"]},
        {"sha256": {"result.json": "", "letter.txt": hashlib.sha256(b"mine").hexdigest()}},
        {"sha256": {"result.json": None, "letter.txt": hashlib.sha256(b"mine").hexdigest()}},
        ["letter.txt"],
        "letter.txt",
        None,
    ],
)
def test_what_is_no_listing_of_ours_gives_no_right_to_anything(qgeo: Qgeo, listing: object) -> None:
    Path("out").mkdir()
    Path("out/letter.txt").write_text("mine")
    Path("out/result.json").write_text(json.dumps(listing))
    assert listed_digests(Path("out/result.json")) == {}
    before = content(Path("out"))
    refused(qgeo("info", "sphere.ply", "-o", "out"), "out/result.json is not listed")
    assert content(Path("out")) == before


def test_the_listing_holds_the_digest_of_every_file(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("spectrum", "blob.off", "-k", 3, "-o", "out").exit_code == 0
    listed, _ = loaded(Path("out"))
    assert list(listed["sha256"]) == [*listed["files"][1:], "result.json"]
    for name in listed["files"][1:]:
        assert listed["sha256"][name] == hashlib.sha256(Path("out", name).read_bytes()).hexdigest()
    assert listed_digests(Path("out/result.json")) == listed["sha256"]


@pytest.mark.parametrize("link", [os.symlink, os.link], ids=["symbolic", "hard"])
def test_an_input_is_known_by_every_name(qgeo: Qgeo, link: Callable[[str, str], None]) -> None:
    """An earlier result, unchanged, that is now read through a link elsewhere."""
    assert qgeo("info", "blob.off", "-o", "out", "--no-pictures").exit_code == 0
    Path("links").mkdir()
    link(os.path.abspath("out/blob.ply"), "links/blob.ply")
    before = content(Path())
    refused(qgeo("info", "links/blob.ply", "-o", "out"), "out/blob.ply is read by this command")
    assert content(Path()) == before
    link(os.path.abspath("out/blob.ply"), "links/other.ply")
    result = qgeo("info", "links/other.ply", "-o", "out", "--no-pictures")
    assert (result.exit_code, result.stderr.count("\n")) == (0, 1)
    assert "out/blob.ply is read by this command: it is left as it is" in result.stderr
    assert Path("out/blob.ply").read_bytes() == before["out/blob.ply"]


def test_a_folder_is_known_by_every_name(qgeo: Qgeo) -> None:
    Path("data").mkdir()
    Path("sphere.ply").rename("data/sphere.ply")
    Path("link").symlink_to("data")
    before = content(Path())
    for output in ("link", "data/../link", Path("link").absolute()):
        refused(qgeo("info", "data/sphere.ply", "-o", output), "is read by this command")
    assert content(Path()) == before


def test_links_in_the_folder_are_the_users(qgeo: Qgeo) -> None:
    Path("out").mkdir()
    Path("out/blob.ply").symlink_to("../nowhere.ply")
    refused(qgeo("info", "blob.off", "-o", "out"), "out/blob.ply is not listed")
    Path("out/blob.ply").unlink()
    command = ("info", "blob.off", "-o", "out", "--no-pictures")
    assert qgeo(*command).exit_code == 0
    Path("out/blob.ply").rename("moved.ply")
    Path("out/blob.ply").symlink_to("../moved.ply")
    refused(qgeo(*command), "out/blob.ply was changed")
    assert Path("out/blob.ply").is_symlink()
    Path("out/blob.ply").unlink()
    Path("out/blob.ply").mkdir()
    refused(qgeo(*command), "out/blob.ply was changed")


def test_results_that_are_read_are_kept(qgeo: Qgeo) -> None:
    command = ("match", "blob.off", "blob.off", "-o", "out", "--no-pictures")
    assert qgeo(*command).exit_code == 0
    before = content(Path("out"))
    refused(qgeo(*command, "--truth", "out/result.npz"), "out/result.npz is read by this command")
    refused(qgeo("compatibility", "out/blob-1.ply", "out/blob-2.ply", "-o", "out"), "out/blob-1.ply", "1 more such")
    assert content(Path("out")) == before


def test_a_matrix_is_not_written_where_a_result_goes(qgeo: Qgeo, unread: None) -> None:
    refused(qgeo("distances", "blob.off", "--matrix", "out/result.npz", "-o", "out"), "out/result.npz")
    assert not Path("out").exists()


def test_an_evaluation_keeps_the_shapes_that_it_reads(qgeo: Qgeo) -> None:
    assert qgeo("compatibility", "blob.off", "blob.off", "-o", "set", "--no-pictures").exit_code == 0
    before = content(Path("set"))
    result = qgeo("evaluate", "indexed", "--root", "set", "-o", "set", "--pairs", 1, "--no-pictures")
    assert result.exit_code == 0, result.stderr
    after = content(Path("set"))
    assert {name: after[name] for name in before if name.endswith(".ply")} == {
        name: data for name, data in before.items() if name.endswith(".ply")
    }


def test_what_changes_while_a_command_computes_is_seen(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    command = ("info", "blob.off", "-o", "out", "--no-pictures")
    true = info_command.details

    def interfering(surface: qg.Surface) -> dict[str, Any]:
        Path("out").mkdir(exist_ok=True)
        Path("out/blob.ply").write_text("mine")
        return true(surface)

    monkeypatch.setattr(info_command, "details", interfering)
    refused(qgeo(*command), "out/blob.ply is not listed")
    assert Path("out/blob.ply").read_text() == "mine"
    monkeypatch.setattr(info_command, "details", true)
    Path("out/blob.ply").unlink()
    assert qgeo(*command).exit_code == 0
    monkeypatch.setattr(info_command, "details", interfering)
    result = qgeo(*command)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 2)
    assert Path("out/blob.ply").read_text() == "mine"


def test_a_killed_command_leaves_nothing_that_the_next_one_cannot_replace(tmp_path: Path) -> None:
    """After each step of the disk a kill, and then a command that writes everything."""
    names = ("a.bin", "b.bin")

    def write(number: int, stop: int) -> None:
        steps = 0

        def counted(function: Callable[..., Any]) -> Callable[..., Any]:
            def step(*arguments: Any, **options: Any) -> Any:
                nonlocal steps
                steps += 1
                if steps == stop:
                    raise KeyboardInterrupt
                return function(*arguments, **options)

            return step

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(os, "replace", counted(os.replace))
            patch.setattr(Path, "unlink", counted(Path.unlink))
            folder = OutputFolder(tmp_path / "out", names, (), lambda: {"number": number})
            for name in names:
                with folder.writing(name) as temporary:
                    temporary.write_text(f"{name} {number}")

    write(0, 0)
    for stop in range(1, 7):  # two files are removed, two written, and the listing with each
        with pytest.raises(KeyboardInterrupt):
            write(stop, stop)
        write(100 + stop, 0)
        assert {path.name for path in (tmp_path / "out").iterdir()} == {"result.json", *names}
        assert (tmp_path / "out/b.bin").read_text() == f"b.bin {100 + stop}"


def test_two_commands_in_one_folder_at_once(tmp_path: Path) -> None:
    """The later one replaces the earlier, which says so instead of mixing its files with the other's."""
    one, other = (OutputFolder(tmp_path, ("a.bin",), (), lambda: {}) for _ in range(2))
    for folder, data in ((one, b"one"), (other, b"other")):
        with folder.writing("a.bin") as temporary:
            temporary.write_bytes(data)
    with pytest.raises(ParameterError, match="was changed since qgeo made it"), one.writing("a.bin") as temporary:
        temporary.write_bytes(b"one, later")
    with pytest.raises(ParameterError, match="was changed since qgeo made it"):
        one.list_files()
    assert (tmp_path / "a.bin").read_bytes() == b"other"
    assert listed_digests(tmp_path / "result.json").items() > other.digests.items()


def test_a_listing_says_nothing_of_files_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    names = ("../letter.txt", "a.bin")
    first = OutputFolder(tmp_path / "out", names, (), lambda: {})
    first.digests["../letter.txt"] = hashlib.sha256(b"mine").hexdigest()
    with first.writing("a.bin") as temporary:
        temporary.write_bytes(b"a")
    second = OutputFolder(tmp_path / "out", ("a.bin",), (), lambda: {})
    with second.writing("a.bin") as temporary:
        temporary.write_bytes(b"b")
    assert (tmp_path / "letter.txt").read_text() == "mine"


def test_one_file_by_several_names(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("a")
    (tmp_path / "b").symlink_to("a")
    os.link(tmp_path / "a", tmp_path / "c")
    for name in ("a", "b", "c", "../" + tmp_path.name + "/a"):
        assert same_file(tmp_path / "a", tmp_path / name)
    assert same_file(tmp_path / "new", tmp_path / "." / "new")
    (tmp_path / "d").write_text("a")
    for name in ("d", "new", "new/er"):
        assert not same_file(tmp_path / "a", tmp_path / name)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["a", "b"], ["a", "b"]),
        (["a", "a"], ["a-1", "a-2"]),
        (["a", "A", "b"], ["a-1", "A-2", "b"]),
        (["a", "a", "a-1"], ["a-2", "a-3", "a-1"]),
        (["a-1", "a", "a", "A-1"], ["a-1-1", "a-1", "a-2", "A-1-2"]),
    ],
)
def test_names_are_told_apart_whatever_the_case(names: list[str], expected: list[str]) -> None:
    assert numbered(names) == expected
    assert len({unicodedata.normalize("NFC", name).casefold() for name in numbered(names)}) == len(names)
