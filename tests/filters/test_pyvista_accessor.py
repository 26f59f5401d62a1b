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
    offered = set(dir(mesh.qgeo)) - {"apply", "surface"}
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
