"""Groups of sources as tasks for threads."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed

from tqdm.auto import tqdm

from qgeo_filters.errors import ParameterError

# Sources of one task: a few blocks of lanes, so that memory and the loss at an interruption stay small.
GROUP = 64


def worker_count(workers: int | None) -> int:
    """Number of threads asked for, or the cores that this process may use."""
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers < 1:
        raise ParameterError(f"workers must be at least 1, got {workers}")
    return int(workers)


def run_tasks(
    task: Callable[[int], object],
    parts: Sequence[int],
    workers: int,
    progress: bool,
    finished: Callable[[int], None] | None = None,
    before: int = 0,
) -> None:
    """Call the task on every part, in threads, under a progress bar.

    An error or an interruption ends it after the tasks already begun, a fraction of a second each.

    Parameters
    ----------
    finished : callable, optional
        Called in this thread with each part that is done, as soon as it is.
    before : int
        Parts done earlier, for the progress bar.
    """
    with (
        tqdm(total=before + len(parts), initial=before, disable=not progress, unit="group", desc="geodesics") as bar,
        ThreadPoolExecutor(workers) as pool,
    ):
        part_of = {pool.submit(task, part): part for part in parts}
        try:
            for future in as_completed(part_of):
                future.result()
                if finished is not None:
                    finished(part_of[future])
                bar.update()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
