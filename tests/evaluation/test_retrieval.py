"""Retrieval against counts by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import qgeo_filters as qg
from qgeo_filters.evaluation.retrieval import retrieval_scores

# On a line: two groups, one of whose members lies beyond the other group.
PLACES = np.array([0.0, 1.0, 10.0, 4.0, 5.5])
GROUPS = ["cat", "cat", "cat", "dog", "dog"]
LINE = np.abs(PLACES[:, None] - PLACES)


def test_by_hand():
    """Queries 0 and 1 find each other, then the dogs, then 2; 2 finds the dogs first; the dogs each other."""
    found = retrieval_scores(LINE, GROUPS)
    assert found.nearest_neighbor == pytest.approx(4 / 5)
    assert found.first_tier == pytest.approx((1 / 2 + 1 / 2 + 0 + 1 + 1) / 5)
    assert found.second_tier == pytest.approx((1 + 1 + 1 + 1 + 1) / 5)
    precisions = [(1 + 2 / 4) / 2, (1 + 2 / 4) / 2, (1 / 3 + 2 / 4) / 2, 1, 1]
    assert found.mean_average_precision == pytest.approx(np.mean(precisions))
    assert found.n_queries == 5


def test_a_perfect_distance_scores_one_and_order_does_not_matter():
    rng = np.random.default_rng(0)
    groups = np.repeat(np.arange(4), 5)
    square = rng.uniform(1, 2, (20, 20)) + 5 * (groups[:, None] != groups)
    order = rng.permutation(20)
    for some in (np.arange(20), order):
        found = retrieval_scores(square[np.ix_(some, some)], groups[some].tolist())
        assert (found.nearest_neighbor, found.first_tier, found.second_tier) == (1, 1, 1)
        assert found.mean_average_precision == 1


def test_a_distance_that_tells_nothing_scores_chance():
    groups = np.repeat(np.arange(4), 5)
    found = retrieval_scores(np.ones((20, 20)), groups.tolist())
    assert found.nearest_neighbor == pytest.approx(4 / 19)
    assert found.first_tier == pytest.approx(4 / 19)
    assert found.second_tier == pytest.approx(8 / 19)
    assert found.mean_average_precision == pytest.approx(4 / 19)


def test_by_name_unknown_distances_and_lonely_shapes():
    names = list("vwxyz")
    frame = pd.DataFrame(LINE, names, names)
    assert retrieval_scores(frame, dict(zip(names, GROUPS, strict=True))) == retrieval_scores(LINE, GROUPS)
    assert retrieval_scores(LINE, ["cat", "cat", "bird", "dog", "dog"]).n_queries == 4
    unknown = LINE.copy()
    unknown[0, 1] = np.nan
    assert retrieval_scores(unknown, GROUPS).nearest_neighbor == pytest.approx(3 / 5)


def test_what_does_not_fit_is_told():
    frame = pd.DataFrame(LINE, list("vwxyz"), list("vwxyz"))
    for distances, groups, message in (
        (LINE[:3], GROUPS, "must be square"),
        (LINE, GROUPS[:4], "4 groups for 5 shapes"),
        (LINE, [1, 2, 3, 4, 5], "no group has two shapes"),
        (LINE, {"v": 1}, "a DataFrame"),
        (frame, {"v": 1}, r"no group of 'w' \(4 such"),
        (frame[list("zyxwv")], GROUPS, "same order"),
    ):
        with pytest.raises(qg.ParameterError, match=message):
            retrieval_scores(distances, groups)
