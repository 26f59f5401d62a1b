"""Tasks of a collection on a cluster of Dask: arguments are keys, results go through the store."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Any

from qgeo_filters.errors import ParameterError, QgeoError, WorkersLostError, reason, require_package

# Tasks that wait at the scheduler for each thread of the cluster: millions of them need not be there at once.
_AHEAD = 4
_FEWEST = 16
#: Seconds for a first answer.
PATIENCE = 30


def on_cluster(
    task: Callable[..., Sequence[Any]], chunks: Sequence[Sequence[Any]], scheduler: Any
) -> Iterator[tuple[int, Sequence[Any]]]:
    """Size of each chunk and what the task tells of it, as they come.

    Parameters
    ----------
    task : callable
    chunks : sequence of sequences
    scheduler : str or dask.distributed.Client
        Address, such as "tcp://host:8786", or a client of the caller's, which stays open.

    Raises
    ------
    WorkersLostError
        The cluster cannot be reached, went away, or lost the workers of one task several times.
    ParameterError
        What is neither an address nor a client.

    Notes
    -----
    A task whose worker is killed is begun again on another one; it finds in the store what was finished.
    """
    distributed = require_package("distributed", "dask", "a run on a cluster")
    with _client(distributed, scheduler) as client, _lost_cluster(distributed, client):
        waiting = iter(chunks)
        threads = sum(client.nthreads().values())
        if not threads:
            client.wait_for_workers(1, timeout=PATIENCE)
            threads = sum(client.nthreads().values())
        first = list(islice(waiting, max(_AHEAD * threads, _FEWEST)))
        sizes = {}

        def submitted(chunk: Sequence[Any]) -> Any:
            future = client.submit(task, chunk, pure=False)
            sizes[future.key] = len(chunk)
            return future

        # In the order of the targets, which a worker that has one of them likes best.
        running = distributed.as_completed([submitted(chunk) for chunk in first], loop=client.loop)
        for future in running:
            outcomes = future.result()
            yield sizes.pop(future.key), outcomes
            for chunk in islice(waiting, 1):
                running.add(submitted(chunk))


@contextmanager
def _client(distributed: Any, scheduler: Any) -> Iterator[Any]:
    if isinstance(scheduler, distributed.Client):
        yield scheduler
        return
    if not isinstance(scheduler, str):
        raise ParameterError(f"scheduler must be an address such as 'tcp://host:8786' or a Client, got {scheduler!r}")
    try:
        client = distributed.Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise WorkersLostError(f"no scheduler of Dask answers at {scheduler}: {reason(error)}") from error
    with client:
        yield client


@contextmanager
def _lost_cluster(distributed: Any, client: Any) -> Iterator[None]:
    """Errors of the cluster as one of ours; those of the tasks, which came over the same wire, as they are."""
    try:
        yield
    except QgeoError:
        raise
    except distributed.KilledWorker as error:
        raise WorkersLostError(
            f"the cluster lost the workers of one task several times: {reason(error)}; what was finished is kept"
        ) from error
    except Exception as error:
        gone = getattr(client, "status", "") != "running" or not _answers(client)
        if not gone and not isinstance(error, (distributed.CancelledError, TimeoutError)):
            raise
        raise WorkersLostError(
            f"the cluster went away ({reason(error)}): what was finished is kept, so that the same call goes on from "
            "there"
        ) from error


def _answers(client: Any) -> bool:
    try:
        client.nthreads()
    except Exception:  # of any kind: it is gone
        return False
    return True
