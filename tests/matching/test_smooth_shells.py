"""From a coarse map to one between all vertices."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.deformation import arap
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.registration_stages import COARSE_TO_FINE, FINAL, HKS_GUIDED, PREVIEW, Stages
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.selection import cost
from qgeo_filters.matching.smooth_shells import register
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def problem() -> MatchProblem:
    vertices, faces = blob(3, 0)
    bent = vertices + 0.1 * np.sin(2 * vertices[:, [1, 2, 0]])
    return MatchProblem.of(Surface(vertices, faces), Surface(bent, faces))


@pytest.mark.parametrize(
    "stages",
    [PREVIEW, COARSE_TO_FINE, HKS_GUIDED, PREVIEW + COARSE_TO_FINE, FINAL],
    ids=["preview", "coarse to fine", "guided", "preview and coarse to fine", "final"],
)
def test_nothing_is_factorised_in_a_thread(
    problem: MatchProblem, stages: Stages, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SciPy would leak it."""
    x, y = problem.x, problem.y
    x.arap.release()
    schedule = Schedule.of(problem, stages)
    solvers = schedule.prefactor(x.arap)

    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("factorised while maps are tried side by side")

    monkeypatch.setattr(arap, "factorised_spd", forbidden)
    found = register(problem, np.arange(x.n_vertices), schedule, solvers)
    off = np.linalg.norm(found.positions - y.unit.vertices, axis=1)
    assert off.mean() < 0.05
    assert (found.p2p == np.arange(x.n_vertices)).mean() > 0.8


def test_factorisations_are_dropped_when_a_match_is_interrupted(
    problem: MatchProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    x, y = problem.x, problem.y
    x.arap.release()
    used = []

    def interrupted(problem: MatchProblem, *_: object) -> None:
        used.append(problem.x.arap.n_factorised)
        raise KeyboardInterrupt

    monkeypatch.setattr(cost, "hks_agreements", interrupted)
    with pytest.raises(KeyboardInterrupt):
        match(x, y)
    assert max(used) > 0
    assert x.arap.n_factorised == y.arap.n_factorised == 0


def test_the_map_and_its_inverse_are_nearest_neighbours_in_what_was_compared(
    problem: MatchProblem,
) -> None:
    x, y = problem.x, problem.y
    found = register(problem, np.arange(x.n_vertices), Schedule.of(problem, COARSE_TO_FINE + FINAL))
    squared = ((found.embedding_x[:, None] - found.embedding_y) ** 2).sum(axis=2)
    nearest = np.take_along_axis(squared, found.p2p[:, None], axis=1)[:, 0]
    np.testing.assert_allclose(nearest, squared.min(axis=1), rtol=1e-4, atol=1e-9)
    back = squared[found.inverse, np.arange(y.n_vertices)]
    np.testing.assert_allclose(back, squared.min(axis=0), rtol=1e-4, atol=1e-9)


def test_the_order_in_which_points_are_given_does_not_matter(problem: MatchProblem) -> None:
    """All vertices as farthest points, in their order: what a shape of few vertices starts from."""
    x = problem.x
    assert len(x.fps) == x.n_vertices
    one = register(problem, np.arange(x.n_vertices), Schedule.of(problem, PREVIEW))
    other = register(problem, x.fps, Schedule.of(problem, PREVIEW, x.fps))
    np.testing.assert_allclose(other.positions, one.positions, atol=1e-4)


def test_some_points_are_enough_to_start_from(problem: MatchProblem) -> None:
    x, y = problem.x, problem.y
    points = x.fps[:150]
    found = register(problem, points, Schedule.of(problem, COARSE_TO_FINE, points))
    assert np.linalg.norm(found.positions - y.unit.vertices, axis=1).mean() < 0.05
