"""From a coarse map to one between all vertices."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.deformation import arap
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.selection import cost
from qgeo_filters.matching.smooth_shells import ENDING, RECONSIDERING, SETTLING, TRIAL, Pass, factorised, finished
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def pair() -> tuple[PreparedShape, PreparedShape]:
    vertices, faces = blob(3, 0)
    bent = vertices + 0.1 * np.sin(2 * vertices[:, [1, 2, 0]])
    return PreparedShape(Surface(vertices, faces)), PreparedShape(Surface(bent, faces))


@pytest.mark.parametrize(
    "passes",
    [TRIAL, SETTLING, RECONSIDERING, TRIAL + SETTLING, ENDING],
    ids=["trial", "settling", "reconsidering", "trial and settling", "ending"],
)
def test_nothing_is_factorised_in_a_thread(
    pair: tuple[PreparedShape, PreparedShape], passes: tuple[Pass, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """SciPy would leak it."""
    x, y = pair
    x.rigidity.release()
    factorised(x, y, passes)

    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("factorised while maps are tried side by side")

    monkeypatch.setattr(arap, "splu", forbidden)
    found = finished(x, y, np.arange(x.n_vertices), passes)
    off = np.linalg.norm(found.positions - y.unit.vertices, axis=1)
    assert off.mean() < 0.05
    assert (found.p2p == np.arange(x.n_vertices)).mean() > 0.8


def test_factorisations_are_dropped_when_a_match_is_interrupted(
    pair: tuple[PreparedShape, PreparedShape], monkeypatch: pytest.MonkeyPatch
) -> None:
    x, y = pair
    x.rigidity.release()
    used = []

    def interrupted(x: PreparedShape, *_: object) -> None:
        used.append(len(x.rigidity._factors))
        raise KeyboardInterrupt

    monkeypatch.setattr(cost, "likeness", interrupted)
    with pytest.raises(KeyboardInterrupt):
        match(x, y)
    assert max(used) > 0
    assert not x.rigidity._factors
    assert not y.rigidity._factors


def test_the_map_and_its_inverse_are_nearest_neighbours_in_what_was_compared(
    pair: tuple[PreparedShape, PreparedShape],
) -> None:
    x, y = pair
    found = finished(x, y, np.arange(x.n_vertices))
    squared = ((found.embedding_x[:, None] - found.embedding_y) ** 2).sum(axis=2)
    nearest = np.take_along_axis(squared, found.p2p[:, None], axis=1)[:, 0]
    np.testing.assert_allclose(nearest, squared.min(axis=1), rtol=1e-4, atol=1e-9)
    back = squared[found.inverse, np.arange(y.n_vertices)]
    np.testing.assert_allclose(back, squared.min(axis=0), rtol=1e-4, atol=1e-9)


def test_the_order_in_which_points_are_given_does_not_matter(pair: tuple[PreparedShape, PreparedShape]) -> None:
    """All vertices as farthest points, in their order: what a shape of few vertices starts from."""
    x, y = pair
    assert len(x.samples) == x.n_vertices
    one = finished(x, y, np.arange(x.n_vertices), TRIAL)
    other = finished(x, y, x.samples, TRIAL, x.samples)
    np.testing.assert_allclose(other.positions, one.positions, atol=1e-4)


def test_some_points_are_enough_to_start_from(pair: tuple[PreparedShape, PreparedShape]) -> None:
    x, y = pair
    points = x.samples[:150]
    found = finished(x, y, points, SETTLING, points)
    assert np.linalg.norm(found.positions - y.unit.vertices, axis=1).mean() < 0.05
