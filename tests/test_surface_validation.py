"""Surface: what it refuses, and that neither it nor its input ever changes."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, bow_tie, fan, grid, icosphere

import qgeo_filters as qg
from qgeo_filters.errors import DisconnectedError, MeshError, NonManifoldError
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.surface import Surface

# -- immutability -------------------------------------------------------------------------------------

DERIVED = [
    "vertices",
    "faces",
    "edge_lengths",
    "face_areas",
    "vertex_areas",
    "face_normals",
    "corner_angles",
    "vertex_normals",
    "edges",
    "face_edges",
    "twins",
    "unreferenced_vertices",
    "boundary_edges",
    "nonmanifold_edges",
    "nonmanifold_vertices",
]


@pytest.mark.parametrize("name", DERIVED)
def test_arrays_are_read_only(name):
    array = getattr(Surface(*icosphere(1)), name)
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 0


@pytest.mark.parametrize("name", DERIVED)
def test_no_flag_makes_an_array_writeable_again(name):
    array = getattr(Surface(*icosphere(1)), name)
    with pytest.raises(ValueError, match="WRITEABLE"):
        array.flags.writeable = True


@pytest.mark.parametrize("name", [*DERIVED, "attributes", "area", "n_vertices", "is_closed", "components", "anything"])
def test_nothing_can_be_set_or_deleted(name):
    surface = Surface(*icosphere(1))
    before = {key: np.copy(getattr(surface, key)) for key in ("vertices", "faces", "face_areas")}
    with pytest.raises(AttributeError, match=f"cannot set '{name}': a Surface never changes"):
        setattr(surface, name, 2 * surface.vertices)
    with pytest.raises(AttributeError, match=f"cannot delete '{name}': a Surface never changes"):
        delattr(surface, name)
    for key, values in before.items():
        np.testing.assert_array_equal(getattr(surface, key), values)


def test_the_error_says_what_to_do_instead():
    surface = Surface(*icosphere(1))
    with pytest.raises(AttributeError, match=r"surface\.with_vertices\(\.\.\.\) gives another"):
        surface.vertices = 2 * surface.vertices
    with pytest.raises(AttributeError, match=r"surface\.with_attributes\(\.\.\.\) gives another"):
        surface.attributes = {}
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices *= 2


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_are_as_immutable_and_derive_the_same(copied):
    surface = Surface(*icosphere(1), {"a": np.arange(42)})
    areas = surface.face_areas
    other = copied(surface)
    assert other is not surface
    np.testing.assert_array_equal(other.vertices, surface.vertices)
    np.testing.assert_array_equal(other.faces, surface.faces)
    np.testing.assert_array_equal(other.attributes["a"], surface.attributes["a"])
    np.testing.assert_array_equal(other.face_areas, areas)
    with pytest.raises(AttributeError, match="never changes"):
        other.vertices = 2 * other.vertices
    with pytest.raises(ValueError, match="read-only"):
        other.vertices[0] = 0


def test_boundary_loops_are_read_only():
    loops = Surface(*fan()).boundary_loops + Surface(*grid(3)).boundary_loops
    assert isinstance(loops, tuple)
    for loop in loops:
        with pytest.raises(ValueError, match="read-only"):
            loop[0] = 7


def test_input_is_copied():
    v, f = (array.copy() for array in icosphere(1))
    a = np.zeros(len(v))
    surface = Surface(v, f, {"a": a})
    before = surface.vertices.copy()
    v += 1
    f[:] = 0
    a += 1
    np.testing.assert_array_equal(surface.vertices, before)
    assert surface.faces.any()
    assert not surface.attributes["a"].any()
    with pytest.raises(TypeError):
        surface.attributes["b"] = a


@settings(max_examples=60)
@given(
    vertex_dtype=st.sampled_from(["f4", "f8", ">f8", "f2", "i4", "i8"]),
    face_dtype=st.sampled_from(["i4", "i8", "u2", "u4", "u8", ">i4", "f4", "f8"]),
    fortran=st.booleans(),
    read_only=st.booleans(),
    strided=st.booleans(),
    as_list=st.booleans(),
)
def test_any_dtype_order_and_flag_gives_the_same_surface(
    vertex_dtype, face_dtype, fortran, read_only, strided, as_list
):
    v = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]])
    f = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    arrays = []
    for values, dtype in ((v, vertex_dtype), (f, face_dtype)):
        array = np.array(values, dtype=dtype, order="F" if fortran else "C")
        if strided:
            array = np.repeat(array, 2, axis=0)[::2]
        array.setflags(write=not read_only)
        arrays.append(array.tolist() if as_list else array)
    surface = Surface(*arrays)
    assert surface.vertices.dtype == np.float64
    assert surface.faces.dtype == np.int32
    assert surface.vertices.flags.c_contiguous
    assert surface.faces.flags.c_contiguous
    np.testing.assert_array_equal(surface.vertices, v)
    np.testing.assert_array_equal(surface.faces, f)
    assert surface.genus == 0


# -- validation ---------------------------------------------------------------------------------------

V, F = icosphere(1)


def changed(array, index, value, dtype=None):
    array = np.array(array, dtype=dtype)
    array[index] = value
    return array


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.empty((0, 3)), F, "the mesh has no vertices"),
        (V, np.empty((0, 3), int), "the mesh has no faces"),
        (V[:, :2], F, r"vertices must have shape \(n, 3\), got \(42, 2\)"),
        ([[0, 0, 0], [1, 0]], F, "vertices must be numbers in rows of three: .*inhomogeneous"),
        ("vertices", F, "vertices must be numbers in rows of three: could not convert"),
        (None, F, r"vertices must have shape \(n, 3\)|vertices must be numbers"),
        (V + 1j, F, "vertices must be real numbers, got complex ones"),
        (V, [[0, 1, 2], [0, 1]], "faces must be whole numbers in rows of three: .*inhomogeneous"),
        (V, "faces", r"faces must have shape \(m, 3\)"),
        (V, F.astype(str), "faces must hold whole numbers"),
        (V.ravel(), F, r"vertices must have shape \(n, 3\), got \(126,\)"),
        (V, F[:, :2], r"faces must have shape \(m, 3\), got \(80, 2\)$"),
        (V, np.zeros((5, 4), int), r"got \(5, 4\) \(quadrilaterals\? triangulate the mesh first\)"),
        (changed(V, 17, np.nan), F, r"vertices\[17\] is \[nan, nan, nan\]: .* finite \(1 such vertex\)"),
        (changed(V, (slice(3, 5), 1), np.inf), F, r"vertices\[3\] .* finite \(2 such vertices\)"),
        (V * 1e51, F, "units wide"),
        (V * 1e-46, F, "units wide"),
        (V, changed(F, (9, 1), 42), r"faces\[9\] refers to vertex 42, but there are 42 vertices.*\(1 such face\)"),
        (V, changed(F, (slice(4, 6), 0), -1), r"faces\[4\] refers to vertex -1, .*\(2 such faces\)"),
        (V, changed(F, (0, 0), 2**40, np.int64), r"refers to vertex 1099511627776"),
        (V, changed(F, (3, 0), F[3, 1]), r"faces\[3\] = .* names a vertex twice \(1 such face\).*repair=True"),
        (V, changed(F, (0, 0), 0.5, float), "faces must hold whole numbers, got dtype float64"),
        (V, changed(F, (0, 0), np.nan, float), "faces must hold whole numbers"),
        (V, F > 3, "faces must hold whole numbers, got dtype bool"),
    ],
)
def test_bad_arrays_are_named(vertices, faces, message):
    with pytest.raises(MeshError, match=message):
        Surface(vertices, faces)
    with pytest.raises(MeshError, match=message):
        as_surface((vertices, faces))


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [([[0, 0, 0], [1, 0]], F), ("vertices", F), (V, [[0, 1, 2], ["a", "b"]]), (V, "faces"), (V, F.astype(str))],
)
def test_what_is_no_array_is_refused_by_repair_too(vertices, faces):
    with pytest.raises(MeshError, match=r"(vertices|faces) must"):
        as_surface((vertices, faces), repair=True)


@pytest.mark.parametrize("values", [np.zeros(41), np.zeros((3, 42)), 3.0])
def test_attribute_of_wrong_length_is_named(values):
    with pytest.raises(MeshError, match=r"attribute 'a' has shape .*, but there are 42 vertices"):
        Surface(V, F, {"a": values})


def test_requirements_name_the_offender():
    with pytest.raises(NonManifoldError, match=r"X needs .* edge \(0, 1\) has 3 faces \(1 such edge\); repair=True"):
        Surface(*fan()).require_manifold("X")
    with pytest.raises(NonManifoldError, match=r"X needs .* vertex 0 form more than one fan \(1 such vertex: 0\)"):
        Surface(*bow_tie()).require_manifold("X")
    v, f = icosphere(2)
    two = Surface(np.vstack([v, V + 5]), np.vstack([f, F + len(v)]))
    with pytest.raises(DisconnectedError, match=r"X needs .* 2 pieces of 162, 42 vertices; .*, or repair='force'$"):
        two.require_connected("X")
    with pytest.raises(DisconnectedError, match=r"1 of them single vertices without faces \(42\); .* repair=True$"):
        Surface(np.vstack([V, [[9, 9, 9]]]), F).require_connected("X")
    Surface(V, F).require_manifold("X")
    Surface(V, F).require_connected("X")


@pytest.mark.parametrize("power", [-148, 164])  # of two: 2.8e-45 and 2.3e49
@pytest.mark.parametrize("method", ["graph", "exact", "edges"])
def test_distances_scale_with_the_mesh_up_to_the_width_that_is_refused(method: str, power: int) -> None:
    """A mesh 1e-100 wide was taken, and its distances were a hundredth of what they are, or never ended."""
    vertices, faces = blob(2)
    expected = qg.distances((vertices, faces), [0], method=method)
    found = qg.distances((vertices * 2.0**power, faces), [0], method=method)
    np.testing.assert_array_equal(found, expected * 2.0**power)


def test_complex_vertices_are_refused_without_a_warning_of_numpy() -> None:
    with pytest.raises(MeshError, match="real numbers, got complex ones"):
        qg.as_surface((V + 1j, F), repair="auto")


def test_a_path_on_a_mesh_in_one_point_bends_nowhere() -> None:
    vertices, faces = blob(1)
    path = qg.quasi_geodesic((0 * vertices, faces), 0, 7)
    assert path.length == 0.0
    assert (path.kappa_g == 0.0).all()
