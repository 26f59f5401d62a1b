"""Shapes of several pieces: which belongs to which, and a map that never leads from one to another."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from shapes import Mesh, blob, creature, crooked, icosphere

import qgeo_filters as qg
from qgeo_filters.errors import MeshError, ParameterError

N = 162  # vertices of a piece; a crumb has 42


def together(*meshes: Mesh, places: tuple[float, ...] = (0, 4, 8, 12)) -> Mesh:
    """Meshes side by side as one."""
    vertices = [v + np.array([place, 0, 0]) for (v, _), place in zip(meshes, places, strict=False)]
    starts = np.cumsum([0] + [len(v) for v in vertices])
    return np.concatenate(vertices), np.concatenate([f + s for (_, f), s in zip(meshes, starts, strict=False)])


def shuffled(mesh: Mesh, seed: int) -> tuple[Mesh, np.ndarray]:
    """The same with its vertices in another order, and the new number of each."""
    order = np.random.default_rng(seed).permutation(len(mesh[0]))
    new = np.argsort(order)
    return (mesh[0][order], new[mesh[1]]), new


@functools.cache
def skull_and_jaw() -> tuple[Mesh, Mesh, np.ndarray]:
    """A large crooked body, a smaller creature, and a crumb; the same the other way round."""
    body, limb = crooked(0, 2), (0.5 * creature(level=2)[0], creature(level=2)[1])
    crumb = (0.05 * icosphere(1)[0], icosphere(1)[1])
    x = together(body, limb, crumb)
    y = together(body, limb, crumb, places=(7, -2, 3))
    moved, new = shuffled(y, 1)
    return x, moved, new


@functools.cache
def matched() -> qg.PiecewiseMatch:
    x, y, _ = skull_and_jaw()
    return qg.match_pieces(qg.Surface(*x), qg.Surface(*y))


def test_pieces_find_their_partners() -> None:
    _, _, new = skull_and_jaw()
    found = matched()
    assert found.confident, found.explanation
    assert [len(piece.vertices_x) for piece in found.pieces] == [N, N]
    large = np.arange(2 * N)
    assert (found.p2p[large] == new[large]).mean() > 0.95
    assert (found.p2p[2 * N :] == -1).all()  # the crumb
    assert (found.inverse[new[2 * N :]] == -1).all()
    body = np.isin(found.p2p, new[:N])
    assert not body[N:].any(), "a map never leads from one piece to another"
    assert repr(found).startswith("PiecewiseMatch: 2 pieces; confident")


def test_values_go_over_piece_by_piece() -> None:
    x, y, new = skull_and_jaw()
    found = matched()
    piece = np.repeat([0, 1, 2], [N, N, 42])
    there = found.transfer(piece)
    assert (there[new[:N]] == 0).all()
    assert (there[new[N : 2 * N]] == 1).all()
    assert (there[new[2 * N :]] == -1).all()
    heights = found.transfer(y[0][:, 2], to="x")
    assert np.abs(heights[: 2 * N] - x[0][: 2 * N, 2]).mean() < 0.02
    assert np.isnan(heights[2 * N :]).all()
    with pytest.raises(ParameterError, match="to must be"):
        found.transfer(piece, to="z")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="values have shape"):
        found.transfer(piece[:5])


def test_alike_pieces_are_not_sure_and_can_be_told_apart() -> None:
    pair = together(crooked(0, 2), crooked(0, 2))
    found = qg.match_pieces(pair, pair)
    assert not found.confident
    assert "say which by partners=" in found.explanation
    other = qg.match_pieces(pair, pair, partners=[(0, 1), (1, 0)])
    assert other.confident, other.explanation
    assert (other.p2p[:N] == np.arange(N, 2 * N)).mean() > 0.99


def test_a_piece_more_has_no_partner() -> None:
    x = together(crooked(0, 2), blob(2, 1))
    found = qg.match_pieces(x, crooked(0, 2))
    assert (found.p2p[:N] == np.arange(N)).mean() > 0.99
    assert (found.p2p[N:] == -1).all()
    assert "pieces of X without a partner: 1" in found.explanation


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"partners": [(0, 3)]}, "piece 3 of Y, which has 2"),
        ({"partners": [(0, 0), (0, 1)]}, "a piece of X twice"),
        ({"partners": []}, "partners is empty"),
    ],
)
def test_partners_that_cannot_be(options: dict, message: str) -> None:
    pair = together(crooked(0, 2), crooked(1, 2))
    with pytest.raises(ParameterError, match=message):
        qg.match_pieces(pair, pair, **options)


def test_crumbs_alone_are_no_shape() -> None:
    crumbs = together(*[icosphere(1)] * 4)
    with pytest.raises(
        MeshError, match="Y: no piece has 2% of the area and 60 vertices: the largest of 4 has 25% and 42"
    ):
        qg.match_pieces(crooked(0, 2), crumbs)
