"""A limb that has slipped onto another one is a doubt; limbs that one shape lacks are none."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import creature

import qgeo_filters as qg
from qgeo_filters.matching.initialization.limb_maps import LimbEnds
from qgeo_filters.matching.limb_verdict import with_limbs
from qgeo_filters.matching.problem import MatchProblem

UNLIKE = 0.9  # as heat kernels of different animals are


@pytest.fixture(scope="module")
def problem() -> MatchProblem:
    shape = qg.PreparedShape(qg.Surface(*creature(1.0)))
    shape.prepare()
    return MatchProblem.of(shape, shape)


def test_a_limb_on_another_one_makes_a_map_unsure(problem: MatchProblem) -> None:
    same = np.arange(problem.x.n_vertices)
    ends = LimbEnds.of(problem.x, same, problem.parameters)
    assert len(ends.vertices) >= 2
    assert with_limbs(problem, same, UNLIKE, True, "clear") == (True, "clear")
    for a, b in ((0, 1), (1, 0)):
        slipped = np.where(ends.distances[a] < 0.3, ends.vertices[b], same)
        sure, said = with_limbs(problem, slipped, UNLIKE, True, "clear")
        assert not sure
        assert said == "clear; but two limbs of X end on one of Y, and one of Y has none"
        assert with_limbs(problem, slipped, UNLIKE, False, "doubtful") == (False, "doubtful")
        assert with_limbs(problem, slipped, 0.97, True, "a pose") == (True, "a pose")


def test_a_limb_that_ends_on_none_is_no_doubt_by_itself(problem: MatchProblem) -> None:
    """As where Y lacks it, or has a longer one: no other limb lies there."""
    same = np.arange(problem.x.n_vertices)
    ends = LimbEnds.of(problem.x, same, problem.parameters)
    middle = int(ends.distances.min(axis=0).argmax())
    elsewhere = np.where(ends.distances[0] < 0.3, middle, same)
    assert with_limbs(problem, elsewhere, UNLIKE, True, "clear") == (True, "clear")
