"""Point maps backwards and their orientation; curves where a function changes sign."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from qgeo_filters import Surface
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
        (-np.ones(162, dtype=int), r"p2p\[0\] is vertex -1"),
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
