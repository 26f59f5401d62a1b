"""Curves as lines of each library."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.testing import sample_surface

SURFACE = sample_surface()
PATHS = [qg.quasi_geodesic(SURFACE, 0, 50), qg.quasi_geodesic(SURFACE, 3, 80)]
POINTS = np.concatenate([path.points for path in PATHS])
FIRST = len(PATHS[0].points)
ENDS = [(k, k + 1) for k in range(len(POINTS) - 1) if k != FIRST - 1]  # none from the one curve to the other


def test_open3d() -> None:
    open3d = pytest.importorskip("open3d")
    drawn = qg.polylines(PATHS, "open3d")
    assert type(drawn) is open3d.geometry.LineSet
    np.testing.assert_array_equal(drawn.points, POINTS)
    np.testing.assert_array_equal(drawn.lines, ENDS)


def test_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    drawn = qg.polylines(PATHS, "pyvista")
    assert type(drawn) is pyvista.PolyData
    np.testing.assert_array_equal(drawn.points, POINTS)
    assert drawn.n_lines == 2
    np.testing.assert_array_equal(drawn.lines[: FIRST + 1], [FIRST, *range(FIRST)])
    assert qg.polylines([], "pyvista").n_lines == 0


def test_trimesh() -> None:
    drawn = qg.polylines(PATHS, "trimesh")
    assert type(drawn).__name__ == "Path3D"
    assert [len(entity.points) for entity in drawn.entities] == [len(path.points) for path in PATHS]
    assert drawn.length == pytest.approx(sum(path.length for path in PATHS))


def test_vedo() -> None:
    vedo = pytest.importorskip("vedo")
    drawn = qg.polylines(PATHS, "vedo")
    assert isinstance(drawn, vedo.Lines)
    np.testing.assert_allclose(np.asarray(drawn.coordinates)[::2], POINTS[[i for i, _ in ENDS]], rtol=1e-6)


def test_meshio() -> None:
    pytest.importorskip("meshio")
    drawn = qg.polylines(PATHS, "meshio")
    np.testing.assert_array_equal(drawn.points, POINTS)
    np.testing.assert_array_equal(drawn.get_cells_type("line"), ENDS)


def test_pymeshlab() -> None:
    pytest.importorskip("pymeshlab")
    meshes = qg.polylines(PATHS, "pymeshlab")
    mesh = meshes.current_mesh()
    np.testing.assert_array_equal(mesh.vertex_matrix(), POINTS)
    np.testing.assert_array_equal(mesh.edge_matrix(), ENDS)


def test_curves_come_as_paths_arrays_and_lists() -> None:
    pytest.importorskip("meshio")
    one = PATHS[0].points
    for curves in (PATHS[0], one, one.tolist(), [one], (one,), [PATHS[0]]):
        np.testing.assert_array_equal(qg.polylines(curves, "meshio").points, one)


def test_what_is_no_curve_and_who_draws_none() -> None:
    with pytest.raises(qg.ParameterError, match=r"points in space, of shape \(k, 3\), got \(4, 2\)"):
        qg.polylines(np.zeros((4, 2)), "trimesh")
    with pytest.raises(qg.ParameterError, match=r"library must be one of .*open3d.*, got 'blender'"):
        qg.polylines(PATHS, "blender")
