"""Tables of the READMEs are those that scripts have measured and kept, and what is kept is whole."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT

BENCHMARKS = ROOT / "benchmarks"
RESULTS = sorted((BENCHMARKS / "results").glob("*.json"))


def module(name: str) -> ModuleType:
    """A file of benchmarks/."""
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


record = module("record")
readme_tables = module("readme_tables")


@pytest.mark.parametrize("file", readme_tables.FILES, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_the_tables_are_those_of_the_results(file: Path) -> None:
    """`python benchmarks/readme_tables.py` would change nothing."""
    text = file.read_text(encoding="utf-8")
    assert readme_tables.names(text)
    assert text.count("<!-- results ") == len(re.findall("^<!-- results ", text, re.MULTILINE))
    assert text.count("<!-- results ") == text.count("<!-- end of results -->")
    assert readme_tables.with_tables(text, "benchmarks/" if file.parent == ROOT else "") == text


def test_every_result_is_shown() -> None:
    shown = {name for file in readme_tables.FILES for name in readme_tables.names(file.read_text(encoding="utf-8"))}
    assert shown == {file.stem for file in RESULTS}


@pytest.mark.parametrize("file", RESULTS, ids=lambda file: file.stem)
def test_a_result_says_how_it_was_made(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    content = json.loads(text)
    assert record.as_json(content) == text
    script = re.match(r"(?:[A-Z_]+=\d+ )*python benchmarks/(\w+\.py)", content["command"])
    assert script
    assert (BENCHMARKS / script[1]).is_file()
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", content["date"])
    assert re.fullmatch(r"[0-9a-f]{7,}", content["commit"]), "measured on changes that no commit has"
    assert "cores, Python 3." in content["machine"]
    assert len(content["load"]) == 2
    assert "/home/" not in text
    assert "/" not in content["command"].replace("benchmarks/", "", 1)
    for table in content["tables"]:
        assert len(table["align"]) == len(table["columns"])
        assert table["rows"]
        assert all(len(row) == len(table["columns"]) for row in table["rows"])


def test_a_run_is_printed_and_kept_alike(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    kept = tmp_path / "kept.json"
    with record.recorded(["--pairs", "3", "--json", str(kept), "some/where/cat0.off"]) as run:
        assert run.arguments == ["--pairs", "3", "some/where/cat0.off"]
        table = run.table("first", "method", 'CPU "s"', align="lr")
        table.row("ours, [graph]", 0.25)
        run.markdown("second", "| a | b |\n| --- | ---: |\n| 1 | 2 |\n| 3 |  |")
        run.note("It grows.")
        with pytest.raises(ValueError, match="1 cells for 2 columns"):
            table.row("too few")
    content = json.loads(kept.read_text(encoding="utf-8"))
    assert content["command"].startswith("OPENBLAS_NUM_THREADS=1 ")
    assert content["command"].endswith(" --pairs 3 cat0.off")
    assert [(one["title"], one["align"]) for one in content["tables"]] == [("first", "lr"), ("second", "lr")]
    assert content["tables"][0]["rows"] == [["ours, [graph]", "0.25"]]
    assert content["tables"][1]["rows"] == [["1", "2"], ["3", ""]]
    assert content["notes"] == ["It grows."]
    assert '    ["ours, [graph]", "0.25"]\n' in kept.read_text(encoding="utf-8")
    printed = capsys.readouterr().out
    assert '**first**\n\n| method | CPU "s" |\n|---|---:|\n| ours, [graph] | 0.25 |\n' in printed
    assert printed.endswith("\nIt grows.\n")


def test_a_run_that_fails_keeps_nothing(tmp_path: Path) -> None:
    kept = tmp_path / "kept.json"
    with pytest.raises(ZeroDivisionError), record.recorded(["--json", str(kept)]):
        _ = 1 / 0
    assert not kept.exists()


def test_blocks_are_filled_by_title(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two tables one, with a pattern; both with their titles, and the notes, without; a title that is gone fails."""
    with record.recorded(["--json", str(tmp_path / "some.json")]) as run:
        for title in ("one", "two"):
            run.table(title, "a").row(title.upper())
        run.note("It grows.")
    monkeypatch.setattr(readme_tables, "RESULTS", tmp_path)
    end = "<!-- end of results -->"
    one = readme_tables.with_tables(f"x\n<!-- results some: o.* -->\nold\n{end}\ny\n", "b/")
    assert "| ONE |" in one
    assert not re.search(r"TWO|old|\*\*one|It grows", one)
    assert "[some.json](b/results/some.json)" in one
    assert readme_tables.with_tables(one, "b/") == one
    both = readme_tables.with_tables(f"<!-- results some -->\n{end}\n", "")
    assert re.findall(r"\*\*(\w+)\*\*", both) == ["one", "two"]
    assert "\n\nIt grows.\n\n" in both
    with pytest.raises(ValueError, match=r"some\.json has no table 'gone'"):
        readme_tables.with_tables(f"<!-- results some: gone -->\n{end}\n", "")


def test_a_block_may_show_some_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first and those that are named, in the order in which they are, each aligned as it was; none that is not."""
    with record.recorded(["--json", str(tmp_path / "some.json")]) as run:
        run.table("one", "pair", "mean", "CPU s", "right, of 3", align="lrrl").row("x-y", ".1", "7", "2")
    monkeypatch.setattr(readme_tables, "RESULTS", tmp_path)
    end = "<!-- end of results -->"
    block = readme_tables.with_tables(f"<!-- results some: one; right, of 3 | mean -->\nold\n{end}\n", "")
    assert "| pair | right, of 3 | mean |\n|---|---|---:|\n| x-y | 2 | .1 |\n" in block
    assert readme_tables.with_tables(block, "") == block
    assert readme_tables.names(block) == {"some"}
    with pytest.raises(ValueError, match="table 'one' has no column 'median'"):
        readme_tables.with_tables(f"<!-- results some: one; mean | median -->\n{end}\n", "")
