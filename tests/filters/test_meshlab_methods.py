"""The methods that `register_pymeshlab` binds to MeshSet."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters import defaults
from qgeo_filters.filters import meshlab_methods
from qgeo_filters.testing import sample_surface

pymeshlab = pytest.importorskip("pymeshlab")


@pytest.fixture
def meshset() -> object:
    surface = sample_surface()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    qg.register_pymeshlab()
    return meshes


def test_names_follow_pymeshlab(meshset: object) -> None:
    names = qg.register_pymeshlab()
    verbs = ("compute_scalar_by_", "compute_coord_by_", "transfer_attributes_by_", "save_current_mesh_")
    assert all(name.startswith(verbs) for name in names)
    assert all(name.endswith("_per_vertex") for name in names if "_scalar_by_" in name)
    assert set(names).isdisjoint(pymeshlab.filter_list())  # nothing of PyMeshLab's own is replaced
    assert all(callable(getattr(meshset, name)) for name in names)


def test_distance_is_the_scalar_and_can_be_chained(meshset: pymeshlab.MeshSet) -> None:
    surface = sample_surface()
    method = meshset.compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex
    answer = method(startpoint=surface.vertices[17] * 1.01)
    expected = qg.QuasiGeodesicDistances(sources=17)(surface).attributes["qgeo_distance"]
    assert answer["start_vertex"] == 17
    assert np.allclose(meshset.current_mesh().vertex_scalar_array(), expected, rtol=1e-5)
    assert answer["maximum"] == pytest.approx(expected.max())
    meshset.compute_selection_by_condition_per_vertex(condselect="q < 0.5")  # PyMeshLab's own filters see it
    assert meshset.current_mesh().selected_vertex_number() == (expected < 0.5).sum()


def test_a_second_call_replaces_the_scalar(meshset: pymeshlab.MeshSet) -> None:
    meshset.compute_scalar_by_quasi_geodesic_spectrum_per_vertex(component=0, k=3)
    answer = meshset.compute_scalar_by_quasi_geodesic_spectrum_per_vertex(component=2, k=3)
    scalar = meshset.current_mesh().vertex_scalar_array()
    assert np.allclose(scalar, answer["eigenfunctions"][:, 2], rtol=1e-5, atol=1e-6)
    assert answer["eigenvalues"].shape == (3,)


def test_f_and_the_differential_norm(meshset: pymeshlab.MeshSet) -> None:
    surface = sample_surface()
    meshset.compute_scalar_by_lifted_metric_scalar_per_vertex(scalar="shape_index")
    f = qg.surface_scalar(surface, "shape_index")
    assert np.allclose(meshset.current_mesh().vertex_scalar_array(), f, rtol=1e-4, atol=1e-5)
    meshset.compute_scalar_by_differential_norm_per_vertex()
    norm = np.linalg.norm(qg.differential_coordinates(surface), axis=1)
    assert np.allclose(meshset.current_mesh().vertex_scalar_array(), norm, rtol=1e-4)


def test_bad_arguments_get_one_sentence(meshset: pymeshlab.MeshSet) -> None:
    with pytest.raises(ValueError, match="component must lie between 0 and k - 1 = 2, got 3"):
        meshset.compute_scalar_by_quasi_geodesic_spectrum_per_vertex(component=3, k=3)
    with pytest.raises(qg.MeshError, match="startpoint must be three finite coordinates"):
        meshset.compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex(startpoint=(0, np.nan, 0))


def test_workers_are_those_of_the_filters(meshset: pymeshlab.MeshSet) -> None:
    distance = meshset.compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex
    spectrum = meshset.compute_scalar_by_quasi_geodesic_spectrum_per_vertex
    assert distance(workers=1) == distance(workers=2) == distance()
    for method in (distance, spectrum):
        with pytest.raises(qg.ParameterError, match="workers"):
            method(workers=0)


def test_defaults_are_those_of_the_filters() -> None:
    found = 0
    for method in meshlab_methods.METHODS:
        for name, parameter in inspect.signature(method).parameters.items():
            shared = {"curvatureweight": defaults.CURVATURE_WEIGHT, "k": defaults.EIGENPAIRS}
            if name in shared:
                assert parameter.default == shared[name]
                found += 1
    assert found == 3
