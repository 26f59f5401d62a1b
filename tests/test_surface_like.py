"""README's promise: every public function takes a `Surface`, or anything that `as_surface` takes, with the same result.

The functions are found in ``qgeo_filters.__all__`` by what their first parameters are called, so that a new one without
a case here fails the first test.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterator
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator
from shapes import blob
from tensors import Tensor

import qgeo_filters as qg
from qgeo_filters import evaluation
from qgeo_filters.evaluation import errors as evaluation_errors

PARAMETERS = {"surface", "surfaces", "shape", "template", "mesh", "x", "y", "x_reference"}

SURFACE = qg.Surface(*blob(2))
N = SURFACE.n_vertices
SMOOTH = np.cos(SURFACE.vertices[:, 0])
P2P = np.roll(np.arange(N), 1)
OTHER = SURFACE.with_vertices(SURFACE.vertices * [1.1, 1.0, 0.9])
COUNTS = {"k": 5, "landmarks": 20}

# name: call with the mesh in place of a surface
CASES: dict[str, Callable[[Any], Any]] = {
    "Surface": lambda m: None,  # is what the others are compared with
    "as_surface": qg.as_surface,
    "repair_surface": qg.repair_surface,
    "differential_coordinates": lambda m: qg.differential_coordinates(m, "cotangent"),
    "vertex_normals": qg.vertex_normals,
    "surface_scalar": qg.surface_scalar,
    "principal_curvatures": qg.principal_curvatures,
    "lifted_metric": qg.lifted_metric,
    "distances": lambda m: qg.distances(m, [0, 7]),
    "distance_matrix": qg.distance_matrix,
    "quasi_geodesic": lambda m: qg.quasi_geodesic(m, 0, 7),
    "quasi_geodesics": lambda m: qg.quasi_geodesics(m, [[0, 7], [3, 2]]),
    "DistanceOperator": qg.DistanceOperator,
    "GeodesicSolver": lambda m: qg.GeodesicSolver(m).distances([0, 7]),
    "distance_spectrum": lambda m: qg.distance_spectrum(m, 5),
    "landmark_spectrum": lambda m: qg.landmark_spectrum(m, **COUNTS),
    "streamed_spectrum": lambda m: qg.streamed_spectrum(m, **COUNTS),
    "proxy_spectrum": lambda m: qg.proxy_spectrum(m, 5, vertices=100),
    "laplacian_spectrum": lambda m: qg.laplacian_spectrum(m, 5),
    "self_symmetry": qg.self_symmetry,
    "match": lambda m: qg.match(m, m),
    "match_pieces": lambda m: qg.match_pieces(m, m),
    "transfer_deformation": lambda m: qg.transfer_deformation(m, [OTHER], m, np.arange(N)),
    "transferred_poses": lambda m: list(qg.transferred_poses(m, [OTHER], m, np.arange(N))),
    "transfer_pose": lambda m: qg.transfer_pose(OTHER, m, np.arange(N)),
    "remesh_like": lambda m: (qg.remesh_like(m, OTHER, np.arange(N)), qg.remesh_like(OTHER, m, np.arange(N))),
    "interpolate": lambda m: qg.interpolate(m, OTHER, 0.5),
    "PreparedShape": lambda m: (qg.PreparedShape(m).unit, qg.PreparedShape(m).areas),
    "compatibility": lambda m: qg.compatibility([m, OTHER], k=4),
    "barycentric_map": lambda m: qg.barycentric_map(SURFACE.vertices, P2P, m),
    "evaluation.geodesic_error": lambda m: evaluation.geodesic_error(P2P, np.arange(N), m),
    "evaluation.symmetric_errors": lambda m: evaluation.symmetric_errors(P2P, np.arange(N), P2P, m),
    "evaluation.mirrored": lambda m: evaluation_errors.mirrored(P2P, np.arange(N), P2P, m),
}


def takes_a_mesh(value: Any) -> bool:
    """Whether a parameter of a function or class is called as meshes are."""
    is_one = inspect.isroutine(value) or isinstance(value, type)
    return is_one and bool(PARAMETERS & set(inspect.signature(value).parameters))


def public() -> Iterator[tuple[str, Any]]:
    """Public functions and classes, apart from filters (objects that are called with a mesh) and errors."""
    names = {name: getattr(qg, name) for name in qg.__all__}
    names |= {f"evaluation.{name}": getattr(evaluation, name) for name in evaluation.__all__}
    for name, value in names.items():
        is_other = isinstance(value, type) and issubclass(value, (qg.Filter, Exception))
        # What functions return is made by them.
        if not is_other and not dataclasses.is_dataclass(value):
            yield name, value


def test_there_is_a_case_for_each_public_function_on_a_surface():
    wanted = {name for name, value in public() if takes_a_mesh(value)}
    assert wanted >= {"distances", "match", "compatibility", "PreparedShape", "barycentric_map"}  # the search works
    assert wanted - set(CASES) == set()


def a_pair(tmp_path):
    return np.array(SURFACE.vertices), np.array(SURFACE.faces)


def lists(tmp_path):
    return SURFACE.vertices.tolist(), SURFACE.faces.tolist()


def tensors(tmp_path):
    return Tensor(SURFACE.vertices, requires_grad=True), Tensor(SURFACE.faces, device="cuda:0")


def an_object(tmp_path):
    return SimpleNamespace(vertices=np.array(SURFACE.vertices), faces=np.array(SURFACE.faces))


def a_path(tmp_path):
    SURFACE.write(tmp_path / "shape.ply")
    return tmp_path / "shape.ply"


def an_open3d_mesh(tmp_path):
    open3d = pytest.importorskip("open3d")
    mesh = open3d.t.geometry.TriangleMesh()
    mesh.vertex.positions = open3d.core.Tensor(np.array(SURFACE.vertices))
    mesh.triangle.indices = open3d.core.Tensor(np.array(SURFACE.faces))
    return mesh


@cache
def expected(name: str) -> list[Any]:
    return list(contents(CASES[name](SURFACE)))


def contents(result: Any) -> Iterator[Any]:
    """Arrays and numbers of a result of any kind, in order."""
    if isinstance(result, qg.Surface):
        yield from (result.vertices, result.faces)
    elif isinstance(result, LinearOperator):
        yield from (result @ SMOOTH, result.shape)
    elif dataclasses.is_dataclass(result):
        for field in dataclasses.fields(result):
            yield from contents(getattr(result, field.name))
    elif isinstance(result, (list, tuple)) and not np.isscalar(result):
        for part in result:
            yield from contents(part)
    elif isinstance(result, dict):
        yield from contents(list(result.items()))
    else:
        yield result


@pytest.mark.parametrize("make", [a_pair, lists, tensors, an_object, a_path, an_open3d_mesh])
@pytest.mark.parametrize("name", [name for name in CASES if name != "Surface"])
def test_the_result_is_that_of_the_surface_bit_for_bit(name, make, tmp_path):
    if name in ("match", "self_symmetry", "compatibility") and make is not a_pair:
        pytest.skip("slow, and they take all kinds through one door")
    found = list(contents(CASES[name](make(tmp_path))))
    assert len(found) == len(expected(name)) > 0
    for a, b in zip(found, expected(name), strict=True):
        assert type(a) is type(b)
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("name", [name for name in CASES if name != "Surface"])
def test_what_is_no_mesh_is_refused_in_one_sentence(name):
    said = r"^([XY]: |surfaces\[0\]: )?cannot take a mesh from builtins\.int: expected"
    with pytest.raises(qg.MeshError, match=said):
        CASES[name](3)


@pytest.mark.parametrize("name", [name for name in CASES if name != "Surface"])
def test_arrays_of_result_objects_are_read_only(name):
    """What is kept, shared or called frozen must not be written to; bare arrays are the caller's own."""
    result = CASES[name](SURFACE)
    for part in result if isinstance(result, (list, tuple)) else [result]:
        if dataclasses.is_dataclass(part):
            for array in contents(part):
                assert not (isinstance(array, np.ndarray) and array.flags.writeable)


@pytest.mark.parametrize("function", [qg.distances, qg.quasi_geodesic, qg.DistanceOperator, qg.GeodesicSolver])
def test_a_metric_made_from_one_pair_is_that_of_an_equal_pair_only(function):
    """A pair becomes a new `Surface` in every call, so that only the content can tell."""
    pair, other = (SURFACE.vertices, SURFACE.faces), (OTHER.vertices, OTHER.faces)
    metric = qg.lifted_metric(pair)
    arguments = {qg.distances: ([0, 7],), qg.quasi_geodesic: (0, 7)}.get(function, ())
    found = list(contents(function(pair, *arguments, metric=metric)))
    wanted = list(contents(function(SURFACE, *arguments, metric=qg.lifted_metric(SURFACE))))
    if function is not qg.GeodesicSolver:
        for a, b in zip(found, wanted, strict=True):
            np.testing.assert_array_equal(a, b)
    with pytest.raises(qg.ParameterError, match="the metric belongs to another surface"):
        function(other, *arguments, metric=metric)
