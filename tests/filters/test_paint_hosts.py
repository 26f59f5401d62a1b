"""Paint reaches the colours that each host's own viewer shows."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.testing import sample_surface

PIPE = qg.SurfaceScalar() | qg.Paint(attribute="qgeo_scalar")


@pytest.fixture(scope="module")
def expected() -> np.ndarray:
    return PIPE(sample_surface()).attributes["colors"]


def test_legacy_open3d_draws_it(expected: np.ndarray) -> None:
    o3d = pytest.importorskip("open3d")
    surface = sample_surface()
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(surface.vertices.copy()), o3d.utility.Vector3iVector(surface.faces.copy())
    )
    painted = PIPE(mesh).to_legacy()
    assert painted.has_vertex_colors()
    assert np.allclose(np.asarray(painted.vertex_colors), expected, atol=1e-6)
    assert not mesh.has_vertex_colors()


def test_meshlab_shows_it(expected: np.ndarray) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    surface = sample_surface()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    painted = PIPE(meshes)
    colors = painted.current_mesh().vertex_color_matrix()
    assert np.abs(colors[:, :3] - expected).max() <= 0.5 / 255 + 1e-6  # eight bits a channel
    assert np.allclose(colors[:, 3], 1)
    assert (meshes.current_mesh().vertex_color_matrix() == 1).all()
    values = painted.current_mesh().vertex_custom_scalar_attribute_array("qgeo_scalar")
    assert np.allclose(values, qg.surface_scalar(surface), rtol=1e-6)


def test_pyvista_can_plot_it(expected: np.ndarray) -> None:
    pyvista = pytest.importorskip("pyvista")
    surface = sample_surface()
    painted = PIPE(pyvista.PolyData.from_regular_faces(surface.vertices, surface.faces))
    assert np.allclose(painted.point_data["colors"], expected)  # mesh.plot(scalars="colors", rgb=True)
