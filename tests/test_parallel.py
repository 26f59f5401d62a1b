"""Threads: how many, nested pools, and the limit of BLAS that comes back."""

from __future__ import annotations

import ast
import math
import os
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from shapes import blob, icosphere
from threadpoolctl import threadpool_info, threadpool_limits

import qgeo_filters
import qgeo_filters as qg
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.mmp.exact import exact_distances
from qgeo_filters.matching import correspondence, intrinsic_shape, reflection_search, search
from qgeo_filters.parallel import (
    available_cores,
    concurrently,
    default_workers,
    in_processes,
    in_threads,
    report_progress,
    run_tasks,
    single_threaded_blas,
    watched,
    worker_count,
)


def blas_threads() -> list[int]:
    """Threads of each BLAS that is loaded."""
    return [entry["num_threads"] for entry in threadpool_info() if entry["user_api"] == "blas"]


@pytest.mark.parametrize("workers", [0, -1, True, False, np.True_, 1.0, 2.5, "2", np.nan, [1]])
def test_what_is_no_number_of_threads_is_refused(workers: object) -> None:
    with pytest.raises(ParameterError, match=r"workers must be (a whole number|at least 1).*, got "):
        worker_count(workers)  # type: ignore[arg-type]


@pytest.mark.parametrize("workers", [0, -2, True])
def test_it_is_refused_by_whatever_takes_it(workers: int) -> None:
    surface = qg.Surface(*icosphere(1))
    calls: list[Callable[[], object]] = [
        lambda: qg.quasi_geodesics(surface, [[0, 1]], workers=workers),
        lambda: exact_distances(qg.lifted_metric(surface).intrinsic(), [0], workers=workers),
        lambda: qg.distances(surface, [0], workers=workers),
        lambda: concurrently(abs, [1, 2], workers),
        lambda: run_tasks(abs, [1], workers, False),
    ]
    for call in calls:
        with pytest.raises(ParameterError, match="workers"):
            call()


def test_all_cores_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3, 5, 7}, raising=False)
    assert worker_count(None) == available_cores() == 3
    assert worker_count(np.int64(5)) == 5
    monkeypatch.delattr(os, "sched_getaffinity")
    assert worker_count(None) == 64


def test_inside_a_pool_none_means_one_thread() -> None:
    assert in_threads(lambda _: worker_count(None), range(8), 4) == [1] * 8
    assert concurrently(lambda _: worker_count(None), range(8), 4) == [1] * 8
    found: list[int] = []
    run_tasks(lambda _: found.append(worker_count(None)), range(3), 2, False)
    assert found == [1, 1, 1]
    assert worker_count(None) == available_cores()
    # A single item leaves the threads to what lies below it; one worker leaves one.
    assert in_threads(lambda _: worker_count(None), [0], 4) == [4]
    assert in_threads(lambda _: worker_count(None), range(2), 1) == [1, 1]


def test_the_default_bounds_everything_below_and_goes_with_its_context(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    with default_workers(2):
        assert worker_count(None) == 2
        assert worker_count(3) == 3  # said by name
        together = threading.Barrier(3)  # three at once: no third thread comes

        def meet(_: int) -> bool:
            try:
                together.wait(0.1)
            except threading.BrokenBarrierError:
                return False
            return True

        assert not any(in_threads(meet, range(4)))
        with default_workers(None):
            assert worker_count(None) == 2
        with pytest.raises(ParameterError), default_workers(0):
            pass
        other: list[int] = []
        thread = threading.Thread(target=lambda: other.append(worker_count(None)))
        thread.start()
        thread.join()
        assert other == [8]  # another thread of the caller is not bound by it
    assert worker_count(None) == 8


def test_two_overlapping_limits_of_blas_are_undone_by_the_last() -> None:
    with threadpool_limits(2, user_api="blas"):  # more than one, whatever the machine
        before = blas_threads()
        assert before
        assert set(before) == {2}
        entered, first_left = threading.Event(), threading.Event()

        def second() -> None:
            with single_threaded_blas:
                entered.set()
                first_left.wait(10)
                seen.append(blas_threads())

        seen: list[list[int]] = []
        thread = threading.Thread(target=second)
        with single_threaded_blas:
            assert set(blas_threads()) == {1}
            thread.start()
            entered.wait(10)
        first_left.set()
        thread.join()
        assert seen == [[1] * len(before)]  # the first to leave takes nothing from the second
        assert blas_threads() == before
    with threadpool_limits(3, user_api="blas"):  # nor is anyone kept from the limit afterwards
        assert set(blas_threads()) == {3}


def test_matching_uses_one_thread_of_blas_from_the_spectra_to_the_map(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of shapes prepared before, too, so that no last bit of a map depends on the number."""
    seen: dict[str, set[int]] = {}

    def watched(module: ModuleType, name: str) -> None:
        function = getattr(module, name)

        def watching(*args: Any, **kwargs: Any) -> Any:
            seen.setdefault(name, set()).update(blas_threads())
            return function(*args, **kwargs)

        monkeypatch.setattr(module, name, watching)

    watched(intrinsic_shape, "spectrum_of_matrix")
    watched(intrinsic_shape, "laplacian_spectrum")
    watched(search, "choose_map")
    watched(correspondence, "functional_map")
    watched(reflection_search, "choose_reflection")
    surface = qg.Surface(*blob(2, 0))
    with threadpool_limits(2, user_api="blas"):
        qg.match(qg.PreparedShape(surface).prepare(), surface)
        qg.self_symmetry(surface)
        assert set(blas_threads()) == {2}
    assert len(seen) == 5
    assert set().union(*seen.values()) == {1}


def test_many_threads_in_and_out_leave_blas_as_it_was() -> None:
    with threadpool_limits(2, user_api="blas"):
        before = blas_threads()

        def inside(seed: int) -> set[int]:
            seen: set[int] = set()
            for _ in range(20):
                with single_threaded_blas:
                    seen.update(blas_threads())
                    if seed % 2:
                        concurrently(lambda _: None, range(2), 2)
            return seen

        assert in_threads(inside, range(6), 6) == [{1}] * 6
        with pytest.raises(ZeroDivisionError):
            concurrently(lambda item: 1 // item, [1, 0], 2)
        assert blas_threads() == before


def test_an_error_stops_what_has_not_begun() -> None:
    begun: list[int] = []
    release = threading.Event()

    def task(item: int) -> None:
        begun.append(item)
        if item == 0:
            raise KeyError("first")
        release.wait(0.05)

    with pytest.raises(KeyError, match="first"):
        in_threads(task, range(200), 2)
    assert len(begun) < 200


def test_a_watcher_hears_in_its_own_thread_what_threads_within_threads_report() -> None:
    both = threading.Barrier(2)

    def inner(item: int) -> None:
        for done in (1, 2, 3):
            report_progress("distances", done, 3)

    def outer(item: int) -> None:
        both.wait(10)
        in_threads(inner, [item], 1)
        both.wait(10)
        in_threads(inner, [item, item], 2)

    heard: list[tuple[str, int, int]] = []
    where: set[int] = set()

    def watcher(*step: Any) -> None:
        heard.append(step)
        where.add(threading.get_ident())

    with watched(watcher):
        in_threads(outer, range(2), 2, description="shape")
    assert where == {threading.get_ident()}
    distances = [report[1:] for report in heard if report[0] == "distances"]
    assert len(distances) == 2 * 3 + 4 * 3
    # The two items are added up, and within the second round the two threads of each.
    assert {total for _, total in distances} <= {3, 6, 9, 12}
    assert max(distances) == distances[-1] == (12, 12)
    assert [report for report in heard if report[0] == "shape"] == [("shape", 1, 2), ("shape", 2, 2)]


def test_a_watcher_that_raises_ends_threads_at_their_next_report() -> None:
    reached: list[int] = []

    def endless(item: int) -> None:
        for done in range(100_000):
            report_progress("distances", done, 100_000)
            reached.append(done)
            threading.Event().wait(0.001)

    def stop(step: str, done: int, total: int) -> None:
        if done > 5:
            raise KeyError("enough")

    with watched(stop), pytest.raises(KeyError, match="enough"):
        in_threads(lambda item: in_threads(endless, [item, item], 2), range(2), 2)
    assert max(reached) < 50_000
    assert not any(thread.name.startswith("ThreadPool") for thread in threading.enumerate())


def test_preparing_two_shapes_tells_its_distances() -> None:
    heard: set[str] = set()
    with watched(lambda step, done, total: heard.add(step)):
        qg.match(qg.Surface(*blob(2, 0)), qg.Surface(*blob(2, 1)), workers=2)
    assert "distances" in heard


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    surface = qg.Surface(*icosphere(3))
    once = [qg.distance_matrix(surface, workers=workers) for workers in (1, 3)]
    assert np.array_equal(*once)
    rows = [exact_distances(qg.lifted_metric(surface).intrinsic(), [0, 5, 9], workers=workers) for workers in (1, 3)]
    assert np.array_equal(*rows)


def test_processes_give_all_results_and_the_first_error() -> None:
    assert sorted(in_processes(math.sqrt, [4.0, 9.0, 16.0], 2)) == [2, 3, 4]
    assert list(in_processes(math.sqrt, [], 2)) == []
    with pytest.raises(ValueError, match="math domain error"):
        list(in_processes(math.sqrt, [4.0, -1.0], 2))
    with pytest.raises(qg.ParameterError, match="workers must be at least 1"):
        list(in_processes(math.sqrt, [4.0], 0))


def test_no_other_module_asks_for_threads() -> None:
    """Pools, cores and limits of BLAS are asked for in parallel.py alone."""
    forbidden = {"ThreadPoolExecutor", "ProcessPoolExecutor", "cpu_count", "sched_getaffinity", "threadpool_limits"}
    package = Path(qgeo_filters.__file__).parent
    found = []
    for path in package.rglob("*.py"):
        if path == package / "parallel.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = {getattr(node, "id", None), getattr(node, "attr", None), getattr(node, "name", None)}
            if names & forbidden:
                found.append(f"{path.relative_to(package)}:{getattr(node, 'lineno', '?')}")
            if isinstance(node, ast.keyword) and node.arg in ("workers", "n_jobs"):
                value = node.value
                if isinstance(value, ast.UnaryOp) and isinstance(value.op, ast.USub):
                    found.append(f"{path.relative_to(package)}:{value.lineno}")
    assert found == []
