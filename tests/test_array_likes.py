"""Arrays of other libraries, wherever numbers are given: tensors on any device, picked points."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from tensors import Tensor

import qgeo_filters as qg
from qgeo_filters.array_likes import as_array, vertex_number

SURFACE = qg.testing.sample_surface()
N = SURFACE.n_vertices
KINDS = [{}, {"requires_grad": True}, {"device": "cuda:0"}, {"requires_grad": True, "device": "cuda:0"}]


class PickedPoint(SimpleNamespace):
    """What ``get_picked_points()`` of Open3D's windows gives; it cannot be made without a window."""


@pytest.mark.parametrize("kind", KINDS)
def test_tensors_are_arrays_with_their_type(kind):
    values = np.arange(6, dtype=np.float32).reshape(2, 3)
    found = as_array(Tensor(values, **kind))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, values)
    np.testing.assert_array_equal(as_array([Tensor(row, **kind) for row in values]), values)


def test_tensors_that_numpy_has_no_type_for():
    """A view of the opposites, and bfloat16, whose numbers float32 has; a type that nobody can change stays refused."""
    values = np.array([[0.5, -1.25, 3.0], [2.0, 1e30, 0.0]], dtype=np.float32)
    np.testing.assert_array_equal(as_array(Tensor(values, negative=True)), -values)
    found = as_array(Tensor(values, half=True, requires_grad=True, device="cuda:0"))
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, values, rtol=2**-7)
    np.testing.assert_array_equal(found[0], values[0])
    with pytest.raises(TypeError, match="no such type"):
        as_array(SimpleNamespace(cpu=lambda: SimpleNamespace(numpy=refused), numpy=refused))


def refused():
    raise TypeError("no such type")


def test_a_tensor_without_numbers_is_refused():
    """Of PyTorch's device "meta": a shape alone."""

    def cpu():
        raise NotImplementedError("Cannot copy out of meta tensor; no data!")

    nothing = SimpleNamespace(cpu=cpu, numpy=refused)
    with pytest.raises(qg.QgeoError, match="vertices must be numbers in rows of three: Cannot copy out of meta tensor"):
        qg.Surface(nothing, SURFACE.faces)


# Where PyTorch is installed; it is too large for our tests, in which the stand-in speaks its words.
VERTICES = {
    "double": lambda torch, values: torch.tensor(values),
    "float": lambda torch, values: torch.tensor(values).float(),
    "gradient": lambda torch, values: torch.tensor(values, requires_grad=True),
    "computed from a gradient": lambda torch, values: 2 * torch.tensor(values / 2).requires_grad_(),
    "parameter": lambda torch, values: torch.nn.Parameter(torch.tensor(values)),
    "columns first": lambda torch, values: torch.tensor(np.ascontiguousarray(values.T)).T,
    "every other row": lambda torch, values: torch.tensor(np.repeat(values, 2, axis=0))[::2],
    "opposites": lambda torch, values: torch._neg_view(torch.tensor(-values)),
    "bfloat16": lambda torch, values: torch.tensor(values).bfloat16(),
}
FACES = {
    "int64": lambda torch, faces: torch.tensor(faces).long(),
    "int32": lambda torch, faces: torch.tensor(faces).int(),
    "columns first": lambda torch, faces: torch.tensor(np.ascontiguousarray(faces.T)).long().T,
}


@pytest.mark.parametrize("of_faces", FACES)
@pytest.mark.parametrize("of_vertices", VERTICES)
def test_a_mesh_of_pytorch(of_vertices, of_faces):
    torch = pytest.importorskip("torch")
    vertices = VERTICES[of_vertices](torch, np.array(SURFACE.vertices))
    faces = FACES[of_faces](torch, np.array(SURFACE.faces))
    surface = qg.Surface(vertices, faces)
    np.testing.assert_array_equal(surface.vertices, vertices.detach().double().resolve_neg().numpy())
    np.testing.assert_array_equal(surface.faces, SURFACE.faces)
    found = qg.distances((vertices, faces), torch.tensor([17, 3]))
    assert type(found) is np.ndarray
    np.testing.assert_array_equal(found, qg.distances(surface, [17, 3]))
    with torch.no_grad():  # of what is the user's, nothing is shared with the surface
        vertices[0] += 1
    assert np.abs(surface.vertices[0] - vertices[0].detach().double().resolve_neg().numpy()).min() > 0.9


@pytest.mark.filterwarnings("error")
def test_a_match_of_pytorch():
    """What comes back are arrays, and PyTorch copies them without a warning, for indices say."""
    torch = pytest.importorskip("torch")
    vertices = torch.tensor(np.array(SURFACE.vertices), dtype=torch.float32, requires_grad=True)
    faces = torch.tensor(np.array(SURFACE.faces)).long()
    found = qg.match((vertices, faces), (1.5 * vertices, faces))
    assert found.confident
    assert type(found.p2p) is np.ndarray
    np.testing.assert_array_equal(found.p2p, qg.match(qg.Surface(vertices, faces), (1.5 * vertices, faces)).p2p)
    p2p = torch.tensor(found.p2p)
    assert p2p.dtype == torch.int64
    assert vertices[p2p].requires_grad
    carried = found.transfer(torch.rand(N, 3, requires_grad=True))
    assert type(carried) is np.ndarray
    assert torch.from_numpy(carried).shape == (N, 3)
    landmarks = qg.match((vertices, faces), (vertices, faces), landmarks=torch.tensor([[3, 3], [5, 5]])).landmark_errors
    np.testing.assert_array_equal(landmarks, 0)


def test_a_matrix_of_distances_may_be_a_tensor():
    matrix = qg.distance_matrix(SURFACE)
    expected = qg.distance_spectrum(SURFACE, k=4, matrix=matrix)
    found = qg.distance_spectrum(SURFACE, k=4, matrix=Tensor(matrix, requires_grad=True, device="cuda:0"))
    np.testing.assert_array_equal(found.eigenvalues, expected.eigenvalues)
    np.testing.assert_array_equal(found.eigenfunctions, expected.eigenfunctions)


def test_what_numpy_takes_is_what_it_takes():
    array = np.arange(3)
    assert as_array(array) is array
    for given in (3, [1, 2], (1.5, 2), [[1, 2], [3, 4]], ["a", "b"], [], "abc", None, [None, 1]):
        expected = np.asarray(given)
        assert as_array(given).dtype == expected.dtype
        np.testing.assert_array_equal(as_array(given), expected)
    with pytest.raises(ValueError, match="inhomogeneous"):
        as_array([[1, 2], [3]])
    assert vertex_number("a") == "a"
    assert vertex_number(True) is True


def test_tensors_of_open3d():
    open3d = pytest.importorskip("open3d")
    pair = open3d.core.Tensor(np.array(SURFACE.vertices)), open3d.core.Tensor(np.array(SURFACE.faces))
    np.testing.assert_array_equal(qg.distances(pair, open3d.core.Tensor([17, 3])), qg.distances(SURFACE, [17, 3]))


def test_picked_points_are_vertices():
    if "open3d" in sys.modules:  # the stand-in is called as the real one is
        assert PickedPoint.__name__ == sys.modules["open3d"].visualization.PickedPoint.__name__
    picked = [PickedPoint(index=17, coord=SURFACE.vertices[17]), PickedPoint(index=3, coord=SURFACE.vertices[3])]
    np.testing.assert_array_equal(qg.distances(SURFACE, picked), qg.distances(SURFACE, [17, 3]))
    np.testing.assert_array_equal(qg.quasi_geodesic(SURFACE, *picked).points, qg.quasi_geodesic(SURFACE, 17, 3).points)
    pairs = [(one, other) for one, other in zip(picked, picked, strict=True)]
    found = qg.match(SURFACE, SURFACE, landmarks=pairs)
    assert len(found.landmark_errors) == 2
    np.testing.assert_array_equal(found.landmarks(picked).vertices, [17, 3])


def test_real_picked_points_have_the_number_of_their_vertex():
    open3d = pytest.importorskip("open3d")
    assert isinstance(open3d.visualization.PickedPoint.index, property)


@pytest.mark.parametrize("kind", KINDS)
def test_tensors_wherever_numbers_are_given(kind):
    def tensor(values):
        return Tensor(values, **kind)

    pair = tensor(SURFACE.vertices), tensor(SURFACE.faces)
    assert qg.as_surface(SimpleNamespace(vertices=pair[0], faces=pair[1])).n_faces == SURFACE.n_faces
    expected = qg.distances(SURFACE, [17, 3])
    for sources in (tensor([17, 3]), [tensor(17), tensor(3)]):
        np.testing.assert_array_equal(qg.distances(pair, sources), expected)
    assert qg.quasi_geodesic(pair, tensor(0), tensor(50)).length == qg.quasi_geodesic(SURFACE, 0, 50).length
    height = SURFACE.vertices[:, 2]
    np.testing.assert_array_equal(
        qg.lifted_metric(pair, tensor(height)).edge_lengths, qg.lifted_metric(SURFACE, height).edge_lengths
    )
    assert SURFACE.with_attributes({"a": tensor(height)}).attributes["a"].dtype == np.float64
    pose = 1.5 * SURFACE.vertices
    moved = qg.transfer_deformation(pair, tensor(pose[None]), pair, tensor(np.arange(N)))
    np.testing.assert_array_equal(
        moved.positions, qg.transfer_deformation(SURFACE, pose[None], SURFACE, np.arange(N)).positions
    )
    repaired = qg.repair_surface((pair[0], tensor(np.concatenate([SURFACE.faces, SURFACE.faces[:1]]))))
    assert repaired.surface.n_faces == SURFACE.n_faces
    np.testing.assert_array_equal(repaired.map_back(tensor(height)), height)


def test_tensors_in_a_match():
    tensor = Tensor
    labels = np.where(SURFACE.vertices[:, 0] > 0, 1, 0)
    found = qg.match(
        (tensor(SURFACE.vertices), tensor(SURFACE.faces)),
        SURFACE,
        landmarks=tensor([[3, 3]], device="cuda:0"),
        labels=(tensor(labels), tensor(labels, requires_grad=True)),
    )
    np.testing.assert_array_equal(found.p2p, np.arange(N))
    for values in (SURFACE.vertices, labels):
        np.testing.assert_array_equal(found.transfer(tensor(values, device="cuda:0")), found.transfer(values))
    np.testing.assert_array_equal(found.error(tensor(np.arange(N), device="cuda:0")), np.zeros(N))
