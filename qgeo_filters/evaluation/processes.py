"""Pairs of a data set measured in several processes: the matches of one machine do not share their threads well."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial as applied
from itertools import groupby

from qgeo_filters.evaluation.datasets import Dataset
from qgeo_filters.evaluation.runner import PairFailure, PairStore, What, by_target, measured
from qgeo_filters.evaluation.tables import PairResult
from qgeo_filters.parallel import in_processes, worker_count

# Pairs that a process takes at once: those of one target, which share its distances.
_MOST = 8


def measured_in_processes(
    data: Dataset,
    pairs: Iterable[tuple[str, str]],
    what: What = "match",
    store: PairStore | None = None,
    *,
    partial: bool = False,
    workers: int | None = None,
) -> Iterator[PairResult | PairFailure]:
    """As `measured`, in as many processes as it has workers, of one thread each; outcomes as they come.

    Parameters
    ----------
    data, pairs, what, store, partial
        See `measured`. Each process reads and prepares the shapes of its pairs, and ``store.reused`` counts none.
    workers : int, optional
        Number of processes; all cores that this process may use by default.

    Yields
    ------
    PairResult or PairFailure
    """
    count = worker_count(workers)
    chunks = [chunk for _, group in groupby(by_target(pairs), lambda pair: pair[1]) for chunk in _cut(list(group))]
    if count == 1 or len(chunks) < 2:
        yield from measured(data, by_target(pair for chunk in chunks for pair in chunk), what, store, partial=partial)
        return
    for outcomes in in_processes(applied(_outcomes, data, what, store, partial), chunks, count):
        yield from outcomes


def _cut(pairs: list[tuple[str, str]]) -> list[list[tuple[str, str]]]:
    return [pairs[start : start + _MOST] for start in range(0, len(pairs), _MOST)]


def _outcomes(
    data: Dataset, what: What, store: PairStore | None, as_part: bool, pairs: list[tuple[str, str]]
) -> list[PairResult | PairFailure]:
    return list(measured(data, pairs, what, store, partial=as_part, workers=1))
