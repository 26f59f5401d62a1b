"""Measuring many pairs in a good order."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import icosphere

from qgeo_filters.evaluation import runner
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.surface import Surface

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
    ruler = runner._Ruler()
    found = [ruler(surface) for surface in (one, one, other, one)]
    assert asked == [one, other, one]
    np.testing.assert_allclose(found[2], 2 * found[0], rtol=1e-5)
    np.testing.assert_array_equal(found[3], found[0])
