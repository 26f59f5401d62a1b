"""What is shown of a mesh, what is measured in its place, and what matching is given."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
from qgeo_filters import Surface
from qgeo_widgets.shown_mesh import ShownMesh


def beside(*meshes: shapes.Mesh) -> shapes.Mesh:
    """Meshes in one, each ten to the right of the one before."""
    count, vertices, faces = 0, [], []
    for number, (points, triangles) in enumerate(meshes):
        vertices.append(points + np.array([10.0 * number, 0, 0]))
        faces.append(triangles + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(faces)


def test_a_surface_with_nothing_wrong_is_itself():
    surface = Surface(*shapes.icosphere(2))
    for repair in ("auto", True, False, "force"):
        mesh = ShownMesh.of(surface, repair)
        assert mesh.surface is mesh.measured is mesh.to_match[0] is surface
        assert mesh.repair is None


def test_crumbs_are_left_out_of_one_piece_and_kept_where_pieces_do_not_matter():
    crumb, ball = shapes.icosphere(0, 0.1), shapes.icosphere(2)
    surface = Surface(*beside(ball, crumb))
    mesh = ShownMesh.of(surface)
    assert mesh.surface is surface
    assert mesh.measured.n_vertices == len(ball[0])
    assert mesh.to_match == (mesh.repair, False)
    np.testing.assert_array_equal(mesh.repair.vertex_of_original < 0, np.arange(surface.n_vertices) >= len(ball[0]))
    assert ShownMesh.of(surface, pieces="all").measured is surface


def test_large_pieces_are_measured_as_they_are_and_left_for_matching_to_refuse():
    surface = Surface(*beside(shapes.icosphere(1), shapes.icosphere(1)))
    mesh = ShownMesh.of(surface)
    assert mesh.measured is surface
    assert mesh.to_match == (surface, "auto")
    soup = Surface(surface.vertices[surface.faces.ravel()], np.arange(3 * surface.n_faces).reshape(-1, 3))
    welded = ShownMesh.of(soup)
    assert welded.measured.n_vertices == surface.n_vertices  # both pieces of it
    assert welded.to_match == (soup, "auto")
    with pytest.raises(qg.MeshError, match="pieces"):
        ShownMesh.of(soup, True)


def test_what_no_surface_can_hold_is_shown_without_that_or_refused():
    vertices, faces = shapes.icosphere(2)
    bad = np.concatenate([faces, [[0, 1, 500]]])
    mesh = ShownMesh.of((vertices, bad))
    np.testing.assert_array_equal(mesh.surface.vertices, vertices)
    np.testing.assert_array_equal(mesh.surface.faces, faces)
    assert "missing vertices" in " ".join(mesh.repair.report)
    with pytest.raises(qg.MeshError, match="500"):
        ShownMesh.of((vertices, bad), False)
    wrapped = ShownMesh.of((vertices, bad), "wrap")
    assert "missing vertices" in wrapped.repair.report[0]
    assert wrapped.repair.given is wrapped.surface
    with pytest.raises(qg.MeshError):
        ShownMesh.of((vertices, [[0, 1, 500]]))
    with pytest.raises(qg.ParameterError, match="repair must be"):
        ShownMesh.of((vertices, faces), "glue")


def test_a_repair_stands_as_it_is():
    crumb, ball = shapes.icosphere(0, 0.1), shapes.icosphere(2)
    repair = qg.repair_surface(Surface(*beside(ball, crumb)))
    for option in ("auto", False, "wrap"):
        mesh = ShownMesh.of(repair, option)
        assert mesh.surface is repair.given
        assert mesh.measured is repair.surface
        assert mesh.to_match == (repair, False)
