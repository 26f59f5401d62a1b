"""One connectivity for all shapes: places on the surface, Procrustes, the shape model, landmarks."""

from __future__ import annotations

import csv
import warnings

import numpy as np
import pytest
from collection_family import family, true_maps
from in_pieces import in_pieces
from scipy.spatial.transform import Rotation
from shapes import arched, creature, grid, icosphere

import qgeo_filters as qg
from qgeo_filters.closest_points import closest_points
from qgeo_filters.collection.common import CommonShapes, common_shapes
from qgeo_filters.collection.landmarks import landmarks_on_all, landmarks_on_common, write_landmark_table
from qgeo_filters.collection.shape_model import shape_model
from qgeo_filters.collection.unfolding import put_onto
from qgeo_filters.surface import Surface

FAMILY = family()
AXES = np.array([1.0, 1.4, 0.8])


def ellipsoids() -> tuple[Surface, Surface, np.ndarray]:
    """A coarse ellipsoid, a fine one, turned, moved and three times as large, and where the coarse vertices are."""
    turn = Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix()
    coarse, fine = (icosphere(level)[0] * AXES for level in (2, 3))
    template = Surface(coarse, icosphere(2)[1], {"part": np.arange(len(coarse))})
    there = 3.0 * coarse @ turn.T + [5.0, 0.0, -2.0]
    return template, Surface(3.0 * fine @ turn.T + [5.0, 0.0, -2.0], icosphere(3)[1]), there


def test_the_template_lies_on_the_shape_where_the_map_says():
    template, shape, there = ellipsoids()
    same = qg.remesh_like(template, shape, closest_points(there, shape))
    assert np.array_equal(same.faces, template.faces)
    assert np.array_equal(same.attributes["part"], template.attributes["part"])
    gaps = np.linalg.norm(closest_points(same.vertices, shape).pulled_back(shape.vertices) - same.vertices, axis=1)
    assert gaps.max() < 1e-9
    assert np.linalg.norm(same.vertices - there, axis=1).max() < 0.02 * np.sqrt(shape.area)
    assert same.winding == template.winding


@pytest.mark.parametrize("inward", [False, True])
def test_a_map_with_folds_leaves_none(inward):
    template, shape, there = ellipsoids()
    rng = np.random.default_rng(0)
    noisy = there + 0.035 * np.sqrt(shape.area) * rng.normal(size=there.shape)
    place = closest_points(noisy, shape)
    raw = template.with_vertices(place.pulled_back(shape.vertices))
    outwards = raw.vertices - shape.vertices.mean(axis=0)
    folded = np.einsum("ij,ij->i", raw.face_normals, outwards[raw.faces].sum(axis=1)) < 0
    assert folded.sum() > 5  # the map folds
    given = shape
    if inward:
        given = shape.turned_over()
        place = closest_points(noisy, given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        same = qg.remesh_like(template, given, place)
    outwards = same.vertices - shape.vertices.mean(axis=0)
    assert (np.einsum("ij,ij->i", same.face_normals, outwards[same.faces].sum(axis=1)) > 0).all()


def test_folds_that_cannot_be_undone_are_told():
    """All vertices of a patch on one point: nothing is left to even out within it."""
    plane = Surface(*grid(6))
    starts = np.arange(plane.n_vertices)
    flipped = plane.vertices.copy()
    flipped[[24, 25]] = flipped[[25, 24]]
    assert put_onto(plane.with_vertices(flipped), plane, starts)[1].size == 0
    line = plane.vertices * [1.0, -1.0, 1.0] + [0.0, 1.0, 0.0]  # turned over as a whole
    vertices, turned = put_onto(plane.with_vertices(line), plane, starts[::-1].copy())
    assert np.isfinite(vertices).all()
    assert turned.size in (0, plane.n_faces)  # one side or the other


def test_vertices_without_a_partner_stay_near_their_neighbours():
    template, shape, there = ellipsoids()
    vertices = np.array(closest_points(there, shape).nearest_corner)
    lost = template.vertices[:, 1] > 1.1
    vertices[lost] = -1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        same = qg.remesh_like(template, shape, vertices)
    assert np.linalg.norm(same.vertices - there, axis=1)[lost].max() < 0.12 * np.sqrt(shape.area)


@pytest.mark.slow
def test_what_is_refused_is_put_onto_the_wrap_of_the_shape():
    """As the refusal advises; a sheet inside comes along, and how the pieces are turned does not matter."""
    vertices, faces = creature(level=3)
    template = Surface(*in_pieces((vertices, faces)))
    shape = Surface(*in_pieces((arched(vertices, 0.3), faces), seed=1))
    with pytest.raises(qg.MeshError, match="repair='wrap' for a closed surface around all of it"):
        qg.remesh_like(template, shape)
    found = qg.match(shape, template, repair="wrap")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no triangle is turned over
        same = qg.remesh_like(template, shape, found)
    np.testing.assert_array_equal(same.faces, template.faces)
    unit = np.sqrt(Surface(vertices, faces).area)
    gaps = np.linalg.norm(same.vertices - arched(template.vertices, 0.3), axis=1) / unit
    assert gaps.mean() < 0.02
    assert gaps[-4:].max() < 0.1
    assert found.around_x is not None
    outside = found.around_x.surface
    on_wrap = closest_points(same.vertices, outside).pulled_back(outside.vertices)
    np.testing.assert_allclose(same.vertices[:-4], on_wrap[:-4], atol=1e-9)
    np.testing.assert_array_equal(qg.remesh_like(template, shape, repair="wrap").vertices, same.vertices)
    # Along a map that is no match the wraps have to be said, or what lies inside counts.
    both = {"template": template, "shape": shape}
    wraps = {"template": found.around_y, "shape": found.around_x}
    along = {"shape": found.inverse_barycentric}
    np.testing.assert_array_equal(common_shapes(template, both, along, wraps=wraps)["shape"].vertices, same.vertices)
    with pytest.warns(UserWarning, match="shape: .* triangles are turned over"):
        common_shapes(template, both, along)


def test_shapes_of_one_family_have_one_connectivity():
    shapes = {name: FAMILY[name] for name in "abc"}
    common = common_shapes(shapes["a"], shapes, {name: np.arange(shapes["a"].n_vertices) for name in "bc"})
    assert common.names == ("a", "b", "c")
    assert np.array_equal(common.positions[0], shapes["a"].vertices)
    for name in "bc":
        gaps = np.linalg.norm(common[name].vertices - shapes[name].vertices, axis=1)
        assert gaps.mean() < 0.01 * np.sqrt(shapes[name].area)


def test_a_shape_without_a_map_is_named():
    with pytest.raises(qg.ParameterError, match="no map from the template to b"):
        common_shapes(FAMILY["a"], FAMILY, {"c": np.arange(3)})
    with pytest.raises(qg.ParameterError, match=r"^b: correspondence must hold"):
        common_shapes(FAMILY["a"], {"b": FAMILY["b"]}, {"b": np.arange(3)})


def rigidly_moved(scales: bool) -> tuple[Surface, CommonShapes]:
    base = FAMILY["b"]
    turns = Rotation.random(5, random_state=1).as_matrix()
    moves, sizes = np.random.default_rng(2).normal(size=(2, 5, 3))
    sizes = 1 + 0.2 * np.abs(sizes[:, 0]) if scales else np.ones(5)
    positions = [s * base.vertices @ t.T + m for s, t, m in zip(sizes, turns, moves, strict=True)]
    return base, CommonShapes(tuple("vwxyz"), base, np.array(positions))


@pytest.mark.parametrize("scale", [False, True])
def test_procrustes_undoes_what_is_rigid(scale):
    base, common = rigidly_moved(scale)
    aligned = common.aligned(scale=scale)
    assert np.ptp(aligned.positions, axis=0).max() < 1e-9
    assert np.abs(base.vertex_areas @ aligned.mean.vertices).max() < 1e-9
    first = common.positions[0] - common.positions[0].mean(axis=0)
    turn, _ = Rotation.align_vectors(first, aligned.positions[0] - aligned.positions[0].mean(axis=0))
    assert turn.magnitude() < 1e-6  # in the frame of the first


def test_procrustes_keeps_size_and_hand():
    base = FAMILY["b"]
    mirror = base.vertices * [-1.0, 1.0, 1.0]
    three = np.array([base.vertices, 2 * base.vertices, mirror])
    aligned = CommonShapes(("one", "large", "mirror"), base, three).aligned()
    spread = np.linalg.norm(aligned.positions - aligned.positions.mean(axis=1, keepdims=True), axis=(1, 2))
    assert spread[1] == pytest.approx(2 * spread[0])
    assert np.ptp(aligned.positions[[0, 2]], axis=0).max() > 0.05  # a mirror image is not turned into its original


def test_the_modes_are_those_that_shapes_were_made_of():
    base = FAMILY["a"]
    rng = np.random.default_rng(0)
    modes, _ = np.linalg.qr(rng.normal(size=(3 * base.n_vertices, 2)))
    amounts = np.array([[-3.0, 1.0], [3.0, 1.0], [-3.0, -1.0], [3.0, -1.0]])
    shapes = CommonShapes(tuple("wxyz"), base, base.vertices + (amounts @ modes.T).reshape(4, -1, 3))
    model = shape_model(shapes, 2)
    assert model.variance == pytest.approx([12.0, 4 / 3])
    assert model.explained == pytest.approx([0.9, 0.1])
    assert np.abs(model.modes.reshape(2, -1) @ modes) == pytest.approx(np.eye(2), abs=1e-9)
    assert np.abs(model.mean.vertices - base.vertices).max() < 1e-12
    for name, scores in zip(shapes.names, model.scores, strict=True):
        assert np.abs(model.shape(scores).vertices - shapes[name].vertices).max() < 1e-9
    ends = np.stack([model.mode(0, sign * 3 / np.sqrt(12)).vertices for sign in (1, -1)])
    assert ends.mean(axis=0) == pytest.approx(base.vertices)
    assert np.linalg.norm(ends[0] - base.vertices) == pytest.approx(3.0)


def test_what_cannot_be_is_refused():
    base = FAMILY["a"]
    one = CommonShapes(("a",), base, base.vertices[None])
    with pytest.raises(qg.ParameterError, match="at least two"):
        shape_model(one)
    with pytest.raises(qg.ParameterError, match="modes must be between 1 and 4"):
        shape_model(rigidly_moved(False)[1], 5)
    with pytest.raises(qg.ParameterError, match="mode 4 is not there"):
        shape_model(rigidly_moved(False)[1]).mode(4, 1.0)
    with pytest.raises(qg.ParameterError, match=r"positions have shape \(2, "):
        CommonShapes(("a",), base, np.zeros((2, base.n_vertices, 3)))
    with pytest.raises(qg.ParameterError, match="a has positions that are not finite"):
        CommonShapes(("a",), base, np.full((1, base.n_vertices, 3), np.nan))


def test_meshes_are_written_and_read(tmp_path):
    _, common = rigidly_moved(False)
    files = common.write(tmp_path / "out")
    assert [file.name for file in files] == ["v.ply", "w.ply", "x.ply", "y.ply", "z.ply"]
    assert np.abs(Surface.read(files[3]).vertices - common.positions[3]).max() < 1e-6
    assert sorted((tmp_path / "out").iterdir()) == files
    with pytest.raises(qg.ParameterError, match="cannot be the name of a file"):
        CommonShapes(("../v",), common.template, common.positions[:1]).write(tmp_path)


def test_landmarks_are_carried_to_all_and_into_a_table(tmp_path):
    maps = true_maps(FAMILY)
    points = FAMILY["a"].vertices[FAMILY["a"].faces[[5, 40]]].mean(axis=1)
    found = landmarks_on_all(qg.Landmarks(["nose", "tail"], points), "a", FAMILY, maps)
    for name, shape in FAMILY.items():
        assert np.abs(found[name].points - shape.vertices[shape.faces[[5, 40]]].mean(axis=1)).max() < 1e-9
    write_landmark_table(tmp_path / "table.csv", found)
    with (tmp_path / "table.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["shape", "landmark", "x", "y", "z"]
    assert [row[:2] for row in rows[1:3]] == [["a", "nose"], ["a", "tail"]]
    assert len(rows) == 1 + 2 * len(FAMILY)
    assert [float(cell) for cell in rows[-1][2:]] == found["f"].points[1].tolist()


def test_landmarks_without_an_image_are_empty_cells(tmp_path):
    shapes = {name: FAMILY[name] for name in "ab"}
    images = np.arange(shapes["a"].n_vertices)
    images[7] = -1
    found = landmarks_on_all([7, 20], "a", shapes, {("a", "b"): images})
    write_landmark_table(tmp_path / "table.csv", found)
    assert (tmp_path / "table.csv").read_text().splitlines()[3] == "b,1,,,"
    with pytest.raises(qg.ParameterError, match="no map from b to a"):
        landmarks_on_all([7], "b", shapes, {("a", "b"): images})


def test_landmarks_on_common_shapes_stay_in_their_triangles():
    base, common = rigidly_moved(False)
    found = landmarks_on_common(base.vertices[base.faces[[3]]].mean(axis=1), common)
    for name in common.names:
        assert found[name].points[0] == pytest.approx(common[name].vertices[base.faces[3]].mean(axis=0))
