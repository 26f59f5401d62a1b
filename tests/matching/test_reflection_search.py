"""A reflection in doubt is sought once more on a finer proxy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import creature

import qgeo_filters as qg
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.reflection_search import chosen_reflection, is_doubtful

COARSE = MatchingParameters(search_vertices=250, registration_vertices=500)


@pytest.mark.slow
def test_the_finer_search_is_that_of_a_shape_prepared_finer() -> None:
    """Bit for bit, on the same vertices; and the coarse one is another."""
    surface = qg.Surface(*creature())
    doubting = replace(COARSE, doubtful_reflection_alike=1.1, doubtful_reflection_distortion=np.inf)
    sure = replace(COARSE, doubtful_reflection_alike=0.0)
    finer = replace(sure, search_vertices=500)
    doubted, coarse, expected = (qg.self_symmetry(surface, parameters=p) for p in (doubting, sure, finer))
    assert doubted.found
    for one in ("p2p", "nearest", "side", "asymmetry"):
        np.testing.assert_array_equal(getattr(doubted, one), getattr(expected, one))
    assert (doubted.nearest != coarse.nearest).any()
    # What is asked of this search is asked of the finer one, too, whatever the shape was prepared with.
    strict = replace(doubting, symmetry_alike=2.0)
    assert not qg.self_symmetry(PreparedShape(surface, parameters=COARSE), parameters=strict).found


def test_only_a_shape_with_a_finer_level_has_one() -> None:
    surface = qg.Surface(*creature())
    shape = PreparedShape(surface, parameters=COARSE)
    finer = shape.finer()
    assert finer is not None
    assert (shape.n_vertices, finer.n_vertices, finer.full.n_vertices) == (250, 500, surface.n_vertices)
    assert finer.finer() is None
    assert PreparedShape(surface).finer() is None


def test_what_is_clear_or_hopeless_is_in_no_doubt() -> None:
    problem = MatchProblem.of_reflection(PreparedShape(qg.Surface(*creature()), parameters=COARSE))
    chosen = chosen_reflection(problem)
    assert chosen is not None
    assert not is_doubtful(problem, chosen)
    unlike = replace(chosen.best, hks_agreement=0.95)
    assert is_doubtful(problem, replace(chosen, best=unlike))
    assert not is_doubtful(problem, replace(chosen, best=replace(unlike, mean_distortion=0.3)))
    assert not is_doubtful(problem, None)
