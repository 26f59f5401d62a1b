"""Surface: every derived quantity against formulas, Euler's relation and libigl."""

from __future__ import annotations

import pickle

import igl
import numpy as np
import pytest
from shapes import blob, bow_tie, cone, cylinder, fan, grid, icosphere, moebius, torus

from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

# shape -> (Euler characteristic, genus, boundary loops), from the topology of the shape itself
TOPOLOGY = {
    "grid": (grid(6, jitter=0.3), 1, 0, 1),
    "icosphere": (icosphere(2), 2, 0, 0),
    "blob": (blob(2), 2, 0, 0),
    "cylinder": (cylinder(12, 5), 0, 0, 2),
    "cone": (cone(12, 5), 1, 0, 1),
    "torus": (torus(16, 8), 0, 1, 0),
    "moebius": (moebius(20, 3), 0, None, 1),
}


@pytest.fixture(params=TOPOLOGY, scope="module")
def named(request):
    return request.param, Surface(*TOPOLOGY[request.param][0])


@pytest.fixture(scope="module")
def surface(named):
    return named[1]


def two_spheres():
    v, f = icosphere(1)
    w, g = icosphere(2)
    return Surface(np.vstack([v, w + 5]), np.vstack([f, g + len(v)]))


# -- topology -----------------------------------------------------------------------------------------


def test_topology_is_that_of_the_shape(named):
    name, surface = named
    _, euler, genus, loops = TOPOLOGY[name]
    assert surface.euler_characteristic == euler
    assert surface.genus == genus
    assert len(surface.boundary_loops) == loops
    assert surface.is_closed == (loops == 0)
    assert surface.is_oriented == (name != "moebius")
    assert surface.is_manifold
    assert surface.components[0] == 1


def test_edges_are_those_of_libigl(surface):
    expected = np.sort(igl.edges(surface.faces.astype(np.int64)), axis=1)
    np.testing.assert_array_equal(surface.edges, expected[np.lexsort(expected.T[::-1])])


def test_face_edges_join_the_corners_that_they_should(surface):
    for k in range(3):
        ends = np.sort(surface.faces[:, [k, (k + 1) % 3]], axis=1)
        np.testing.assert_array_equal(surface.edges[surface.face_edges[:, k]], ends)


def test_twins_are_an_involution_over_shared_edges(surface):
    twins = surface.twins.ravel()
    inside = np.flatnonzero(twins >= 0)
    np.testing.assert_array_equal(twins[twins[inside]], inside)
    np.testing.assert_array_equal(surface.face_edges.ravel()[inside], surface.face_edges.ravel()[twins[inside]])
    assert (inside // 3 != twins[inside] // 3).all()
    assert inside.size + surface.boundary_edges.size == 3 * surface.n_faces


def test_boundary_loops_run_along_boundary_edges_once(surface):
    walked = [
        tuple(sorted((int(a), int(b))))
        for loop in surface.boundary_loops
        for a, b in zip(loop, np.roll(loop, -1), strict=True)
    ]
    assert sorted(walked) == sorted(map(tuple, surface.edges[surface.boundary_edges].tolist()))
    np.testing.assert_array_equal(np.sort(np.concatenate([[], *surface.boundary_loops])), surface.boundary_vertices)


def test_longest_boundary_comes_first():
    v, f = cylinder(12, 6)
    longer = np.flatnonzero((v[f][:, :, 2] > 0.1).all(axis=1) | (f.max(axis=1) % 12 < 6))
    surface = Surface(v, f[longer])
    lengths = [len(loop) for loop in surface.boundary_loops]
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] > lengths[-1]


def test_manifoldness_agrees_with_libigl():
    for v, f in (icosphere(1), moebius(), grid(3), bow_tie(), fan()):
        surface = Surface(v, f)
        assert (surface.nonmanifold_edges.size == 0) == bool(igl.is_edge_manifold(f.astype(np.int64))[0])
        if surface.nonmanifold_edges.size == 0:
            fine = np.asarray(igl.is_vertex_manifold(f.astype(np.int64))).ravel()
            np.testing.assert_array_equal(surface.nonmanifold_vertices, np.flatnonzero(~fine))


def test_offending_edge_and_vertex_are_found():
    surface = Surface(*fan())
    np.testing.assert_array_equal(surface.edges[surface.nonmanifold_edges], [[0, 1]])
    np.testing.assert_array_equal(Surface(*bow_tie()).nonmanifold_vertices, [0])
    assert not surface.is_manifold
    assert surface.genus is None


def test_components_and_unreferenced_vertices():
    v, f = icosphere(1)
    surface = Surface(np.vstack([v, [[9, 9, 9]], v + 5, [[8, 8, 8]]]), np.vstack([f, f + len(v) + 1]))
    count, labels = surface.components
    assert count == 4
    np.testing.assert_array_equal(surface.unreferenced_vertices, [len(v), 2 * len(v) + 1])
    assert len(np.unique(labels[: len(v)])) == 1
    assert labels[0] != labels[len(v) + 1]
    assert surface.euler_characteristic == 4
    assert surface.genus == 0


def test_flipping_a_face_is_noticed():
    v, f = icosphere(1)
    f = f.copy()
    f[7] = f[7, ::-1]
    surface = Surface(v, f)
    assert not surface.is_oriented
    assert surface.is_manifold
    assert surface.genus is None


# -- metric -------------------------------------------------------------------------------------------


def test_areas_and_lengths_agree_with_libigl(surface):
    v, f = surface.vertices, surface.faces.astype(np.int64)
    np.testing.assert_allclose(surface.face_areas, igl.doublearea(v, f).ravel() / 2, rtol=1e-12)
    lengths = surface.edge_lengths[surface.face_edges]
    np.testing.assert_allclose(lengths[:, [1, 2, 0]], igl.edge_lengths(v, f), rtol=1e-12)
    assert surface.area == pytest.approx(surface.face_areas.sum(), rel=1e-14)
    assert surface.vertex_areas.sum() == pytest.approx(surface.area, rel=1e-12)
    mass = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_BARYCENTRIC)
    np.testing.assert_allclose(surface.vertex_areas, mass.diagonal(), rtol=1e-12)


def test_angles_of_a_triangle_sum_to_pi(surface):
    np.testing.assert_allclose(surface.corner_angles.sum(axis=1), np.pi, rtol=1e-13)
    expected = igl.internal_angles(surface.vertices, surface.faces.astype(np.int64))
    np.testing.assert_allclose(surface.corner_angles, expected, rtol=1e-7)  # libigl's law of cosines


def test_gauss_bonnet(surface):
    """Angle defects inside and turning angles on the boundary sum to 2 pi chi, to rounding."""
    total = np.bincount(surface.faces.ravel(), surface.corner_angles.ravel(), minlength=surface.n_vertices)
    full = np.full(surface.n_vertices, 2 * np.pi)
    full[surface.boundary_vertices] = np.pi
    assert (full - total).sum() == pytest.approx(2 * np.pi * surface.euler_characteristic, abs=1e-10)


@pytest.mark.parametrize("eps", [1e-3, 1e-7, 1e-12])
def test_angles_of_needles_keep_their_digits(eps):
    surface = Surface([[0, 0, 0], [1, 0, 0], [0.5, eps, 0]], [[0, 1, 2]])
    base = np.arctan2(eps, 0.5)
    np.testing.assert_allclose(surface.corner_angles, [[base, base, np.pi - 2 * base]], rtol=1e-13)


def test_normals_of_a_sphere_point_along_the_radius():
    errors = []
    for level in (2, 3, 4):
        surface = Surface(*icosphere(level, radius=2.5))
        np.testing.assert_allclose(np.linalg.norm(surface.face_normals, axis=1), 1, rtol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(surface.vertex_normals, axis=1), 1, rtol=1e-12)
        errors.append(np.abs(surface.vertex_normals - surface.vertices / 2.5).max())
    rate = np.polyfit(np.log(0.5 ** np.arange(3)), np.log(errors), 1)[0]
    assert errors[-1] < 0.01
    assert rate > 0.9  # first order in the edge length: the rings are not symmetric


@pytest.mark.parametrize("name", [name for name in TOPOLOGY if name != "moebius"])  # its normals have no side
def test_vertex_normals_are_those_of_libigl(name):
    surface = Surface(*TOPOLOGY[name][0])
    kind = igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE
    expected = igl.per_vertex_normals(surface.vertices, surface.faces.astype(np.int64), kind)
    np.testing.assert_allclose(surface.vertex_normals, expected, atol=1e-7)


def test_area_of_a_sphere_converges():
    area = [Surface(*icosphere(level)).area for level in (3, 4)]
    assert 4 * np.pi - area[1] < 0.26 * (4 * np.pi - area[0])  # second order: a quarter of the error


def test_normals_are_zero_without_area_or_faces():
    surface = Surface([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], [[0, 1, 2]])
    assert not surface.face_normals.any()
    assert not surface.vertex_normals.any()
    assert surface.area == 0


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_quantities_scale(scale):
    v, f = blob(2)
    one, scaled = Surface(v, f), Surface(scale * v, f)
    assert scaled.area == pytest.approx(scale**2 * one.area, rel=1e-12)
    np.testing.assert_allclose(scaled.corner_angles, one.corner_angles, rtol=1e-9)
    np.testing.assert_allclose(scaled.vertex_normals, one.vertex_normals, atol=1e-12)


# -- making others ------------------------------------------------------------------------------------


def test_submesh_and_largest_component_keep_attributes():
    surface = two_spheres().with_attributes({"index": np.arange(42 + 162)})
    part, origin = surface.largest_component()
    assert (part.n_vertices, part.n_faces) == (162, 320)
    np.testing.assert_array_equal(part.vertices, surface.vertices[origin])
    np.testing.assert_array_equal(part.attributes["index"], origin)
    assert part.components[0] == 1


def test_largest_component_goes_by_area_not_by_count():
    v, f = icosphere(1)
    w, g = icosphere(2, radius=0.1)
    part, _ = Surface(np.vstack([w, v + 5]), np.vstack([g, f + len(w)])).largest_component()
    assert part.n_vertices == len(v)


def test_attributes_are_added_without_touching_the_surface():
    surface = Surface(*icosphere(1), {"a": np.zeros(42)})
    areas = surface.face_areas
    other = surface.with_attributes({"b": np.ones((42, 3)), "a": np.ones(42)})
    assert set(surface.attributes) == {"a"}
    assert not surface.attributes["a"].any()
    assert set(other.attributes) == {"a", "b"}
    assert other.attributes["a"].all()
    assert other.face_areas is areas


def test_pose_shares_faces_and_attributes():
    surface = Surface(*icosphere(1), {"a": np.arange(42)})
    pose = surface.with_vertices(2 * surface.vertices)
    assert pose.area == pytest.approx(4 * surface.area)
    np.testing.assert_array_equal(pose.faces, surface.faces)
    np.testing.assert_array_equal(pose.attributes["a"], surface.attributes["a"])
    with pytest.raises(MeshError, match=r"shape \(3, 3\), expected \(42, 3\)"):
        surface.with_vertices(np.eye(3))


def test_survives_pickling():
    surface = Surface(*icosphere(1), {"a": np.arange(42)})
    copy = pickle.loads(pickle.dumps(surface))
    np.testing.assert_array_equal(copy.vertices, surface.vertices)
    np.testing.assert_array_equal(copy.faces, surface.faces)
    np.testing.assert_array_equal(copy.attributes["a"], surface.attributes["a"])
    assert not copy.vertices.flags.writeable


def test_repr_names_sizes_and_attributes():
    assert repr(Surface(*icosphere(1), {"b": np.zeros(42)})) == "Surface(42 vertices, 80 faces, attributes=['b'])"
