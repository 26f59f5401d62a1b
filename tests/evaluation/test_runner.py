"""Measuring many pairs in a good order."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import icosphere
from test_house import ARROWS, MODULES

from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.evaluation import (
    Dataset,
    PairFailure,
    PairResult,
    PairStore,
    PointMap,
    SymmetricErrors,
    measured,
    runner,
)
from qgeo_filters.fingerprint import numeric_sources
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.parallel import available_cores, worker_count
from qgeo_filters.surface import Surface
from qgeo_filters.testing import sample_surface

names = st.sampled_from("abcde")


@given(st.lists(st.tuples(names, names), max_size=20))
def test_pairs_of_one_target_stand_together(pairs: list[tuple[str, str]]) -> None:
    ordered = runner.by_target(pairs)
    assert sorted(ordered) == sorted(pairs)
    targets = [target for target, _ in groupby(y for _, y in ordered)]
    assert targets == list(dict.fromkeys(y for _, y in pairs))
    for target in targets:
        assert [pair for pair in ordered if pair[1] == target] == [pair for pair in pairs if pair[1] == target]


def test_distances_of_a_target_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Surface] = []

    def counted(surface: Surface) -> np.ndarray:
        asked.append(surface)
        return distance_matrix(surface)

    monkeypatch.setattr(runner, "distance_matrix", counted)
    one, other = (Surface(size * icosphere(1)[0], icosphere(1)[1]) for size in (1, 2))
    ruler = runner.Ruler()
    found = [ruler(surface) for surface in (one, one, other, one)]
    assert asked == [one, other, one]
    np.testing.assert_allclose(found[2], 2 * found[0], rtol=1e-5)
    np.testing.assert_array_equal(found[3], found[0])


def test_kept_results_know_all_code_that_they_depend_on() -> None:
    """Whatever `match` and `self_symmetry` import, directly or not: a change there makes kept results old."""
    needed, waiting = set(), ["matching.correspondence", "matching.symmetry"]
    while waiting:
        module = waiting.pop()
        if module not in needed:
            needed.add(module)
            waiting += [arrow.imported for arrow in ARROWS if arrow.importer == module and not arrow.typing_only]
    root = Path(runner.__file__).parents[1]
    known = {".".join(file.relative_to(root).with_suffix("").parts) for file in numeric_sources()}
    assert needed <= known
    assert len(needed) > 40
    assert not {name for name in known & set(MODULES) if name.startswith(("report", "cli"))}


class TwoSpheres(Dataset):
    """A data set in memory, whose symmetry fails in a chosen way."""

    def __init__(self, failure: Exception | None = None) -> None:
        super().__init__(".", [Path("ball0.off"), Path("ball1.off")])
        self.failure = failure

    def read(self, name: str) -> Surface:
        return sample_surface()

    def truth(self, x: str, y: str) -> PointMap:
        return PointMap(np.arange(162), np.arange(162))

    def symmetry(self, name: str) -> PointMap:
        return super().symmetry(name) if self.failure is None else self.raises()

    def raises(self) -> PointMap:
        assert self.failure is not None
        raise self.failure


@pytest.fixture
def no_match(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Identity in place of the search; the threads that it would have had are noted."""
    threads: list[int] = []

    def identity(x: PreparedShape, y: PreparedShape, **_: object) -> SimpleNamespace:
        threads.append(worker_count())
        return SimpleNamespace(p2p=np.arange(x.given.n_vertices), confident=True)

    monkeypatch.setattr(runner, "match", identity)
    monkeypatch.setattr(PreparedShape, "prepare", lambda shape: shape)
    return threads


def test_a_bug_in_a_symmetry_is_not_taken_for_a_symmetry_that_is_not_known(no_match: list[int]) -> None:
    (known,) = measured(TwoSpheres(), [("ball0", "ball1")])
    assert isinstance(known, PairResult)
    assert known.errors.direct.max() == 0
    (failed,) = measured(TwoSpheres(KeyError("typo")), [("ball0", "ball1")])
    assert isinstance(failed, PairFailure)
    assert failed.reason == "KeyError('typo')"
    (bad,) = measured(TwoSpheres(MeshError("vertex 3 is not finite")), [("ball0", "ball1")])
    assert isinstance(bad, PairFailure)
    assert bad.reason == "vertex 3 is not finite"


def test_errors_are_those_at_full_resolution(no_match: list[int]) -> None:
    """Of a shape that is large enough to be matched on a proxy."""

    class Large(TwoSpheres):
        def read(self, name: str) -> Surface:
            return Surface(*icosphere(4))

        def truth(self, x: str, y: str) -> PointMap:
            return PointMap(np.arange(2562), np.arange(2562)[::-1])

        def symmetry(self, name: str) -> PointMap:
            return PointMap(np.arange(2562), np.arange(2562))

    (found,) = measured(Large(), [("ball0", "ball1")])
    assert isinstance(found, PairResult)
    surface = Large().read("ball0")
    gap = np.linalg.norm(surface.vertices - surface.vertices[::-1], axis=1)
    expected = 2 * np.arcsin(gap / 2) / np.sqrt(surface.area)
    np.testing.assert_allclose(found.errors.direct, expected, atol=0.01)


def test_workers_hold_for_the_pairs_and_not_for_the_caller(no_match: list[int]) -> None:
    outcomes = measured(TwoSpheres(), [("ball0", "ball1"), ("ball1", "ball0")], workers=3)
    next(outcomes)
    assert no_match == [3]
    assert worker_count() == worker_count(None) == available_cores()
    next(outcomes)
    assert no_match == [3, 3]
    with pytest.raises(ParameterError, match="workers"):
        next(measured(TwoSpheres(), [], workers=0))


RESULT = PairResult("a - b", "a", SymmetricErrors(np.zeros(3), np.ones(3)), True, 2.5, np.arange(3))


def test_kept_pairs_come_back_and_old_ones_do_not(tmp_path: Path) -> None:
    store = PairStore(tmp_path)
    assert store.load("a - b", "a", "key") is None
    store.save(RESULT, "key")
    assert store.load("a - b", "a", "another key") is None
    found = store.load("a - b", "a", "key")
    assert found is not None
    assert (found.confident, found.seconds, store.reused) == (True, 2.5, 1)
    np.testing.assert_array_equal(found.errors.reflected, np.ones(3))
    np.testing.assert_array_equal(found.p2p, np.arange(3))


KEPT = {
    "key": "key", "direct": np.zeros(3), "reflected": np.zeros(3), "confident": True, "seconds": 1.0,
    "p2p": np.arange(3),
}  # fmt: skip


@pytest.mark.parametrize(
    "other",
    [
        {"direct": np.zeros(4)}, {"direct": "far"}, {"direct": [np.nan] * 3}, {"p2p": 3}, {"confident": 2.0},
        {"key": 3}, {"seconds": [1.0]},
    ],
    ids=str,
)  # fmt: skip
def test_a_file_that_is_no_pair_is_not_taken_for_one(tmp_path: Path, other: dict[str, object]) -> None:
    np.savez(tmp_path / "a-b.npz", **{**KEPT, **other})  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"a-b\.npz is not a result of an evaluation .*: move it away"):
        PairStore(tmp_path).load("a - b", "a", "key")
    (tmp_path / "a-b.npz").write_text("notes")
    with pytest.raises(ParameterError, match=r"neither an \.npz nor an \.npy file"):
        PairStore(tmp_path).load("a - b", "a", "key")
    assert (tmp_path / "a-b.npz").read_text() == "notes"
