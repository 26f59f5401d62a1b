"""A prepared shape goes through arrays and comes back: equal bit for bit, and nothing is computed again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import bent, creature
from small_collection import QUICK

import qgeo_filters as qg
from qgeo_filters.errors import MeshError
from qgeo_filters.matching import intrinsic_shape, prepared_shape
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.shape_arrays import arrays_of_shape, shape_of_arrays

PROXIES = replace(QUICK, search_vertices=100, registration_vertices=130)
MORE_METRICS = replace(PROXIES, curvature_weights=(0.0, 0.15))


def given(bend: float, kind: str) -> qg.Surface:
    vertices, faces = creature(level=2)
    vertices, faces = bent(vertices.copy(), bend), faces.copy()
    if kind == "inside out":
        faces = faces[:, ::-1]
    if kind == "soup":  # to be welded
        return qg.Surface(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    return qg.Surface(vertices, faces)


@pytest.fixture(scope="module")
def taken_apart() -> tuple[qg.Surface, dict, dict]:
    surface = given(0.0, "plain")
    return surface, *arrays_of_shape(PreparedShape(surface, parameters=PROXIES))


def alike(one: qg.MatchResult, other: qg.MatchResult) -> None:
    for name in ("p2p", "inverse", "distortion", "positions", "functional_map", "regions_x", "regions_y"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)
    assert (one.c_xy, one.margin, one.explanation, one.repairs) == (
        other.c_xy, other.margin, other.explanation, other.repairs,
    )  # fmt: skip
    assert str(one.log) == str(other.log)


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [("plain", QUICK), ("plain", MORE_METRICS), ("inside out", PROXIES), ("soup", PROXIES)],
    ids=["no proxies", "two metrics", "inside out", "soup"],
)
def test_restored_shapes_match_as_the_prepared_ones_do(
    kind: str, parameters: qg.MatchingParameters, monkeypatch: pytest.MonkeyPatch
) -> None:
    surfaces = [given(0.0, "plain"), given(0.3, kind)]
    expected = qg.match(*(PreparedShape(surface, parameters=parameters) for surface in surfaces))
    parts = [arrays_of_shape(PreparedShape(surface, parameters=parameters)) for surface in surfaces]
    with monkeypatch.context() as patch:
        for module, name in (
            (intrinsic_shape, "distance_matrix"),
            (intrinsic_shape, "laplacian_spectrum"),
            (intrinsic_shape, "spectrum_of_matrix"),
            (intrinsic_shape, "mean_curvature"),
            (prepared_shape, "decimated"),
            (prepared_shape, "surface_and_repair"),
        ):
            patch.setattr(module, name, lambda *_, **__: pytest.fail("computed again"))
        # Arrays may lie elsewhere in memory, but rows stay rows.
        shapes = [
            shape_of_arrays(
                surface, {name: array.copy(order="K") for name, array in arrays.items()}, values, parameters
            )
            for surface, (arrays, values) in zip(surfaces, parts, strict=True)
        ]
        alike(qg.match(*shapes), expected)
        for shape, (arrays, values) in zip(shapes, parts, strict=True):
            again, same = arrays_of_shape(shape)
            assert same == values
            assert again.keys() == arrays.keys()
            for name, array in arrays.items():
                np.testing.assert_array_equal(again[name], array, strict=True)
    found = qg.self_symmetry(shapes[1])
    symmetry = qg.self_symmetry(PreparedShape(surfaces[1], parameters=parameters))
    assert (found.found, found.reason, found.epsilon) == (symmetry.found, symmetry.reason, symmetry.epsilon)
    np.testing.assert_array_equal(found.barycentric.corners, symmetry.barycentric.corners, strict=True)


@pytest.mark.parametrize("name", ["fps", "coarse_members", "fine_places", "symmetry_nearest", "rough_reflection_0"])
@pytest.mark.parametrize("wrong", [-1, 10**6])
def test_indices_out_of_range_are_refused(taken_apart: tuple[qg.Surface, dict, dict], name: str, wrong: int) -> None:
    surface, arrays, values = taken_apart
    changed = arrays[name].copy()
    changed[3] = wrong
    with pytest.raises(MeshError):
        shape_of_arrays(surface, {**arrays, name: changed}, values, PROXIES)


def test_missing_and_short_arrays_are_refused(taken_apart: tuple[qg.Surface, dict, dict]) -> None:
    surface, arrays, values = taken_apart
    for name in arrays:
        if name.startswith(("symmetry_plane", "symmetry_curve", "rough")):
            continue
        with pytest.raises(MeshError):
            shape_of_arrays(surface, {key: value for key, value in arrays.items() if key != name}, values, PROXIES)
    for name in ("log_hks", "fps_distances", "eigenfunctions_0", "laplacian_eigenfunctions"):
        with pytest.raises(MeshError, match="at all of its"):
            shape_of_arrays(surface, {**arrays, name: arrays[name][:-1, :-1]}, values, PROXIES)
