"""Filters and pipelines as scikit-learn's: parameters of steps, clones, steps of its own pipelines, nesting."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.testing import check_filter, sample_surface

SURFACE = sample_surface()


def inner() -> qg.Pipeline:
    return qg.SurfaceScalar() | qg.QuasiGeodesicDistances(sources=[3])


def nested() -> qg.Pipeline:
    return qg.Pipeline([inner(), qg.Curvatures()])


def flat() -> qg.Pipeline:
    return inner() | qg.Curvatures()


def test_a_pipeline_in_a_pipeline_is_its_steps() -> None:
    assert check_filter(nested()) is None
    together, alone = nested()(SURFACE), flat()(SURFACE)
    assert set(together.attributes) == set(alone.attributes)
    for name, values in alone.attributes.items():
        np.testing.assert_array_equal(together.attributes[name], values)
    assert nested().to_yaml() == flat().to_yaml()
    assert isinstance(nested()["SurfaceScalar"], qg.SurfaceScalar)
    assert [type(step) for step in (nested() | qg.Paint()).steps] == [type(s) for s in (flat() | qg.Paint()).steps]
    with pytest.raises(KeyError, match="no step 'Paint'; the steps are SurfaceScalar, QuasiGeodesicDistances, Curv"):
        nested()["Paint"]


def test_vertices_of_a_step_within_are_those_of_the_repaired_mesh() -> None:
    """A vertex that no face has stands first, so that all others are numbered anew by the repair."""
    loose = np.vstack([[9.0, 9, 9], SURFACE.vertices]), SURFACE.faces + 1
    doubled = loose[0], np.vstack([loose[1], loose[1][:1]])  # a face twice: must be repaired
    filters = qg.Pipeline([qg.Pipeline([qg.QuasiGeodesicDistances(sources=18)])])
    out = filters(doubled, repair=True).attributes["qgeo_distance"]
    expected = qg.QuasiGeodesicDistances(sources=17)(SURFACE).attributes["qgeo_distance"]
    np.testing.assert_allclose(out[1:], expected, rtol=1e-12)
    assert filters[0][0].sources == 18


def test_parameters_of_steps_have_their_names_before_them() -> None:
    pipe = nested()
    params = pipe.get_params()
    assert params["steps"] is pipe.steps
    assert params["Curvatures"] is pipe.steps[1]
    assert params["Pipeline__SurfaceScalar__smoothing"] == 0.0
    assert set(pipe.get_params(deep=False)) == {"steps"}
    assert pipe.set_params(Pipeline__SurfaceScalar__smoothing=0.1, Curvatures__radius=3) is pipe
    assert pipe["SurfaceScalar"].smoothing == 0.1
    assert pipe["Curvatures"].radius == 3
    pipe.set_params(Curvatures=qg.CorrectedNormals())
    assert [type(step).__name__ for step in pipe.steps] == ["Pipeline", "CorrectedNormals"]


def test_steps_of_one_class_are_numbered() -> None:
    pipe = qg.Paint(component=0) | qg.Curvatures() | qg.Paint(component=1)
    assert list(pipe.named_steps) == ["Paint-1", "Curvatures", "Paint-2"]
    pipe.set_params(**{"Paint-2__component": 2})
    assert [step.get_params().get("component") for step in pipe.steps] == [0, None, 2]


def test_what_there_is_not_is_named() -> None:
    with pytest.raises(qg.ParameterError, match="Pipeline has no step 'Paint'; it has Pipeline, Curvatures"):
        nested().set_params(Paint__component=1)
    with pytest.raises(qg.ParameterError, match="Pipeline has no step 'radius'; it has Pipeline, Curvatures"):
        nested().set_params(radius=1)
    with pytest.raises(qg.ParameterError, match="Curvatures has no parameter 'size'; it has radius"):
        nested().set_params(Curvatures__size=1)


def test_copies_share_no_step() -> None:
    clone = pytest.importorskip("sklearn.base").clone
    pipe = nested()
    for other in (pipe.clone(), clone(pipe), copy.deepcopy(pipe), pickle.loads(pickle.dumps(pipe))):
        assert repr(other) == repr(pipe)
        other.set_params(Pipeline__SurfaceScalar__smoothing=0.5)
        assert pipe["SurfaceScalar"].smoothing == 0.0


def test_steps_of_scikit_learn() -> None:
    pipeline = pytest.importorskip("sklearn.pipeline")
    preprocessing = pytest.importorskip("sklearn.preprocessing")
    other = SURFACE.with_vertices(2 * SURFACE.vertices)
    table = preprocessing.FunctionTransformer(
        lambda meshes: np.array([np.abs(mesh.attributes["qgeo_k1"]).mean() for mesh in meshes])[:, None]
    )
    steps = pipeline.make_pipeline(nested(), table, preprocessing.StandardScaler(with_std=False))
    steps.set_params(pipeline__Curvatures__radius=3)
    found = steps.fit_transform([SURFACE, other])
    means = [np.abs(qg.Curvatures(radius=3)(mesh).attributes["qgeo_k1"]).mean() for mesh in (SURFACE, other)]
    np.testing.assert_allclose(found[:, 0], np.array(means) - np.mean(means))
    np.testing.assert_array_equal(steps.transform([other]), found[1:])
    alone = pipeline.make_pipeline(qg.SurfaceScalar())
    (mesh,) = alone.fit_transform([SURFACE])
    np.testing.assert_array_equal(mesh.attributes["qgeo_scalar"], qg.surface_scalar(SURFACE))
    assert alone.transform([SURFACE])[0].attributes.keys() == mesh.attributes.keys()
    assert "SurfaceScalar" in repr(alone)


def test_transform_keeps_kinds_and_wants_a_list() -> None:
    trimesh = pytest.importorskip("trimesh")
    sphere = trimesh.creation.icosphere(1)
    first, second = qg.DifferentialCoordinates().transform([sphere, (SURFACE.vertices, SURFACE.faces)])
    assert isinstance(first, trimesh.Trimesh)
    assert isinstance(second, qg.Surface)
    for single in (SURFACE, sphere, (SURFACE.vertices, SURFACE.faces), "a.ply"):
        with pytest.raises(qg.ParameterError, match="put a single one into a list"):
            qg.DifferentialCoordinates().transform(single)
