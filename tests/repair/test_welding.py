"""Boundary edges that lie on each other: what repair joins, what it leaves apart, and who is told."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pygeodesic.geodesic as pygeodesic
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, cylinder, grid, icosphere, torus

import qgeo_filters as qg
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.repair.welding import welded
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

CLOSED = {"sphere": icosphere(2), "torus": torus(24, 12), "blob": blob(2)}


def soup(vertices, faces):
    """Every face with three vertices of its own."""
    return vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def cut_in_two(vertices, faces, axis=0):
    """The vertices between faces on the one side and on the other exist twice."""
    side = vertices[faces].mean(axis=1)[:, axis] > vertices[:, axis].mean()
    shared = np.intersect1d(faces[side], faces[~side])
    twin = np.arange(len(vertices))
    twin[shared] = len(vertices) + np.arange(len(shared))
    return np.vstack([vertices, vertices[shared]]), np.where(side[:, None], twin[faces], faces), shared


def with_seam(n_around=24, n_tube=12):
    """A torus with the vertices of its first tube twice, as texture coordinates leave it: one piece, like a pipe."""
    vertices, faces = torus(n_around, n_tube)
    last = (faces >= (n_around - 1) * n_tube).any(axis=1)
    cut = np.where(last[:, None] & (faces < n_tube), faces + len(vertices), faces)
    return np.vstack([vertices, vertices[:n_tube]]), cut, np.arange(n_tube)


def rounded_apart(vertices, faces, steps, seed=0):
    """A soup in single precision whose corners are rounded each for itself."""
    corners, own = soup(vertices, faces)
    corners = corners.astype(np.float32)
    turns = np.random.default_rng(seed).integers(0, steps + 1, corners.shape)
    for step in range(1, steps + 1):
        corners[turns >= step] = np.nextafter(corners[turns >= step], np.float32(np.inf))
    return corners.astype(np.float64), own


def as_positions(repaired):
    """Triangles as sets of corners, to be compared whatever the numbering."""
    corners = np.round(repaired.vertices[repaired.faces], 9) + 0.0
    return {frozenset(map(tuple, face)) for face in corners.tolist()}


@pytest.mark.parametrize("name", CLOSED)
def test_a_soup_of_triangles_is_the_surface_again(name):
    vertices, faces = CLOSED[name]
    surface = Surface(vertices, faces)
    repaired = repair_surface(soup(vertices, faces))
    assert repaired.surface.n_vertices == surface.n_vertices
    assert as_positions(repaired.surface) == as_positions(surface)
    assert repaired.surface.is_closed
    assert repaired.surface.genus == surface.genus
    assert repaired.surface.winding == surface.winding
    n_joined = 3 * len(faces) - len(vertices)
    assert repaired.report == (f"{n_joined} boundary vertices joined with others at the same place",)
    # Every original vertex stands for the one at its place.
    back = repaired.map_back(repaired.surface.vertices)
    np.testing.assert_array_equal(back, soup(vertices, faces)[0])


def test_distances_across_a_seam_are_those_of_the_whole_surface():
    vertices, faces = torus(24, 12)
    cut_vertices, cut_faces, shared = with_seam()
    source = int(shared[3]) + 24 * 3
    truth = pygeodesic.PyGeodesicAlgorithmExact(vertices, faces).geodesicDistances(np.array([source]), None)[0]
    apart = Surface(cut_vertices, cut_faces)
    assert (apart.components[0], len(apart.boundary_loops)) == (1, 2)
    assert qg.distances(apart, [source], method="exact")[0].max() > 1.3 * truth.max()
    assert apart.unwelded_vertices.size == len(shared)
    repaired = repair_surface(apart)
    assert repaired.surface.is_closed
    found = qg.distances(repaired.surface, [repaired.vertex_of_original[source]], method="exact")[0]
    np.testing.assert_allclose(repaired.map_back(found)[: len(vertices)], truth, rtol=1e-9, atol=1e-9)
    # Both sides of the seam have one value.
    np.testing.assert_array_equal(repaired.map_back(found)[len(vertices) :], repaired.map_back(found)[shared])


def test_a_joined_vertex_keeps_the_attributes_of_the_first_and_both_find_it():
    vertices, faces, shared = cut_in_two(*icosphere(2))
    n = 162
    repaired = repair_surface(Surface(vertices, faces, {"index": np.arange(len(vertices))}))
    np.testing.assert_array_equal(repaired.surface.attributes["index"], repaired.origin)
    np.testing.assert_array_equal(repaired.origin, np.arange(n))
    np.testing.assert_array_equal(repaired.vertex_of_original[n:], repaired.vertex_of_original[shared])


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("offset", [0.0, 40.0], ids=["about the origin", "far from it"])
def test_corners_that_differ_by_rounding_are_one(steps, offset):
    vertices, faces = torus(24, 12)
    corners, own = rounded_apart(vertices + offset, faces, steps)
    assert len(np.unique(corners, axis=0)) > 1.5 * len(vertices)
    repaired = repair_surface((corners, own))
    assert (repaired.surface.n_vertices, repaired.surface.n_faces) == (len(vertices), len(faces))
    assert repaired.surface.is_closed
    assert repaired.surface.genus == 1
    (sentence,) = repaired.report
    distance = float(sentence.rpartition(" up to ")[2].removesuffix(" apart"))
    moved = np.linalg.norm(repaired.map_back(repaired.surface.vertices) - corners, axis=1).max()
    assert distance == pytest.approx(moved, rel=1e-2)
    assert 0 < distance < 3 * steps * np.spacing(np.float32(offset + 2))


def test_corners_that_differ_in_the_last_digit_of_a_text_are_one():
    vertices, faces = torus(24, 12)
    corners, own = soup(vertices, faces)
    exact = corners + np.random.default_rng(0).normal(scale=2e-6, size=corners.shape)
    digits = np.array([[float(f"{value:.6g}") for value in corner] for corner in exact.tolist()])
    repaired = repair_surface((digits, own))
    assert (repaired.surface.n_vertices, repaired.surface.n_faces) == (len(vertices), len(faces))
    assert repaired.surface.is_closed


def test_a_filter_works_on_an_unwelded_mesh_and_brings_its_values_back():
    vertices, faces = blob(2)
    filter = qg.DifferentialCoordinates()
    whole = filter((vertices, faces)).attributes["qgeo_delta"]
    split = filter(soup(vertices, faces), repair=True).attributes["qgeo_delta"]
    np.testing.assert_allclose(split, whole[faces.ravel()], rtol=1e-9)


@pytest.mark.parametrize("host", ["open3d", "pyvista", "trimesh"])
def test_meshes_of_hosts_that_split_vertices_are_whole(host):
    module = pytest.importorskip(host)
    vertices, faces = soup(*icosphere(1))
    if host == "open3d":
        mesh = module.geometry.TriangleMesh(
            module.utility.Vector3dVector(vertices), module.utility.Vector3iVector(faces)
        )
    elif host == "pyvista":
        mesh = module.PolyData.from_regular_faces(vertices, faces)
    else:
        mesh = module.Trimesh(vertices, faces, process=False)
    surface = qg.as_surface(mesh, repair=True)
    assert (surface.n_vertices, surface.n_faces, surface.is_closed) == (42, 80, True)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".stl"])
def test_files_of_loose_triangles_are_whole(tmp_path: Path, suffix):
    file = tmp_path / f"soup{suffix}"
    Surface(*soup(*icosphere(1))).write(file)
    surface = Surface.read(file, repair=True)
    assert (surface.n_vertices, surface.n_faces, surface.is_closed) == (42, 80, True)


# -- what stays apart ---------------------------------------------------------------------------------


def test_closed_shapes_that_touch_are_not_joined():
    """A cube on a cube: their corners and edges coincide, but no edge is a boundary."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    cube = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    pile = Surface(np.vstack([corners, np.add(corners, [0, 0, 1])]), np.vstack([cube, cube + 8]))
    assert pile.unwelded_vertices.size == 0
    with pytest.raises(qg.MeshError, match=r"would remove 50 % of the area .*2 pieces, of 12, 12 faces"):
        repair_surface(pile)


def test_sheets_that_touch_in_a_point_are_not_joined():
    vertices, faces = grid(3)
    n = len(vertices)
    joined, _ = welded(
        np.vstack([vertices, np.add(vertices, [1, 1, 0])]), np.vstack([faces, faces + n]).astype(np.int32)
    )
    np.testing.assert_array_equal(joined, np.arange(2 * n))


def test_sheets_side_by_side_are_joined():
    vertices, faces = grid(3)
    side_by_side = np.vstack([vertices, np.add(vertices, [1, 0, 0])]), np.vstack([faces, faces + len(vertices)])
    repaired = repair_surface(side_by_side)
    assert repaired.report == ("4 boundary vertices joined with others at the same place",)
    assert len(repaired.surface.boundary_loops) == 1
    assert repaired.surface.area == pytest.approx(2)


def test_a_sheet_that_is_folded_flat_keeps_its_rim():
    vertices, faces = grid(4)
    folded = vertices.copy()
    folded[:, 0] = np.minimum(vertices[:, 0], 1 - vertices[:, 0])
    surface = Surface(folded, faces)
    assert surface.unwelded_vertices.size == 0
    assert repair_surface(surface).surface is surface


def test_details_much_finer_than_the_extent_stay_as_they_are():
    """A tube far narrower than rounding to the size of the whole mesh would leave it."""
    vertices, faces = cylinder(12, 6, radius=1e-8, height=6e-8)
    plate, plate_faces = grid(4)
    both = Surface(np.vstack([1 / 3 + plate, vertices]), np.vstack([plate_faces, faces + len(plate)]))
    assert both.unwelded_vertices.size == 0


def test_a_copy_of_an_object_goes_and_its_vertices_stand_for_the_other():
    vertices, faces = cylinder(12, 4)
    turned = faces[np.random.default_rng(0).permutation(len(faces))][:, ::-1]
    n = len(vertices)
    twice = np.vstack([vertices, vertices[::-1]]), np.vstack([faces, n + (n - 1 - turned)])
    repaired = repair_surface(twice)
    assert repaired.report == (f"1 piece removed that lay on others face by face, with {len(faces)} faces",)
    np.testing.assert_array_equal(repaired.vertex_of_original, [*range(n), *range(n)[::-1]])
    np.testing.assert_array_equal(repaired.surface.faces, faces)


def test_a_soup_with_backs_is_one_surface():
    vertices, faces = icosphere(1)
    repaired = repair_surface(soup(vertices, np.vstack([faces, faces[:, ::-1]])))
    assert (repaired.surface.n_vertices, repaired.surface.n_faces, repaired.surface.is_closed) == (42, 80, True)


# -- any soup of triangles ----------------------------------------------------------------------------


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.0, 1.0), scale=st.sampled_from([1e-9, 1.0, 1e9]))
def test_cut_anywhere_it_becomes_the_same_surface(seed, share, scale):
    """Any corners of a closed mesh get vertices of their own; faces, vertices and input come in any order."""
    random = np.random.default_rng(seed)
    vertices, faces = icosphere(1)
    vertices, faces = scale * vertices, random.permutation(faces)
    own = random.random(faces.shape) < share
    cut = faces.copy()
    cut[own] = len(vertices) + np.arange(own.sum())
    used, cut = np.unique(cut, return_inverse=True)
    order = random.permutation(len(used))
    points = np.vstack([vertices, vertices[faces[own]]])[used]
    given_vertices, given_faces = np.empty_like(points), order[cut.reshape(-1, 3)]
    given_vertices[order] = points
    repaired = repair_surface((frozen(given_vertices), frozen(given_faces)))
    assert (repaired.surface.n_vertices, repaired.surface.n_faces) == (42, 80)
    assert repaired.surface.is_closed
    np.testing.assert_array_equal(repaired.map_back(repaired.surface.vertices), given_vertices)


# -- what is said without a repair --------------------------------------------------------------------


def test_without_repair_the_error_says_that_the_mesh_is_not_welded():
    loose = Surface(*soup(*icosphere(1)))
    with pytest.raises(qg.DisconnectedError, match=r"198 boundary vertices coincide with others: .*repair=True joins"):
        loose.require_connected("X")


def test_distances_that_are_infinite_for_want_of_welding_say_so():
    loose, apart = Surface(*soup(*icosphere(1))), Surface(*with_seam()[:2])
    with pytest.warns(UserWarning, match=r"between the 80 pieces of the mesh are inf, but 198 boundary .*repair=True"):
        assert np.isinf(qg.distances(loose, [0])).any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        qg.distances(apart, [0])  # a seam, but one piece
        qg.distances(loose.largest_component()[0], [0])


def test_a_shred_is_never_kept_in_silence():
    """What does not lie on each other cannot be joined: nearly all of it would go."""
    vertices, faces = soup(*icosphere(1))
    apart = vertices + 0.01 * np.repeat(vertices.reshape(-1, 3, 3).mean(axis=1), 3, axis=0)
    with pytest.raises(qg.MeshError, match=r"would remove 98\.\d+ % of the area .*there are 80 pieces, of 1, 1, 1"):
        repair_surface((apart, faces))
    assert repair_surface((apart, faces), force=True).surface.n_faces == 1
    assert qg.as_surface((apart, faces), repair="force").n_faces == 1
    with pytest.raises(qg.ParameterError, match="repair must be 'auto', True, False, 'force' or 'wrap', got 'yes'"):
        qg.as_surface((apart, faces), repair="yes")


def test_most_faces_without_a_place_are_not_dropped_in_silence():
    vertices, faces = icosphere(1)
    faces = faces[np.argsort(vertices[faces].mean(axis=1)[:, 2])]
    faces[35:] += 1000  # the others are a cap
    with pytest.raises(qg.MeshError, match=r"would remove 56\.2 % of the faces \(45 faces with missing vertices"):
        repair_surface((vertices, faces))
