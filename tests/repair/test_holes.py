"""Holes that are filled where it is asked for."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import icosphere

import qgeo_filters as qg


def holed() -> qg.Surface:
    """A sphere with a hole of a dozen edges and one of more."""
    vertices, faces = icosphere(3)
    kept = np.linalg.norm(vertices - vertices[0], axis=1) > 0.3
    kept &= np.linalg.norm(vertices - vertices[5], axis=1) > 0.5
    heights = {"height": vertices[:, 2]}
    return qg.Surface(vertices, faces, heights).submesh(kept)[0]


def test_holes_stay_unless_they_are_to_be_filled() -> None:
    surface = holed()
    assert qg.repair_surface(surface).surface is surface
    fixed = qg.repair_surface(surface, fill_holes=True)
    closed = fixed.surface
    assert (closed.euler_characteristic, len(closed.boundary_edges), closed.winding) == (2, 0, "outward")
    assert closed.is_manifold
    np.testing.assert_array_equal(closed.vertices, surface.vertices)
    np.testing.assert_array_equal(closed.attributes["height"], surface.attributes["height"])
    np.testing.assert_array_equal(closed.faces[: surface.n_faces], surface.faces)
    np.testing.assert_array_equal(fixed.face_origin[: surface.n_faces], np.arange(surface.n_faces))
    assert (fixed.face_origin[surface.n_faces :] == -1).all()
    assert fixed.report == (f"2 holes filled with {closed.n_faces - surface.n_faces} faces",)
    assert fixed.changed
    np.testing.assert_array_equal(fixed.map_back(np.arange(closed.n_vertices)), np.arange(surface.n_vertices))


def test_only_small_holes() -> None:
    surface = holed()
    some = qg.repair_surface(surface, fill_holes=len(surface.boundary_edges) // 2).surface
    assert 0 < len(some.boundary_edges) < len(surface.boundary_edges)
    assert qg.repair_surface(surface, fill_holes=3).surface is surface


def test_a_filled_mesh_matches_a_whole_one() -> None:
    """What was a scan with holes keeps the distances of the whole."""
    whole = qg.Surface(*icosphere(3))
    closed = qg.repair_surface(holed(), fill_holes=True).surface
    across = qg.distances(closed, [0]).max()
    assert across == pytest.approx(qg.distances(whole, [0]).max(), rel=0.05)


@pytest.mark.parametrize("value", [2, -1, 0, 4.5, "all"])
def test_numbers_that_are_none(value: object) -> None:
    with pytest.raises(qg.ParameterError, match="fill_holes must be True, False or a number of edges"):
        qg.repair_surface(holed(), fill_holes=value)  # type: ignore[arg-type]


def test_a_closed_mesh_has_nothing_to_fill() -> None:
    surface = qg.Surface(*icosphere(2))
    fixed = qg.repair_surface(surface, fill_holes=True)
    assert fixed.surface is surface
    assert not fixed.changed
