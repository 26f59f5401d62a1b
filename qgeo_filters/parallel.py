"""The one place for threads and processes: how many, pools of them, and BLAS on one while they run.

Results never depend on the number of threads. A function that takes long has ``workers: int | None = None`` and
hands it to `worker_count`; inside a pool's thread None means one, so that nested work does not ask for all cores again.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from contextlib import ContextDecorator, contextmanager
from contextvars import ContextVar
from functools import partial
from multiprocessing import get_context
from queue import SimpleQueue
from typing import TypeVar

import numpy as np
import threadpoolctl
from threadpoolctl import threadpool_limits
from tqdm.auto import tqdm

from qgeo_filters.errors import ParameterError

Item = TypeVar("Item")
Result = TypeVar("Result")

# Sources of one task: a few blocks of lanes, so that memory and the loss at an interruption stay small.
GROUP = 64

# What None stands for where it is not all cores: one in a pool's threads, the number given to `default_workers` there.
_default: ContextVar[int | None] = ContextVar("qgeo_default_workers", default=None)


def worker_count(workers: int | None = None) -> int:
    """Number of threads asked for; None: the default in force, else the cores that this process may use.

    Raises
    ------
    ParameterError
        If it is not a whole number of at least 1.
    """
    if workers is None:
        return _default.get() or available_cores()
    if isinstance(workers, (bool, np.bool_)) or not isinstance(workers, (int, np.integer)):
        raise ParameterError(f"workers must be a whole number, or None for all cores, got {workers!r}")
    if workers < 1:
        raise ParameterError(f"workers must be at least 1, got {workers}")
    return int(workers)


def available_cores() -> int:
    """Cores that this process may use: its affinity, where the system tells, not the machine's number."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def default_workers(workers: int | None) -> Iterator[None]:
    """Context in which ``workers=None`` means this number; None leaves the default as it is.

    It holds in the calling thread and bounds everything below it: no pool that is started there has more threads.
    """
    token = _default.set(worker_count(workers))
    try:
        yield
    finally:
        _default.reset(token)


class _SingleThreadedBlas(ContextDecorator):
    """The limit of BLAS, counted: the first in sets it, the last out restores what was before.

    BLAS has one limit for the whole process, so that each of two overlapping uses would take the other's limit
    for what was there before, and leave it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._limits: threadpool_limits | None = None

    def __enter__(self) -> None:
        with self._lock:
            if self._inside == 0:
                _free_openblas()
                self._limits = threadpool_limits(1, user_api="blas")
            self._inside += 1

    def __exit__(self, *exception: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and self._limits is not None:
                _free_openblas()
                self._limits.restore_original_limits()
                self._limits = None
                _free_openblas()


def _free_openblas() -> None:
    """Let this thread change OpenBLAS's limit.

    From version 3.8 on, threadpoolctl lets only the thread that came first do so and ignores all others, silently;
    here the last to leave need not be the first that came.
    """
    clear = getattr(getattr(threadpoolctl, "OpenBLASController", None), "clear_controlling_thread", None)
    if clear is not None:
        clear(force=True)


single_threaded_blas = _SingleThreadedBlas()
"""Context, shared by all threads, in which BLAS calls use one thread each; also a decorator.

Matching runs in it: BLAS's threads spin while they wait, for which a match took 1.3 times the CPU time and no less of
the clock's, and their number changes the last bits of a sum.
"""


def in_processes(
    function: Callable[[Item], Result], items: Iterable[Item], workers: int | None = None
) -> Iterator[Result]:
    """Result of the function for each item, as they come; called in processes, at most as many as there are workers.

    For work of many matches: those of one process do not share their threads well. Function, items and results are
    pickled; the processes begin afresh, since threads of this one would be left behind in the middle of their work. An
    error, or an end before all are taken, ends it after the calls already begun.
    """
    chosen = list(items)
    with ProcessPoolExecutor(min(worker_count(workers), max(len(chosen), 1)), get_context("spawn")) as pool:
        waiting = [pool.submit(function, item) for item in chosen]
        try:
            for done in as_completed(waiting):
                yield done.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


Watcher = Callable[[str, int, int], None]
_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Call a function with the name of a step, how much of it is done and how much there is, as work within goes on.

    It is called in this thread, between tasks, and an exception that it raises ends the work: that is how a user
    interface shows progress and cancels. Of work in threads it hears, too: what the items of `in_threads` report under
    the same name is added up.
    """
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def report_progress(step: str, done: int, total: int) -> None:
    """Tell whoever watches this thread how much of a step is done."""
    watcher = _watcher.get()
    if watcher is not None:
        watcher(step, done, total)


class _Relay:
    """What the threads of a pool report, told again in the thread that waits for them."""

    def __init__(self) -> None:
        self._heard: SimpleQueue[tuple[int, tuple[str, int, int] | None]] = SimpleQueue()
        self._latest: dict[str, dict[int, tuple[int, int]]] = {}
        self._ended = False

    def submit(self, pool: ThreadPoolExecutor, function: Callable[[], Result], number: int) -> Future[Result]:
        """A call in the pool, whose reports are heard; numbered from 0."""

        def heard(step: str, done: int, total: int) -> None:
            if self._ended:
                raise CancelledError
            self._heard.put((number, (step, done, total)))

        def watched_call() -> Result:
            with watched(heard):
                return function()

        call = pool.submit(watched_call)
        call.add_done_callback(lambda _: self._heard.put((number, None)))
        return call

    def results(self, calls: Sequence[Future[Result]]) -> Iterator[Result]:
        """Result of each call, in their order; meanwhile what they report, of one step all of them together."""
        over: set[int] = set()
        for wanted, call in enumerate(calls):
            while wanted not in over:
                number, report = self._heard.get()
                if report is None:
                    over.add(number)
                    continue
                step, *counts = report
                told = self._latest.setdefault(step, {})
                told[number] = counts[0], counts[1]
                report_progress(step, sum(done for done, _ in told.values()), sum(total for _, total in told.values()))
            yield call.result()

    def end(self) -> None:
        """Raise an error in each call, at its next report."""
        self._ended = True


def in_threads(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int | None = None,
    *,
    progress: bool = False,
    description: str | None = None,
    unit: str = "item",
) -> list[Result]:
    """Result of the function for each item, in their order; called in threads.

    The first error, in their order, ends it after the calls already begun, or their next reports, and is raised here.
    A single item is computed in this thread, with all the workers below it.
    """
    chosen = list(items)
    threads = worker_count(workers)
    bar = tqdm(total=len(chosen), desc=description, unit=unit, disable=not progress)
    results = []
    with bar:
        if threads == 1 or len(chosen) <= 1:
            with default_workers(threads):
                for item in chosen:
                    results.append(function(item))
                    bar.update()
                    report_progress(description or "step", len(results), len(chosen))
            return results
        relay = _Relay()
        with _pool(min(threads, len(chosen))) as pool:
            try:
                calls = [relay.submit(pool, partial(function, item), i) for i, item in enumerate(chosen)]
                for result in relay.results(calls):
                    results.append(result)
                    bar.update()
                    report_progress(description or "step", len(results), len(chosen))
            except BaseException:
                relay.end()
                pool.shutdown(wait=True, cancel_futures=True)
                raise
    return results


def concurrently(function: Callable[[Item], Result], items: Iterable[Item], workers: int | None = None) -> list[Result]:
    """Result of the function for each item, in their order; called in threads, BLAS on one thread meanwhile."""
    # BLAS's own threads would wait for each other's cores: measured, they doubled the CPU time and saved none.
    with single_threaded_blas:
        return in_threads(function, items, workers)


def run_tasks(
    task: Callable[[int], object],
    parts: Sequence[int],
    workers: int | None,
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
    done = before
    with (
        tqdm(total=before + len(parts), initial=before, disable=not progress, unit="group", desc="geodesics") as bar,
        _pool(worker_count(workers)) as pool,
    ):
        part_of = {pool.submit(task, part): part for part in parts}
        try:
            for future in as_completed(part_of):
                future.result()
                if finished is not None:
                    finished(part_of[future])
                bar.update()
                done += 1
                report_progress("distances", done, before + len(parts))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads in which ``workers=None`` means one."""
    return ThreadPoolExecutor(threads, initializer=_default.set, initargs=(1,))
