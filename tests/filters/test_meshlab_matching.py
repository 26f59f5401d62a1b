"""Symmetry, correspondence, transfer and saving as methods of ``pymeshlab.MeshSet``."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.filters.meshlab_in_place import set_colors
from qgeo_filters.report.colors import MISSING, diverging, mirror_colors, position_colors, sequential
from qgeo_filters.testing import sample_surface

pymeshlab = pytest.importorskip("pymeshlab")

SURFACE = sample_surface()
N = SURFACE.n_vertices
SHUFFLED = np.random.default_rng(5).permutation(N)  # vertex of SURFACE for each of the other layer
STEP = 0.5 / 255 + 1e-9  # colours have eight bits


def mirrored_body() -> qg.Surface:
    """Its own mirror image in x = 0, and lopsided otherwise."""
    ball = SURFACE.vertices / [1.4, 1, 0.8]
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    radius = 1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]
    return SURFACE.with_vertices(ball * [1, 1.6, 0.7] * radius)


BODY = mirrored_body()


def layers(*surfaces: qg.Surface) -> pymeshlab.MeshSet:
    """A MeshSet of these, the last of them its current mesh."""
    qg.register_pymeshlab()
    meshes = pymeshlab.MeshSet()
    for surface in surfaces:
        meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.faces)))
    return meshes


def elsewhere() -> qg.Surface:
    """The surface twice as large, elsewhere, its vertices in another order."""
    place = np.argsort(SHUFFLED)
    return qg.Surface(2 * SURFACE.vertices[SHUFFLED] + [5, 0, 0], place[SURFACE.faces])


def colors(mesh: pymeshlab.Mesh) -> np.ndarray:
    return mesh.vertex_color_matrix()[:, :3]


@pytest.mark.parametrize("quantity", ["asymmetry", "side", "mirror_vertex"])
def test_symmetry_is_the_scalar_and_mirror_points_have_one_color(quantity: str) -> None:
    meshes = layers(BODY)
    answer = meshes.compute_scalar_by_self_symmetry_per_vertex(quantity=quantity)
    expected = qg.self_symmetry(BODY)
    assert answer["found"]
    assert answer["reason"] == expected.reason
    np.testing.assert_array_equal(answer["mirror_vertex"], expected.p2p)
    np.testing.assert_allclose(meshes.current_mesh().vertex_scalar_array(), answer[quantity], rtol=1e-6)
    painted = colors(meshes.current_mesh())
    np.testing.assert_array_equal(painted, painted[expected.p2p])
    np.testing.assert_allclose(painted, mirror_colors(BODY.vertices, expected.p2p, np.eye(3)), atol=STEP)
    assert len(np.unique(painted, axis=0)) > N / 4


def test_without_a_symmetry_nothing_is_painted() -> None:
    meshes = layers(SURFACE)
    before = colors(meshes.current_mesh())
    answer = meshes.compute_scalar_by_self_symmetry_per_vertex(quantity="side")
    assert not answer["found"]
    assert answer["reason"] == qg.self_symmetry(SURFACE).reason
    assert not meshes.current_mesh().vertex_scalar_array().any()
    np.testing.assert_array_equal(colors(meshes.current_mesh()), before)


def test_what_belongs_together_has_one_color_on_both_layers() -> None:
    meshes = layers(SURFACE, elsewhere())
    answer = meshes.compute_scalar_by_correspondence_per_vertex(targetmesh=0, quantity="corresponding_vertex")
    np.testing.assert_array_equal(answer["corresponding_vertex"], SHUFFLED)
    np.testing.assert_array_equal(meshes.current_mesh().vertex_scalar_array(), SHUFFLED)
    assert answer["confident"]
    assert answer["explanation"].startswith("distances are kept")
    assert meshes.current_mesh_id() == 1
    of_source, of_target = colors(meshes.mesh(1)), colors(meshes.mesh(0))
    np.testing.assert_array_equal(of_source, of_target[SHUFFLED])
    np.testing.assert_allclose(of_target, position_colors(SURFACE.vertices, np.eye(3)), atol=STEP)


def test_regions_are_the_scalar_of_both_layers_and_paint_can_be_left_alone() -> None:
    meshes = layers(SURFACE, elsewhere())
    before = colors(meshes.mesh(0)), colors(meshes.mesh(1))
    meshes.compute_scalar_by_correspondence_per_vertex(targetmesh=0, quantity="region", colorize=False)
    of_x, of_y = meshes.mesh(1).vertex_scalar_array(), meshes.mesh(0).vertex_scalar_array()
    found = qg.match(elsewhere(), SURFACE)
    np.testing.assert_array_equal(of_x, found.regions_x)
    np.testing.assert_array_equal(of_y, found.regions_y)
    assert len(np.unique(of_x)) > 2
    np.testing.assert_array_equal(colors(meshes.mesh(0)), before[0])
    np.testing.assert_array_equal(colors(meshes.mesh(1)), before[1])


def test_transfer_brings_scalar_colors_and_custom_attributes() -> None:
    meshes = layers(SURFACE, elsewhere())
    meshes.set_current_mesh(0)
    layer = meshes.current_mesh()
    layer.add_vertex_custom_scalar_attribute(SURFACE.vertices[:, 1].copy(), "height")
    layer.add_vertex_custom_point_attribute(np.array(SURFACE.vertices), "place")
    meshes.compute_scalar_by_function_per_vertex(q="x")
    set_colors(meshes, position_colors(SURFACE.vertices, np.eye(3)))
    meshes.set_current_mesh(1)
    meshes.current_mesh().add_vertex_custom_scalar_attribute(np.zeros(N), "height")  # a name that is taken
    answer = meshes.transfer_attributes_by_correspondence_per_vertex(sourcemesh=0)
    assert answer["confident"]
    assert sorted(answer["attributes"]) == ["colors", "height_v2", "place", "scalar"]
    target = meshes.current_mesh()
    truth = SURFACE.vertices[SHUFFLED]
    np.testing.assert_allclose(target.vertex_custom_scalar_attribute_array("height_v2"), truth[:, 1], atol=1e-3)
    np.testing.assert_allclose(target.vertex_custom_point_attribute_matrix("place"), truth, atol=1e-3)
    np.testing.assert_allclose(target.vertex_scalar_array(), truth[:, 0], atol=1e-3)
    np.testing.assert_allclose(colors(target), colors(meshes.mesh(0))[SHUFFLED], atol=3 * STEP)


def test_the_current_mesh_moves_as_the_layers_do() -> None:
    factors = np.array([1.0, 1.3, 1.0])
    meshes = layers(SURFACE, SURFACE.with_vertices(SURFACE.vertices * factors), elsewhere())
    answer = meshes.compute_coord_by_deformation_transfer(sourcemesh=0, posemesh=1)
    moved = meshes.current_mesh().vertex_matrix()
    expected = qg.transfer_deformation(SURFACE, [SURFACE.vertices * factors], elsewhere())[0].vertices
    np.testing.assert_allclose(moved, expected, atol=1e-6)
    assert answer["maximum"] == pytest.approx(np.linalg.norm(expected - elsewhere().vertices, axis=1).max())
    assert answer["maximum"] > 0.1
    assert [mesh.id() for mesh in meshes] == [0, 1, 2]
    assert meshes.current_mesh_id() == 2
    assert meshes.current_mesh().vertex_normal_matrix().any()


def test_what_is_saved_is_read_by_both(tmp_path) -> None:
    meshes = layers(BODY)
    meshes.compute_scalar_by_self_symmetry_per_vertex(quantity="side")
    answer = meshes.save_current_mesh_with_attributes(tmp_path / "a.ply")
    assert sorted(answer["attributes"]) == ["colors", "qgeo_side", "quality"]
    saved = qg.Surface.read(tmp_path / "a.ply")
    side = qg.self_symmetry(BODY).side
    np.testing.assert_array_equal(saved.vertices, meshes.current_mesh().vertex_matrix())
    np.testing.assert_array_equal(saved.attributes["qgeo_side"], side)
    np.testing.assert_array_equal(saved.attributes["quality"], side)
    again = pymeshlab.MeshSet()
    again.load_new_mesh(str(tmp_path / "a.ply"))
    np.testing.assert_array_equal(again.current_mesh().vertex_scalar_array(), side)
    with pytest.raises(qg.ParameterError, match=r"file_name must end in \.ply, .* got 'a\.obj'"):
        meshes.save_current_mesh_with_attributes(tmp_path / "a.obj")


def test_scalars_can_be_painted() -> None:
    meshes = layers(SURFACE)
    meshes.compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex(colorize=True)
    scalar = meshes.current_mesh().vertex_scalar_array()
    np.testing.assert_allclose(colors(meshes.current_mesh()), sequential(scalar)(scalar), atol=0.01)
    phi = meshes.compute_scalar_by_quasi_geodesic_spectrum_per_vertex(component=1, k=3, colorize=True)
    shown = phi["eigenfunctions"][:, 1]
    np.testing.assert_allclose(colors(meshes.current_mesh()), diverging(shown)(shown), atol=STEP)


def test_any_color_arrives_to_the_last_bit() -> None:
    meshes = layers(SURFACE)
    wanted = np.random.default_rng(0).integers(0, 256, (N, 3)) / 255
    wanted[:4] = [[0, 0, 0], [1, 1, 1], [1, 0, 1 / 255], MISSING]
    set_colors(meshes, wanted)
    np.testing.assert_array_equal(np.round(255 * colors(meshes.current_mesh())), np.round(255 * wanted))


def test_bad_arguments_get_one_sentence() -> None:
    meshes = layers(SURFACE, SURFACE)
    with pytest.raises(qg.ParameterError, match=r"targetmesh must be a layer of the MeshSet, one of \[0, 1\], got 7"):
        meshes.compute_scalar_by_correspondence_per_vertex(targetmesh=7)
    with pytest.raises(qg.ParameterError, match=r"sourcemesh must be a layer .*, got True"):
        meshes.transfer_attributes_by_correspondence_per_vertex(sourcemesh=True)
    with pytest.raises(qg.ParameterError, match="quantity must be one of asymmetry, side, mirror_vertex, got 'sides'"):
        meshes.compute_scalar_by_self_symmetry_per_vertex(quantity="sides")
