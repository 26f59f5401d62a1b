"""Point maps backwards and their orientation; curves where a function changes sign."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from qgeo_filters import Surface, repair_surface
from qgeo_widgets.contours import sign_changes
from qgeo_widgets.vertex_map import VertexMap


def test_backward_inverts_a_bijection(pair):
    x, y, where = pair
    mapped = VertexMap(x, y, where)
    np.testing.assert_array_equal(where[mapped.backward], np.arange(y.n_vertices))


def test_backward_takes_the_nearest_image():
    plane = Surface(*shapes.grid(10))
    few = Surface(plane.vertices[[0, 1, 2]] + [[0, 0, 0], [0, 0, 0], [0, 0, 1]], [[0, 1, 2]])
    mapped = VertexMap(few, plane, [0, 10, 120])
    for vertex, origin in ((0, 0), (2, 0), (10, 1), (8, 1), (120, 2), (119, 2)):
        assert mapped.backward[vertex] == origin


def test_what_is_far_from_all_images_has_no_partner_where_some_of_x_have_none(pair):
    """Half of a shape on the whole: what lies more than an edge off has none, what is covered keeps its own."""
    x, y, where = pair
    left = x.vertices[:, 0] < 0
    half = VertexMap(x, y, np.where(left, where, -1))
    np.testing.assert_array_equal(half.backward[where[left]], np.flatnonzero(left))
    alone = half.backward < 0
    assert half.unmatched == ((~left).sum(), alone.sum())
    near = np.zeros(y.n_vertices, dtype=bool)
    near[y.edges[left[np.argsort(where)][y.edges].any(axis=1)]] = True
    assert not (near & alone).any() or y.edge_lengths.max() > np.quantile(y.edge_lengths, 0.95)
    assert alone[~near].all()
    values = half.on_y(x.vertices)
    np.testing.assert_array_equal(np.isnan(values).all(axis=1), alone)
    np.testing.assert_array_equal(half.on_y(np.arange(x.n_vertices))[alone], -1)


def test_a_map_that_is_known_backwards_is_taken_so(pair):
    x, y, where = pair
    inverse = np.where(np.arange(y.n_vertices) < 7, -1, np.argsort(where))
    mapped = VertexMap(x, y, where, inverse=inverse)
    np.testing.assert_array_equal(mapped.backward, inverse)
    twice = np.roll(np.arange(y.n_vertices), 81)  # its own inverse
    twin = mapped.then(twice)
    np.testing.assert_array_equal(twin.forward, twice[where])
    np.testing.assert_array_equal(twin.backward, inverse[twice])
    lost = VertexMap(x, y, np.where(where == 3, -1, where)).then(np.where(twice == 5, -1, twice))
    np.testing.assert_array_equal(lost.forward < 0, (where == 3) | (twice[where] == 5))


def test_orientation_is_of_the_triangles_that_have_partners(pair):
    x, y, where = pair
    left = x.vertices[:, 0] < 0
    assert VertexMap(x, y, np.where(left, where, -1)).orientation > 0.9
    mirrored = Surface(y.vertices * [1, 1, -1], y.faces[:, ::-1])
    assert VertexMap(x, mirrored, np.where(left, where, -1)).orientation < -0.9
    alone = np.where(np.arange(x.n_vertices) == 3, where, -1)
    assert VertexMap(x, y, alone).orientation == 0.0


def test_ways_on_what_is_not_welded_are_those_of_its_repair(pair):
    """Triangles that share no vertex: along their own edges nothing is near to anything."""
    x, y, where = pair
    soup = Surface(y.vertices[y.faces.ravel()], np.arange(3 * y.n_faces).reshape(-1, 3))
    repair = repair_surface(soup)
    corner = np.zeros(y.n_vertices, dtype=int)
    corner[y.faces.ravel()] = np.arange(3 * y.n_faces)
    mapped = VertexMap(x, soup, corner[where], repairs=(None, repair))
    np.testing.assert_array_equal(where[mapped.backward], y.faces.ravel())
    assert mapped.orientation == pytest.approx(VertexMap(x, y, where).orientation, abs=1e-12)


def test_orientation_tells_a_map_from_its_mirror_image(pair):
    x, y, where = pair
    assert VertexMap(x, y, where).orientation > 0.9
    mirrored = Surface(y.vertices * [1, 1, -1], y.faces[:, ::-1])
    assert VertexMap(x, mirrored, where).orientation < -0.9
    constant = np.zeros(x.n_vertices, dtype=int)
    assert VertexMap(x, y, constant).orientation == 0.0


@pytest.mark.parametrize(
    ("p2p", "message"),
    [
        ([0, 1], "p2p must be 162 vertex indices"),
        (np.full(162, 0.5), "p2p must be 162 vertex indices"),
        (np.full(162, 400), r"p2p\[0\] is vertex 400, but Y has 162 vertices"),
        (np.full(162, -2), r"p2p\[0\] is vertex -2, .* -1 stands for no partner"),
        (-np.ones(162, dtype=int), "no vertex of X has a partner: all 162 of p2p are -1"),
    ],
)
def test_a_bad_map_is_refused(pair, p2p, message):
    with pytest.raises(ValueError, match=message):
        VertexMap(*pair[:2], p2p)


def test_sign_change_is_a_closed_circle():
    sphere = Surface(*shapes.icosphere(4))
    curves = sign_changes(sphere, sphere.vertices[:, 2] - 0.3)
    assert len(curves) == 1
    np.testing.assert_array_equal(curves[0][0], curves[0][-1])
    np.testing.assert_allclose(curves[0][:, 2], 0.3, atol=1e-12)
    length = np.linalg.norm(np.diff(curves[0], axis=0), axis=1).sum()
    assert length == pytest.approx(2 * np.pi * np.sqrt(1 - 0.09), rel=2e-2)


def test_sign_change_on_an_open_surface_ends_at_its_boundary():
    plane = Surface(*shapes.grid(8))
    curves = sign_changes(plane, plane.vertices[:, 0] - 0.3)
    assert len(curves) == 1
    assert {round(float(p[1]), 9) for p in curves[0][[0, -1]]} == {0.0, 1.0}
    assert sign_changes(plane, np.ones(plane.n_vertices)) == []
