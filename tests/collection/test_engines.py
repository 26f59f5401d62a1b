"""Engines that run tasks: the same table bit for bit, whoever is killed in the middle."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT
from small_collection import QUICK, poses

import qgeo_filters as qg
from qgeo_filters.collection import matrices, records, tasks
from qgeo_filters.collection.engines import run_chunks
from qgeo_filters.errors import ParameterError, WorkersLostError

pandas = pytest.importorskip("pandas")
pytest.importorskip("zarr")

MATCH = f"""
import sys
sys.path.insert(0, {str(ROOT / "tests")!r})
import qgeo_filters as qg
qg.Collection.open(sys.argv[1]).match(workers=1)
"""


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> qg.Collection:
    """Five poses, matched in this process."""
    store = tmp_path_factory.mktemp("plain") / "shapes.zarr"
    return qg.Collection(poses(), store, parameters=QUICK).match(workers=1)


@pytest.fixture(scope="module")
def expected(plain: qg.Collection) -> Any:
    """Their table."""
    return plain.table()


@pytest.fixture
def store(plain: qg.Collection, tmp_path: Path) -> Path:
    """The store of the same poses before any pair was matched, and with one of them not prepared yet."""
    copy = tmp_path / "shapes.zarr"
    shutil.copytree(plain.store.root, copy)
    for pair in (copy / "pairs").glob("*/*/"):
        shutil.rmtree(pair)
    shutil.rmtree(next((copy / "shapes").glob("*/")))
    return copy


def pairs_in(store: Path) -> int:
    return len(list((store / "pairs").glob("*/*/*/zarr.json")))


def wait_for_pairs(store: Path, count: int, alive: Callable[[], bool] = lambda: True) -> None:
    limit = time.monotonic() + 120
    while pairs_in(store) < count and alive():
        assert time.monotonic() < limit, "nothing happens"
        time.sleep(0.02)


def begun(store: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", MATCH, str(store)], stderr=subprocess.PIPE)


@pytest.mark.slow
def test_two_processes_share_a_store_and_are_killed(
    store: Path, expected: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each loses at most the pair in hand: what a third one goes on with is the rest, and nothing else."""
    processes = [begun(store) for _ in range(2)]
    wait_for_pairs(store, 4, lambda: any(process.poll() is None for process in processes))
    for process in processes:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    finished, matched = pairs_in(store), []
    assert 4 <= finished < 10
    match = tasks.match
    monkeypatch.setattr(tasks, "match", lambda *args, **kwargs: matched.append(1) or match(*args, **kwargs))
    found = qg.Collection.open(store).match(workers=1).table()
    assert len(matched) == 10 - finished
    pandas.testing.assert_frame_equal(found, expected, check_exact=True)


def killing(chunk: Sequence[int], workers: int = 1) -> list[int]:
    if 3 in chunk:
        os.kill(os.getpid(), signal.SIGKILL)
    return list(chunk)


def threads_of(chunk: Sequence[int], workers: int = 1) -> list[tuple[int, int]]:
    return [(os.getpid(), workers)] * len(chunk)


@pytest.mark.slow
def test_worker_processes_and_one_that_is_killed(store: Path, expected: Any) -> None:
    found = qg.Collection.open(store).match(workers=2).table()
    pandas.testing.assert_frame_equal(found, expected, check_exact=True)
    told = set(run_chunks(threads_of, [[1], [2, 3], [4]], workers=2))
    assert os.getpid() not in {process for process, _ in told}
    with pytest.raises(WorkersLostError, match="a worker process ended in the middle of its work"):
        list(run_chunks(killing, [[n] for n in range(5)], workers=2))


def test_threads_and_this_process(store: Path, expected: Any) -> None:
    found = qg.Collection.open(store).match(workers=2, backend="threading").table()
    pandas.testing.assert_frame_equal(found, expected, check_exact=True)
    assert list(run_chunks(threads_of, [[1, 2]], workers=2)) == [(os.getpid(), 2)] * 2
    assert list(run_chunks(threads_of, [], workers=2)) == []


def test_blocks_of_a_distance_matrix(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bit for bit that of `distance_matrix`, whoever computes them; what is there is not computed again."""
    collection = qg.Collection.open(store)
    surface = collection.surface("p1")
    expected = qg.distance_matrix(surface)
    rows, groups = matrices.write_rows, []

    def some(path: Path, solver: Any, first: int) -> None:
        if len(groups) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        groups.append(first)
        rows(path, solver, first)

    with monkeypatch.context() as patch:
        patch.setattr(matrices, "write_rows", some)
        with pytest.raises(OSError, match="the disk is full: 0 of 3 groups"):
            collection.distance_matrix("p1", workers=1)
    found = collection.distance_matrix("p1", workers=2, backend="threading")
    np.testing.assert_array_equal(found[...], expected, strict=True)
    monkeypatch.setattr(matrices, "write_rows", lambda *_: pytest.fail("computed again"))
    assert collection.distance_matrix("p1").path == found.path
    spectrum = qg.distance_spectrum(surface, 5, "cartesian", matrix=found)
    np.testing.assert_array_equal(
        spectrum.eigenvalues, qg.distance_spectrum(surface, 5, "cartesian", matrix=expected).eigenvalues
    )


@pytest.mark.slow
def test_a_full_disk_ends_the_run_and_keeps_what_is_finished(
    store: Path, expected: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    collection = qg.Collection.open(store).prepare(workers=1)
    write, written = records.write_record, []

    def full(root: Path, place: str, *content: Any) -> bool:
        if len(written) == 4:
            raise OSError(errno.ENOSPC, "No space left on device", str(root / place))
        written.append(place)
        return write(root, place, *content)

    with monkeypatch.context() as patch:
        patch.setattr("qgeo_filters.collection.store.write_record", full)
        with pytest.raises(OSError, match="No space left") as caught:
            collection.match(workers=1)
    assert caught.value.errno == errno.ENOSPC
    assert len(collection.table()) == 4
    pandas.testing.assert_frame_equal(collection.match(workers=1).table(), expected, check_exact=True)


@pytest.mark.slow
def test_a_cluster_with_workers_killed_and_one_that_goes_away(store: Path, expected: Any, tmp_path: Path) -> None:
    """Of separate processes: the table is that of the plain run bit for bit."""
    distributed = pytest.importorskip("distributed")
    again, killed = tmp_path / "again.zarr", []
    shutil.copytree(store, again)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as local:

        def kill() -> None:
            for pairs in (1, 4):
                wait_for_pairs(store, pairs)
                alive = [nanny.pid for nanny in local.workers.values() if nanny.pid and nanny.pid not in killed]
                os.kill(alive[0], signal.SIGKILL)
                killed.append(alive[0])

        killer = threading.Thread(target=kill)
        killer.start()
        collection = qg.Collection.open(store).match(scheduler=local.scheduler_address)
        killer.join()
        assert len(set(killed)) == 2
        pandas.testing.assert_frame_equal(collection.table(), expected, check_exact=True)
        assert collection.problems == ()
        with distributed.Client(local) as client:  # the caller's own stays open; and all is there already
            matrix = collection.match(scheduler=client).distance_matrix("p3", curvature_weight=0.1, scheduler=client)
            assert client.status == "running"
        surface = collection.surface("p3")
        plain_matrix = qg.distance_matrix(surface, qg.lifted_metric(surface, curvature_weight=0.1))
        np.testing.assert_array_equal(matrix[...], plain_matrix, strict=True)
        closer = threading.Thread(target=lambda: (wait_for_pairs(again, 1), local.close()))
        closer.start()
        with pytest.raises(WorkersLostError, match=r"the cluster went away .*what was finished is kept"):
            qg.Collection.open(again).match(scheduler=local.scheduler_address)
        closer.join()
    assert 1 <= pairs_in(again) < 10


def test_schedulers_that_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("qgeo_filters.collection.dask_engine.PATIENCE", 1)
    collection = qg.Collection(poses(2), parameters=QUICK)
    with pytest.raises(WorkersLostError, match=r"no scheduler of Dask answers at tcp://127.0.0.1:9"):
        collection.match(scheduler="tcp://127.0.0.1:9")
    with pytest.raises(ParameterError, match="scheduler must be an address such as"):
        collection.match(scheduler=8786)
