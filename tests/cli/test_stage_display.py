"""What a terminal shows while a command works: how far it is, and how much longer it will take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console
from typer.testing import Result

from qgeo_filters.cli import app, job, stage_display
from qgeo_filters.cli.options import Settings
from qgeo_filters.cli.stage_display import TIMES, StageDisplay, expected_seconds, keep_times
from qgeo_filters.parallel import report_progress

Qgeo = Callable[..., Result]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Time that passes when a test says so."""
    now = SimpleNamespace(seconds=100.0)
    monkeypatch.setattr(stage_display, "time", SimpleNamespace(monotonic=lambda: now.seconds))
    return now


def shown(work: Callable[[], None], expected: float | None = None) -> str:
    """What a terminal of 100 columns gets while a stage works."""
    screen = StringIO()
    console = Console(file=screen, force_terminal=True, width=100, color_system=None)
    with StageDisplay(console, True).stage("match", expected):
        work()
        report_progress("map", 8, 8)
    return screen.getvalue()


def test_the_time_left_is_told_from_the_steps(clock: SimpleNamespace) -> None:
    steps = stage_display.StepRate()
    assert steps.seconds_left("map", 1, 11) is None
    clock.seconds += 6
    assert steps.seconds_left("map", 4, 11) == pytest.approx(14)  # 3 took 6 s
    assert steps.seconds_left("map", 1, 11) is None  # it begins again
    clock.seconds += 1
    assert steps.seconds_left("other", 1, 2) is None


def test_a_stage_shows_its_steps_and_stays_with_its_time(clock: SimpleNamespace) -> None:
    def work() -> None:
        report_progress("map", 1, 8)
        clock.seconds += 5

    last = shown(work).splitlines()[-1]
    assert "map 8 of 8" in shown(work)
    assert last.endswith("… match  5.0 s")
    assert shown(lambda: None).splitlines()[-1].endswith("… match")


def test_the_time_of_last_time_is_the_estimate(clock: SimpleNamespace) -> None:
    def work() -> None:
        clock.seconds += 10

    assert "about 30 s left" in shown(work, 40.0)
    assert "left" not in shown(work, 10.5).splitlines()[-1]


def test_nothing_is_shown_where_it_is_not_wanted() -> None:
    screen = StringIO()
    with StageDisplay(Console(file=screen, force_terminal=True), False).stage("match"):
        report_progress("map", 1, 8)
    assert screen.getvalue() == ""


def test_times_are_kept_for_the_next_estimate(tmp_path: Path) -> None:
    assert expected_seconds(tmp_path, "match", "match", 1000) is None
    keep_times(tmp_path, "match", {"match": 20.0, "read": 0.1}, 1000)
    keep_times(tmp_path, "symmetry", {"map": 3.0}, 500)
    assert expected_seconds(tmp_path, "match", "match", 2000) == 40.0
    assert expected_seconds(tmp_path, "match", "read", 2000) is None
    assert expected_seconds(tmp_path, "symmetry", "map", 500) == 3.0
    assert expected_seconds(None, "match", "match", 2000) is None
    for content in ("", "[]", '{"match: match": 3}', '{"match: match": ["x", 1]}', '{"match: match": [0, 1]}'):
        (tmp_path / TIMES).write_text(content)
        assert expected_seconds(tmp_path, "match", "match", 2000) is None
    keep_times(tmp_path / "gone" / "away", "match", {"match": 20.0}, 1000)  # nowhere to keep it: no matter


def test_commands_have_the_options_that_all_have() -> None:
    """Whatever computes takes threads, a cache, quiet and JSON; others what makes sense."""
    lacking = {
        "info": {"--threads", "--cache"},
        "fetch": {"--threads", "--cache", "--json"},
        "warmup": {"--threads", "--cache", "--json"},
    }
    import typer.main

    commands = typer.main.get_group(app).commands  # type: ignore[attr-defined]
    for name, command in commands.items():
        if name == "collection":
            continue
        options = {option for parameter in command.params for option in parameter.opts}
        assert {"--threads", "--cache", "--quiet", "--json"} - options == lacking.get(name, set()), name


def test_seconds_of_stages_of_one_name_are_added_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Two meshes that are read are both counted, where the last one alone was; what is left is that of both."""
    now = SimpleNamespace(seconds=0.0)
    monkeypatch.setattr(job, "time", SimpleNamespace(perf_counter=lambda: now.seconds))
    told: list[float | None] = []

    @contextmanager
    def stage(name: str, expected: float | None) -> Iterator[None]:
        told.append(expected)
        yield

    monkeypatch.setattr(job, "StageDisplay", lambda *_: SimpleNamespace(stage=stage))
    monkeypatch.setattr(job, "expected_seconds", lambda *_: 5.0)
    one = job.Job("match", Settings(tmp_path / "out", quiet=True), {})
    for name, seconds in (("read", 2.0), ("match", 7.0), ("read", 4.0), ("read", 1.0)):
        with one.stage(name):
            now.seconds += seconds
    assert one.seconds == {"read": 7.0, "match": 7.0}
    assert told == [5.0, 5.0, 3.0, 0.0]
