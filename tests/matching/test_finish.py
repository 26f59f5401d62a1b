"""Which of two shapes is deformed at the end: the one that has not grown together with itself."""

from __future__ import annotations

import numpy as np
import pytest
from grown_body import body, prepared_body, prepared_grown
from shapes import bent

import qgeo_filters as qg
from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.matching import finish
from qgeo_filters.matching.level import LevelPair
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.smooth_shells import DenseMap
from qgeo_filters.surface import Surface


@pytest.mark.slow
@pytest.mark.parametrize("with_handle", [True, False])
def test_the_shape_with_fewer_handles_is_deformed(with_handle: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the map is right from either side."""
    pairs = []
    register = finish.register
    monkeypatch.setattr(finish, "register", lambda pair, *given: pairs.append(pair) or register(pair, *given))
    shapes = (prepared_grown(), prepared_body()) if with_handle else (prepared_body(), prepared_grown())
    found = qg.match(*shapes)
    genera = [(pair.x.unit.genus, pair.y.unit.genus) for pair in pairs]
    between = [g for g in genera if g[0] != g[1]]  # the others are self-symmetries
    assert between == [(0, 1)] * (2 if with_handle else 1)
    x, y = (shape.full for shape in shapes)
    assert {x.genus, y.genus} == {0, 1}
    truth = np.arange(x.n_vertices)
    assert geodesic_error(found.p2p, truth, y).mean() < 0.02
    assert geodesic_error(found.inverse, truth, x).mean() < 0.02
    assert np.linalg.norm(found.positions - y.vertices[found.p2p], axis=1).max() < 3 * y.edge_lengths.mean()


@pytest.mark.parametrize(("shapes", "lowest"), [("grown onto body", 120), ("body onto grown", 120), ("alike", 20)])
def test_what_has_grown_together_is_not_led_through_low_frequencies_at_the_end(
    shapes: str, lowest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those are the functions that a handle changes."""
    frequencies = []
    register = finish.register

    def seen(pair: LevelPair, p2p: np.ndarray, schedule: Schedule) -> DenseMap:
        frequencies.append(min(step.k for step in schedule.steps))
        return register(pair, p2p, schedule)

    monkeypatch.setattr(finish, "register", seen)
    pairs = {
        "grown onto body": (prepared_grown(), prepared_body()),
        "body onto grown": (prepared_body(), prepared_grown()),
        "alike": (prepared_body(), PreparedShape(Surface(bent(body().vertices, 0.2), body().faces))),
    }
    of = MatchProblem.of(*pairs[shapes])
    truth = np.arange(of.x.n_vertices)
    rows = np.zeros((len(truth), 1), np.float32)
    end = finish.finished(of, DenseMap(truth, truth, of.y.unit.vertices, rows, rows))
    assert frequencies[-1] == lowest
    assert geodesic_error(end.p2p, truth, pairs[shapes][1].full).mean() < 0.02


def test_turning_a_map_round_exchanges_its_sides() -> None:
    """Of a map from Y to X that lays each vertex on its partner, X lies on the undeformed Y."""
    pair = MatchProblem.of(body(), Surface(bent(body().vertices, 0.2), body().faces)).fine
    n = body().n_vertices
    forth, back = np.arange(n), np.arange(n)[::-1].copy()
    rows = np.zeros((n, 2), np.float32), np.ones((n, 2), np.float32)
    turned = finish.turned_round(pair, DenseMap(forth, back, pair.x.unit.vertices, *rows))
    np.testing.assert_array_equal(turned.p2p, back)
    np.testing.assert_array_equal(turned.inverse, forth)
    np.testing.assert_allclose(turned.positions, pair.y.unit.vertices, atol=1e-9)
    assert turned.embedding_x is rows[1]
