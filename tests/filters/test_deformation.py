"""Filters that move a mesh of any host."""

from __future__ import annotations

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import arched, creature

import qgeo_filters as qg
from qgeo_filters.hosts.protocol import load_host

X = qg.Surface(*creature(1.0, 2), {"height": creature(1.0, 2)[0][:, 2]})
POSE = arched(X.vertices, 0.5)
SAME = np.arange(X.n_vertices)
SIDEWAYS = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize("host", ["open3d", "pymeshlab", "pyvista", "trimesh"])
def test_a_mesh_of_any_library_comes_back_in_the_pose_with_its_attributes(host: str) -> None:
    pytest.importorskip(host)
    mesh = load_host(host).make(X)  # type: ignore[attr-defined]
    before = qg.as_surface(mesh).vertices.copy()
    transfer = qg.DeformationTransfer(source=X, poses=[X.vertices, POSE], correspondence=SAME, align=False)
    half = qg.Interpolate(target=X.with_vertices(POSE), t=1.0)
    for step in (transfer, half):
        moved = step(mesh)
        assert type(moved) is type(mesh)
        found = qg.as_surface(moved)
        np.testing.assert_allclose(found.vertices, POSE, atol=1e-4)
        np.testing.assert_allclose(found.attributes["qgeo_displacement"], POSE - X.vertices, atol=1e-4)
        np.testing.assert_allclose(found.attributes["height"], X.attributes["height"], atol=1e-5)
        assert np.array_equal(qg.as_surface(mesh).vertices, before)
    assert len(transfer.transfer_) == 2


def test_steps_after_it_see_the_mesh_where_it_is() -> None:
    done = (qg.Interpolate(target=X.with_vertices(2 * X.vertices), t=1.0) | qg.QuasiGeodesicDistances(sources=[0]))(X)
    alone = qg.QuasiGeodesicDistances(sources=[0])(X)
    np.testing.assert_allclose(
        done.attributes["qgeo_distance"], 2 * alone.attributes["qgeo_distance"], rtol=1e-3, atol=1e-3
    )


def test_any_frame_can_be_asked_for() -> None:
    poses = [X.vertices, POSE]
    for frame, expected in ((0, X.vertices), (1, POSE), (-1, POSE), (-2, X.vertices)):
        step = qg.DeformationTransfer(source=X, poses=poses, correspondence=SAME, align=False, frame=frame)
        np.testing.assert_allclose(step(X).vertices, expected, atol=1e-8)
    with pytest.raises(qg.ParameterError, match="frame must be from -2 to 1, got 2"):
        qg.DeformationTransfer(source=X, poses=poses, correspondence=SAME, frame=2)(X)


@pytest.mark.parametrize(
    ("step", "said"),
    [(qg.DeformationTransfer(), "needs the source and its poses"), (qg.Interpolate(), "needs the other pose")],
)
def test_what_is_missing_is_said(step: qg.Filter, said: str) -> None:
    with pytest.raises(qg.ParameterError, match=said):
        step(X)


def test_a_mesh_that_no_surface_can_hold_is_moved_all_the_same() -> None:
    mesh = np.vstack([X.vertices, [[9.0, 9, 9]]]), np.vstack([X.faces, [[0, 1, 9999]]])
    moved = qg.Interpolate(target=X.with_vertices(POSE), t=1.0)(mesh)
    np.testing.assert_allclose(moved.vertices[:-1], POSE, atol=1e-6)
    assert moved.vertices[-1].tolist() == [9, 9, 9]  # what is gone in the repair stays where it was


@pytest.mark.slow
def test_on_a_wrap_it_moves_what_was_given() -> None:
    """The map is that between wraps; what lies inside comes along, and each filter says what it cannot do there."""
    mesh = qg.Surface(*in_pieces(creature(level=3)))
    pose = arched(mesh.vertices, 0.4) + SIDEWAYS
    other = qg.Surface(*in_pieces((arched(creature(level=3)[0], 0.4) + SIDEWAYS, creature(level=3)[1]), seed=1))
    steps = (
        qg.DeformationTransfer(source=mesh, poses=[pose]),
        qg.Interpolate(target=other, t=1.0),
    )
    unit = np.sqrt(qg.Surface(*creature(level=3)).area)
    moved = []
    for step in steps:
        with pytest.raises(qg.MeshError, match="repair='wrap'"):
            step(mesh)
        moved.append(step(mesh, repair="wrap").vertices)
        off = np.linalg.norm(moved[-1] - pose, axis=1) / unit
        assert off.mean() < 0.03
        assert off[-4:].max() < 0.1
        with pytest.raises(qg.ParameterError, match="call it alone with repair='wrap'"):
            (step | qg.Curvatures())(mesh, repair="wrap")
    function = qg.transfer_deformation(mesh, [pose], mesh, repair="wrap")
    np.testing.assert_allclose(moved[0], function.positions[0], atol=1e-12)
    with pytest.raises(qg.MeshError, match="repair='wrap'"):
        steps[0](mesh)  # as before
