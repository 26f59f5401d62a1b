"""Which side of a surface is out: closed and open, in pieces, with cavities; what repair and matching make of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, creature, crooked, cylinder, grid, icosphere, moebius, torus

import qgeo_filters as qg
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.repair.winding import is_inside_out, relative_volume
from qgeo_filters.surface import Surface

BALL = icosphere(2)
SHAPES = {
    "sphere": BALL,
    "torus": torus(24, 12),
    "blob": blob(2),
    "creature": creature(),
    "crooked": crooked(1),
}


def turned_over(vertices, faces):
    """Every face from the other side."""
    return vertices, faces[:, ::-1]


def part(mesh, keep):
    """The faces whose middle passes."""
    vertices, faces = mesh
    used, faces = np.unique(faces[keep(*vertices[faces].mean(axis=1).T)], return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def together(*meshes):
    """Several meshes in one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    return (
        np.vstack([vertices for vertices, _ in meshes]),
        np.vstack([faces + start for (_, faces), start in zip(meshes, starts[:-1], strict=True)]),
    )


def moved(mesh, by=(0.0, 0.0, 0.0), scale=1.0):
    """A mesh elsewhere, in another size."""
    return scale * mesh[0] + np.array(by), mesh[1]


def half_turned(mesh):
    """Faces in front looking the other way."""
    vertices, faces = mesh
    front = vertices[faces].mean(axis=1)[:, 1] > 0
    return vertices, np.where(front[:, None], faces[:, ::-1], faces)


TOLD = {
    "sphere": BALL,
    "torus": torus(24, 12),
    "blob": blob(2),
    "creature": creature(),
    "sphere with a hole": part(BALL, lambda x, y, z: z < 0.7),
    "creature with holes": part(creature(), lambda x, y, z: (abs(x) < 1.1) & (y < 1.1)),
    "tube": cylinder(24, 24, radius=0.5, height=4.0),
    "half a sphere": part(BALL, lambda x, y, z: z > 0),
    "two spheres": together(BALL, moved(BALL, (3, 0, 0))),
    "sphere with a cavity": together(BALL, moved(turned_over(*BALL), (0.1, 0, 0), 0.5)),
    "open sphere with a cavity": together(
        part(BALL, lambda x, y, z: z < 0.8), moved(turned_over(*BALL), (0, 0, -0.2), 0.5)
    ),
    "far away": moved(BALL, (1e6, -1e6, 1e6)),
    "tiny": moved(BALL, scale=1e-30),
    "huge": moved(BALL, scale=1e30),
    "plate of no thickness to speak of": moved(BALL, scale=np.array([1, 1, 1e-6])),
}


@pytest.mark.parametrize("name", TOLD)
def test_the_side_that_is_out_is_told_and_turns_with_the_faces(name):
    mesh = TOLD[name]
    assert Surface(*mesh).winding == "outward"
    assert Surface(*turned_over(*mesh)).winding == "inward"
    assert Surface(*mesh).turned_over().winding == "inward"


@pytest.mark.parametrize(
    ("mesh", "side"),
    [
        (grid(6), "undetermined"),
        (part(BALL, lambda x, y, z: z > 0.8), "undetermined"),
        (part(cylinder(40, 20), lambda x, y, z: x > 0), "undetermined"),
        (moved(BALL, scale=np.array([1, 1, 0])), "undetermined"),  # a disc with a back
        (moebius(), "mixed"),
        (half_turned(BALL), "mixed"),
        (together(BALL, moved(turned_over(*BALL), (3, 0, 0))), "mixed"),
        (together(moved(turned_over(*BALL), (3, 0, 0), 0.2), BALL), "mixed"),
    ],
    ids=["sheet", "cap", "half a tube", "disc", "one-sided", "front", "two spheres", "large and small"],
)
def test_where_there_is_no_inside_or_no_agreement_none_is_made_up(mesh, side):
    assert Surface(*mesh).winding == side


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), hole=st.floats(0.4, 1.0), name=st.sampled_from(sorted(SHAPES)))
def test_numbering_place_size_and_holes_do_not_matter(seed, hole, name):
    random = np.random.default_rng(seed)
    vertices, faces = part(SHAPES[name], lambda x, y, z: z < np.quantile(z, 0.8 + 0.2 * hole))
    rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
    rotation *= np.linalg.det(rotation)
    order = random.permutation(len(vertices))
    placed = (10.0 ** random.uniform(-6, 6) * vertices @ rotation.T + random.normal(size=3))[order]
    surface = Surface(placed, np.roll(random.permutation(np.argsort(order)[faces]), 1, axis=1))
    assert surface.winding == "outward"
    assert Surface(placed * [-1, 1, 1], surface.faces).winding == "inward"


def test_the_volume_is_that_of_the_formula_wherever_the_surface_lies_and_with_holes():
    sphere = icosphere(4)
    assert relative_volume(*sphere) == pytest.approx(4 / 3 * np.pi / (4 * np.pi) ** 1.5, rel=2e-3)
    assert relative_volume(*moved(sphere, (70, -50, 90), 3.0)) == pytest.approx(relative_volume(*sphere), rel=1e-9)
    # A tube without lids: radius 1/2 and height 4 are an area of 4 pi, and pi less two cones up to the middle a volume.
    tube = relative_volume(*cylinder(96, 48, radius=0.5, height=4.0))
    assert tube == pytest.approx(np.pi * 2 / 3 / (4 * np.pi) ** 1.5, rel=5e-3)
    assert relative_volume(*moved(BALL, scale=0.0)) == 0.0


@pytest.mark.parametrize("name", TOLD)
def test_a_mirror_image_is_inside_out_and_no_other_pose_is(name):
    """Whichever side the faces show, and however the pose is turned and sized."""
    vertices, faces = TOLD[name]
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    for triangles in (faces, faces[:, ::-1]):
        assert is_inside_out(vertices * [-1, 1, 1], vertices, triangles)
        assert is_inside_out(-2 * vertices @ quarter, vertices, triangles)
        assert not is_inside_out(vertices, vertices, triangles)
        assert not is_inside_out(3 * vertices @ quarter + np.ptp(vertices), vertices, triangles)


# -- repair -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sphere", "creature with holes", "half a sphere", "tube"])
def test_repair_turns_a_mesh_outwards_and_says_so(name):
    vertices, faces = TOLD[name]
    repaired = repair_surface(turned_over(vertices, faces))
    assert repaired.report == (f"the mesh was inside out: {len(faces)} faces turned over",)
    np.testing.assert_array_equal(repaired.surface.vertices, vertices)
    np.testing.assert_array_equal(repaired.surface.faces, faces)
    assert repair_surface(repaired.surface).report == ()


def test_repair_goes_by_the_inside_and_not_by_the_majority():
    vertices, faces = BALL
    most = np.arange(len(faces)) % 5 > 0
    repaired = repair_surface((vertices, np.where(most[:, None], faces[:, ::-1], faces)))
    np.testing.assert_array_equal(repaired.surface.faces, faces)
    assert repaired.report == (f"{most.sum()} faces turned over so that all look outwards",)
    repaired = repair_surface((vertices, np.where(most[:, None], faces, faces[:, ::-1])))
    np.testing.assert_array_equal(repaired.surface.faces, faces)
    assert repaired.report == (f"{(~most).sum()} faces turned over to the orientation of the others",)


def test_a_sheet_keeps_the_side_that_it_has():
    surface = Surface(*turned_over(*grid(4)))
    assert repair_surface(surface).surface is surface


# -- what must not depend on it -----------------------------------------------------------------------


@pytest.mark.parametrize("metric", ["cartesian", "lifted"])
def test_distances_are_those_of_the_surface_from_either_side(metric):
    surface = Surface(*blob(2))
    other = surface.turned_over()
    expected = qg.distances(surface, [0, 50], metric, "exact")
    np.testing.assert_allclose(qg.distances(other, [0, 50], metric, "exact"), expected, rtol=1e-9, atol=1e-12)


def test_a_map_is_the_same_whichever_side_the_faces_show():
    """A creature with left and right, and itself renumbered: the true map is known."""
    vertices, faces = creature(level=2)
    order = np.random.default_rng(0).permutation(len(vertices))
    x, y = Surface(vertices, faces), Surface(vertices[order], np.argsort(order)[faces])
    shapes = [PreparedShape(shape) for shape in (x, x.turned_over(), y, y.turned_over())]
    straight = qg.match(shapes[0], shapes[2])
    assert straight.confident
    assert "inside" not in straight.explanation
    left = np.abs(vertices[:, 0]) > 0.1
    assert (np.sign(y.vertices[straight.p2p, 0]) == np.sign(vertices[:, 0]))[left].mean() > 0.98
    for one, other, said in ((0, 3, "; Y had"), (1, 2, "; X had"), (1, 3, "; X and Y had")):
        found = qg.match(shapes[one], shapes[other])
        assert found.confident
        assert said in found.explanation
        for name in ("p2p", "inverse", "functional_map", "positions", "margin", "orientation"):
            np.testing.assert_array_equal(getattr(found, name), getattr(straight, name), err_msg=f"{name} {said}")
        # Coordinates belong to the corners of the faces that were given, in their order.
        given, barycentric = (x, x.turned_over(), y, y.turned_over())[other], found.barycentric
        np.testing.assert_array_equal(barycentric.corners, given.faces[barycentric.faces])


def test_a_symmetry_is_the_same_whichever_side_the_faces_show():
    surface = Surface(*creature(level=2))
    straight, other = qg.self_symmetry(surface), qg.self_symmetry(surface.turned_over())
    assert straight.found
    np.testing.assert_array_equal(other.p2p, straight.p2p)
    np.testing.assert_array_equal(other.asymmetry, straight.asymmetry)


def bumpy_sheet():
    """An open sheet with unequal hills: it is like itself in one way only."""
    vertices, faces = grid(10)
    x, y, _ = vertices.T
    hills = ((0.25, 0.3, 0.35), (0.7, 0.25, 0.2), (0.6, 0.75, 0.5))
    height = sum(h * np.exp(-((x - a) ** 2 + (y - b) ** 2) / 0.02) for a, b, h in hills)
    return Surface(np.column_stack([x, 1.3 * y, height]), faces)


@pytest.mark.parametrize("turned", [False, True])
def test_a_map_between_sheets_is_not_called_sure(turned):
    sheet = PreparedShape(bumpy_sheet())
    other = PreparedShape(bumpy_sheet().turned_over()) if turned else sheet
    assert (sheet.winding, other.winding) == ("undetermined", "undetermined")
    found = qg.match(sheet, other)
    assert not found.confident
    assert turned or "which side of X and Y is out cannot be told" in found.explanation
