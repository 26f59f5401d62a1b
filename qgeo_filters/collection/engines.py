"""Who runs the tasks of a collection: this process, worker processes of this machine, or a cluster of Dask."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import joblib
from joblib.externals.loky.process_executor import BrokenProcessPool
from tqdm.auto import tqdm

from qgeo_filters.collection.dask_engine import on_cluster
from qgeo_filters.errors import ParameterError, WorkersLostError
from qgeo_filters.parallel import report_progress, worker_count

Part = TypeVar("Part")
Outcome = TypeVar("Outcome")

#: A task takes some parts at a time, and tells what failed.
Task = Callable[[Sequence[Part]], Sequence[Outcome]]


def run_chunks(
    task: Task,
    chunks: Sequence[Sequence[Part]],
    *,
    workers: int | None = None,
    backend: str = "loky",
    scheduler: Any = None,
    progress: bool = False,
    unit: str = "part",
) -> Iterator[Outcome]:
    """What a task tells of each chunk, as they come; results go where the task leaves them.

    Parameters
    ----------
    task : callable
        Pickled for other processes: a function of a module, or `functools.partial` of one. It takes ``workers=``.
    chunks : sequence of sequences
        What the task takes at once, in the order in which they are begun.
    workers : int, optional
        Processes at most, of one thread each; all cores by default. With 1, or a single chunk, all is done in this
        process, in as many threads.
    backend : str
        Of joblib: "loky", "multiprocessing", "threading", or one that was registered.
    scheduler : str or dask.distributed.Client, optional
        Cluster that takes the tasks instead.
    progress : bool
        Whether to show a bar with the time that is left.
    unit : str
        What the bar counts.

    Raises
    ------
    WorkersLostError
        A worker process that was killed, or a cluster that went away; what was finished is kept.
    ParameterError
        No such backend.
    """
    count = worker_count(workers)
    bar = tqdm(total=sum(map(len, chunks)), unit=unit, disable=not progress)
    finished = 0
    with bar:
        if scheduler is not None:
            done = on_cluster(task, chunks, scheduler)
        elif count == 1 or len(chunks) == 1:
            done = ((len(chunk), task(chunk, workers=count)) for chunk in chunks)  # type: ignore[call-arg]
        else:
            done = _in_workers(task, chunks, min(count, max(len(chunks), 1)), backend)
        for size, outcomes in done:
            yield from outcomes
            bar.update(size)
            finished += size
            report_progress(unit, finished, sum(map(len, chunks)))


def _in_workers(
    task: Task, chunks: Sequence[Sequence[Part]], workers: int, backend: str
) -> Iterator[tuple[int, Sequence[Outcome]]]:
    try:
        pool = joblib.Parallel(
            workers, backend=backend, return_as="generator_unordered", batch_size=1, pre_dispatch="2*n_jobs"
        )
    except ValueError as error:
        raise ParameterError(f"no backend of joblib is called {backend!r}: {error}") from error
    with _lost_workers():
        yield from pool(joblib.delayed(_sized)(task, chunk) for chunk in chunks)


def _sized(task: Task, chunk: Sequence[Part]) -> tuple[int, Sequence[Outcome]]:
    return len(chunk), task(chunk)


@contextmanager
def _lost_workers() -> Iterator[None]:
    try:
        yield
    except BrokenProcessPool as error:
        raise WorkersLostError(
            "a worker process ended in the middle of its work: it was killed, or memory ran out; what was finished is "
            "kept, so that the same call goes on from there (with fewer workers, if memory was short)"
        ) from error
