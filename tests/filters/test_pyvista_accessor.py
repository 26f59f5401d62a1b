"""``mesh.qgeo``: what it offers comes from the registry, and calls are those of the filters."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.filters import registry
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.testing import sample_surface

pyvista = pytest.importorskip("pyvista", minversion="0.48")


@pytest.fixture
def mesh() -> object:
    import qgeo_filters.filters.pyvista_accessor  # noqa: F401

    surface = sample_surface()
    return pyvista.PolyData.from_regular_faces(np.array(surface.vertices), np.array(surface.faces))


def test_all_registered_filters_are_offered_and_no_more(mesh: pyvista.PolyData) -> None:
    offered = set(dir(mesh.qgeo)) - {"apply", "surface", "match", "symmetry", "path", "distances"}
    assert {name.replace("_", "") for name in offered} == {name.lower() for name in registry.registered_filters()}
    assert all(callable(getattr(mesh.qgeo, name)) for name in offered)


def test_a_filter_of_ones_own_is_offered_too(mesh: pyvista.PolyData, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "REGISTRY", dict(registry.REGISTRY))

    @qg.registered
    class VertexHeight(qg.Filter):
        """Height of each vertex."""

        outputs = {"height": "(n,), length: third coordinate"}

        def compute(self, surface: qg.Surface, progress: bool = False) -> dict[str, np.ndarray]:
            return {"height": surface.vertices[:, 2]}

    assert np.array_equal(mesh.qgeo.vertex_height().point_data["height"], as_surface(mesh).vertices[:, 2])
    assert mesh.qgeo.vertex_height.__doc__ == "Height of each vertex."


def test_workers_reach_the_filter(mesh: pyvista.PolyData) -> None:
    one, two = (mesh.qgeo.quasi_geodesic_distances(sources=[1, 2], workers=workers) for workers in (1, 2))
    assert np.array_equal(one.point_data["qgeo_distance"], two.point_data["qgeo_distance"])
    for call in (mesh.qgeo.curvatures, lambda workers: mesh.qgeo.apply(qg.Curvatures(), workers=workers)):
        with pytest.raises(qg.ParameterError, match="workers"):
            call(workers=0)


def test_a_map_to_another_mesh_and_the_symmetry(mesh: pyvista.PolyData) -> None:
    other = mesh.scale(2.0).translate([5, 0, 0])
    found = mesh.qgeo.match(other)
    assert isinstance(found, qg.MatchResult)
    assert np.array_equal(found.p2p, np.arange(mesh.n_points))
    found, log = mesh.qgeo.match(other, log=True, landmarks=[(3, 3)])
    assert isinstance(log, qg.MatchLog)
    assert mesh.qgeo.symmetry().reason == qg.self_symmetry(mesh).reason


def test_a_path_is_a_polyline_that_says_how_long_it_is(mesh: pyvista.PolyData) -> None:
    path = qg.quasi_geodesic(mesh, 3, 80, qg.lifted_metric(mesh))
    line = mesh.qgeo.path(3, 80, qg.lifted_metric(mesh))
    assert line.n_lines == 1
    assert np.array_equal(line.points, path.points)
    assert line.field_data["qgeo_length"][0] == path.length
    assert line.field_data["qgeo_converged"][0] == 1
    assert line.point_data["qgeo_arc_length"][-1] == pytest.approx(line.compute_arc_length()["arc_length"][-1])
    assert np.array_equal(line.point_data["qgeo_geodesic_curvature"], [0, *path.kappa_g, 0])


def test_a_picked_point_stands_for_its_vertex(mesh: pyvista.PolyData) -> None:
    picked = tuple(1.01 * mesh.points[80])
    assert np.array_equal(mesh.qgeo.path(3, picked).points, mesh.qgeo.path(3, 80).points)
    with pytest.raises(qg.ParameterError, match=r"j must be a vertex or a point with three finite .*, got \(1, 2\)"):
        mesh.qgeo.path(3, (1, 2))
    assert np.array_equal(mesh.qgeo.distances([3, 80]), qg.distances(mesh, [3, 80]))


def test_an_unknown_name_lists_all_there_are(mesh: pyvista.PolyData) -> None:
    with pytest.raises(AttributeError, match=r"no filter 'geodesic'; it has apply, .*match.*path.*self_symmetry"):
        mesh.qgeo.geodesic  # noqa: B018
