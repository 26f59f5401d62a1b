"""Results of repaired shapes on the vertices and faces that were given, from index to index and through `match`."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from shapes import bent, creature

import qgeo_filters as qg
from qgeo_filters.matching.given_vertices import match_on_given, symmetry_on_given
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.surface import Surface

X, F = creature(0.4, level=2)  # no left and right
Y = bent(X, 0.3)
N = len(X)
CRUMB = np.array([[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0]])


@cache
def clean() -> MatchResult:
    return qg.match((X, F), (Y, F))


def spoilt(vertices: np.ndarray, faces: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Vertices and faces with all kinds of mess in random order; the clean vertex of each, or -1; the clean faces'.

    Each face has its own corners, a third is turned over, some are there twice; a crumb, a loose vertex and one that
    is not finite are added.
    """
    random = np.random.default_rng(seed)
    where = faces.ravel()
    turned = random.random(len(faces)) < 1 / 3
    own = np.arange(3 * len(faces)).reshape(-1, 3)
    own[turned] = own[turned, ::-1]
    points = np.concatenate([vertices[where], CRUMB, [[1.0, 2, 3], [np.nan, 0, 0]]])
    of_clean = np.concatenate([where, np.full(5, -1)])
    crumb = len(where) + np.arange(3)
    all_faces = np.concatenate([own, own[5:8], [crumb]])
    of_face = np.concatenate([np.arange(len(faces)), [5, 6, 7, -1]])
    shuffled = random.permutation(len(points))
    place = np.argsort(shuffled)
    order = random.permutation(len(all_faces))
    return points[shuffled], place[all_faces[order]], of_clean[shuffled], of_face[order]


def renumbered(found: MatchResult, x: PreparedShape, y: PreparedShape, of_x: np.ndarray, of_y: np.ndarray):
    """The clean result on the vertices and faces of the repaired shapes: what matching these would give."""
    new_of_old_y = np.empty(N, dtype=int)
    new_of_old_y[of_y[y.repair.origin]] = np.arange(N)
    new_of_old_x = np.empty(N, dtype=int)
    new_of_old_x[of_x[x.repair.origin]] = np.arange(N)
    old_x, old_y = of_x[x.repair.origin], of_y[y.repair.origin]
    rows = {tuple(sorted(face)): number for number, face in enumerate(y.full.faces.tolist())}
    corners = new_of_old_y[found.barycentric.corners][old_x]
    faces = np.array([rows[tuple(sorted(face))] for face in corners.tolist()])
    weights = found.barycentric.coordinates[old_x]
    ordered = np.array(
        [[w[list(c).index(v)] for v in y.full.faces[f]] for w, c, f in zip(weights, corners, faces, strict=True)]
    )
    place = type(found.barycentric)(faces, y.full.faces[faces].astype(np.int64), ordered)
    changes = {
        "x": x.full,
        "y": y.full,
        "p2p": new_of_old_y[found.p2p][old_x],
        "inverse": new_of_old_x[found.inverse][old_y],
        "distortion": found.distortion[old_x],
        "regions_x": found.regions_x[old_x],
        "regions_y": found.regions_y[old_y],
        "positions": found.positions[old_x],
        "barycentric": place,
    }
    return type(found)(**{**found.__dict__, **changes})


def test_every_result_comes_back_on_the_given_vertices() -> None:
    """A soup of turned, doubled, shuffled faces with crumbs: each corner has what its clean vertex has."""
    vertices_x, faces_x, of_x, _ = spoilt(X, F, 1)
    vertices_y, faces_y, of_y, _ = spoilt(Y, F, 2)
    x, y = PreparedShape((vertices_x, faces_x)), PreparedShape((vertices_y, faces_y))
    assert x.full.n_vertices == y.full.n_vertices == N
    assert x.full.is_oriented
    back = match_on_given(renumbered(clean(), x, y, of_x, of_y), x, y)
    here, there = of_x >= 0, of_y >= 0
    assert back.x is x.given
    assert back.x.n_vertices == len(back.p2p) == len(vertices_x)
    np.testing.assert_array_equal(of_y[back.p2p[here]], clean().p2p[of_x[here]])
    np.testing.assert_array_equal(of_x[back.inverse[there]], clean().inverse[of_y[there]])
    for name in ("distortion", "regions_x", "positions"):
        np.testing.assert_array_equal(getattr(back, name)[here], getattr(clean(), name)[of_x[here]])
    np.testing.assert_array_equal(back.regions_y[there], clean().regions_y[of_y[there]])
    assert (back.p2p[~here] == -1).all()
    assert (back.inverse[~there] == -1).all()
    assert (back.regions_x[~here] == -1).all()
    assert np.isnan(back.distortion[~here]).all()
    assert np.isnan(back.positions[~here]).all()
    # Triangles are given ones, so that values of the given vertices of Y interpolate to those of the clean mesh.
    place = back.barycentric
    np.testing.assert_array_equal(place.corners[here], back.y.faces[place.faces[here]])
    np.testing.assert_allclose(
        place.pulled_back(np.nan_to_num(vertices_y))[here],
        clean().barycentric.pulled_back(Y)[of_x[here]],
        atol=1e-12,
    )
    assert (place.faces[~here] == -1).all()
    assert np.isnan(place.pulled_back(back.y.vertices)[~here]).all()
    assert (place.pulled_back(np.arange(len(vertices_y), dtype=np.int32))[~here] == -1).all()
    assert any(line.startswith("X: 1 vertex with coordinates that are not finite") for line in back.repairs)
    assert any(line.startswith("Y: ") and "smaller piece" in line for line in back.repairs)
    for array in (back.p2p, back.inverse, back.distortion, back.regions_y, back.positions, place.faces, place.corners):
        assert not array.flags.writeable


def test_faces_of_a_repair_are_those_of_the_given_mesh() -> None:
    vertices, faces, of_clean, of_face = spoilt(X, F, 3)
    repair = PreparedShape((vertices, faces)).repair
    assert sorted(of_face[repair.face_origin]) == list(range(len(F)))
    corners = of_clean[repair.given.faces[repair.face_origin]]
    corners[repair.turned] = corners[repair.turned, ::-1]
    np.testing.assert_array_equal(corners, of_clean[repair.origin[repair.surface.faces]])


def test_a_tidy_mesh_is_taken_as_it_is() -> None:
    surface = Surface(X, F)
    shape = PreparedShape(surface)
    assert shape.repair is None
    assert shape.given is shape.full is surface
    assert match_on_given(clean(), shape, shape) is clean()
    assert clean().repairs == ()
    turned = PreparedShape(surface.turned_over())
    assert turned.repair is None  # matching turns what is inside out itself, and says so
    assert turned.winding == "inward"


def test_without_repair_a_mess_is_refused_as_before() -> None:
    vertices, faces, *_ = spoilt(X, F, 1)
    with pytest.raises(qg.MeshError, match="coordinates must be finite"):
        PreparedShape((vertices, faces), repair=False)
    with pytest.raises(qg.MeshError, match=r"X: matching needs a manifold mesh.*repair=True"):
        qg.match((X, np.concatenate([F, F[:1, [0, 1, 2]]])), (Y, F), repair=False)
    with pytest.raises(qg.MeshError, match="disagree"):
        qg.self_symmetry((X, np.concatenate([F[:1, ::-1], F[1:]])), repair=False)
    with pytest.raises(qg.ParameterError, match="repair must be 'auto', True, False, 'force' or 'wrap', got 'yes'"):
        qg.self_symmetry((X, F), repair="yes")


def test_the_map_of_a_mess_is_that_of_the_clean_mesh() -> None:
    vertices, faces, of_x, _ = spoilt(X, F, 4)
    found = qg.match((vertices, faces), (Y, F))
    here = of_x >= 0
    edge = Surface(Y, F).edge_lengths.max()
    off = np.linalg.norm(Y[found.p2p[here]] - Y[clean().p2p[of_x[here]]], axis=1)
    assert off.max() <= edge
    assert (found.p2p[~here] == -1).all()
    assert found.confident == clean().confident
    truth = np.where(here, clean().p2p[of_x], -1)
    errors = found.error(truth)
    assert np.isnan(errors[~here]).all()
    assert np.nanmax(errors) * np.sqrt(Surface(Y, F).area) <= 2 * edge
    assert found.repairs


def test_the_symmetry_of_a_mess_is_that_of_the_clean_mesh() -> None:
    vertices, faces = creature(level=2)
    spoilt_vertices, spoilt_faces, of_clean, _ = spoilt(vertices, faces, 5)
    wanted = qg.self_symmetry((vertices, faces))
    shape = PreparedShape((spoilt_vertices, spoilt_faces))
    found = qg.self_symmetry(shape)
    here = of_clean >= 0
    assert wanted.found
    assert found.found
    edge = Surface(vertices, faces).edge_lengths.max()
    for name in ("p2p", "nearest"):
        there = of_clean[getattr(found, name)[here]]
        off = np.linalg.norm(vertices[there] - vertices[getattr(wanted, name)[of_clean[here]]], axis=1)
        assert off.max() <= edge
        assert (getattr(found, name)[~here] == -1).all()
    # An involution up to vertices that lie on each other.
    np.testing.assert_array_equal(of_clean[found.p2p[found.p2p[here]]], of_clean[here])
    assert not found.side[~here].any()
    assert not found.fixed[~here].any()
    assert np.isnan(found.asymmetry[~here]).all()
    assert found.repairs == shape.repair.report
    assert qg.self_symmetry((vertices, faces)).repairs == ()
    assert symmetry_on_given(wanted, PreparedShape((vertices, faces))) is wanted
