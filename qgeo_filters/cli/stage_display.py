"""What a terminal shows of the stage under way: how long it has taken, how far it is, how much longer it will take."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.progress_bar import ProgressBar
from rich.text import Text

from qgeo_filters.atomic import atomic_write
from qgeo_filters.parallel import watched

#: Name of the file, in the folder that commands keep their stages in, with the times that these took.
TIMES = "seconds.json"
_SHORT = 1.0  # seconds below which nothing is said of the time


class StageDisplay:
    """A line for each stage, which moves while it goes on and stays with its time when it has ended.

    Parameters
    ----------
    console : Console
        On a terminal; on anything else nothing is shown.
    shows : bool
    """

    def __init__(self, console: Console, shows: bool) -> None:
        self._console, self._shows = console, shows

    @contextmanager
    def stage(self, name: str, expected: float | None = None) -> Iterator[None]:
        """Context of a stage that is expected to take so many seconds, if that is known."""
        if not self._shows:
            yield
            return
        started = time.monotonic()
        columns = (
            TextColumn("… {task.description}"), _Bar(), TextColumn("{task.fields[step]}"), TimeElapsedColumn(), _Left(),
        )  # fmt: skip
        with Progress(*columns, console=self._console, transient=True) as line:
            task = line.add_task(name, total=None, step="", ends=None if expected is None else started + expected)
            steps = StepRate()

            def moved(step: str, done: int, total: int) -> None:
                count = f"{step} {done} of {total}" if total > 1 else ""
                line.update(task, step=count, completed=done, total=total)
                if expected is None:
                    left = steps.seconds_left(step, done, total)
                    line.update(task, ends=None if left is None else time.monotonic() + left)

            with watched(moved):
                yield
        spent = time.monotonic() - started
        self._console.print(f"… {name}" + (f"  {spent:.1f} s" if spent > _SHORT else ""), style="dim")


class _Bar(BarColumn):
    """How much of the time is over that the stage is expected to take, or of the step that it is at."""

    def __init__(self) -> None:
        super().__init__(bar_width=24)

    def render(self, task: Task) -> ProgressBar:
        """The bar at this moment."""
        ends, spent = task.fields["ends"], task.elapsed or 0.0
        if ends is None:
            return super().render(task)
        return ProgressBar(total=max(spent + ends - time.monotonic(), spent, 1e-9), completed=spent, width=24)


class _Left(ProgressColumn):
    """How much longer it will take, where that is known."""

    def render(self, task: Task) -> Text:
        """The words at this moment."""
        ends = task.fields["ends"]
        left = 0.0 if ends is None else ends - time.monotonic()
        return Text(f"about {left:.0f} s left" if left > _SHORT else "")


class StepRate:
    """Time that the step under way will take, from how far it has come."""

    def __init__(self) -> None:
        self._step: tuple[str, int] | None = None
        self._started, self._first, self._last = 0.0, 0, 0

    def seconds_left(self, step: str, done: int, total: int) -> float | None:
        """Seconds until the step has ended, if they can be told."""
        now = time.monotonic()
        if (step, total) != self._step or done < self._last:
            self._step, self._started, self._first = (step, total), now, done
        self._last = done
        made = done - self._first
        return (now - self._started) / made * (total - done) if made > 0 else None


def expected_seconds(folder: Path | None, command: str, stage: str, size: int) -> float | None:
    """Seconds that a stage took on this machine when it was last computed, scaled to a number of vertices."""
    took = _times(folder).get(f"{command}: {stage}")
    match took:
        case [int(vertices), int() | float() as seconds] if vertices > 0 and size > 0:
            return float(seconds) * size / vertices
    return None


def keep_times(folder: Path | None, command: str, seconds: Mapping[str, float], size: int) -> None:
    """Keep the times of the stages that took more than a second, for the next command's estimate."""
    new = {f"{command}: {stage}": [size, spent] for stage, spent in seconds.items() if spent > _SHORT}
    if folder is not None and new and size:
        with suppress(OSError), atomic_write(folder / TIMES) as file:  # an estimate less, next time
            file.write(json.dumps({**_times(folder), **new}, indent=1).encode())


def _times(folder: Path | None) -> dict[str, Any]:
    if folder is None:
        return {}
    try:
        content = json.loads((folder / TIMES).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}
