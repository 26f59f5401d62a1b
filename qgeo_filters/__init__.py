"""Curvature-guided quasi-geodesics, their spectrum, self-symmetry and correspondence for triangle meshes.

``import qgeo_filters as qg``. Every public name is loaded on first use, so that the import itself is quick
and needs no optional package.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Surface": "surface",
    "LiftedMetric": "geodesics.metric",
    "MeshError": "errors",
    "NonManifoldError": "errors",
    "DisconnectedError": "errors",
    "MissingPackageError": "errors",
    "as_surface": "hosts.dispatch",
    "repair_surface": "hosts.repair",
    "cache": "caching",
    # functions on a surface
    "differential_coordinates": "differential.coordinates",
    "vertex_normals": "differential.normals",
    "surface_scalar": "differential.scalar",
    "principal_curvatures": "differential.curvature",
    "lifted_metric": "geodesics.lifting",
    "distances": "geodesics.matrix",
    "distance_matrix": "geodesics.matrix",
    "quasi_geodesic": "geodesics.path.paths",
    "quasi_geodesics": "geodesics.path.paths",
    "GeodesicPath": "geodesics.path.paths",
    "DistanceOperator": "geodesics.operator",
    "distance_spectrum": "spectral.distance_spectrum",
    "landmark_spectrum": "spectral.landmarks",
    "streamed_spectrum": "spectral.block_krylov",
    "laplacian_spectrum": "spectral.laplacian",
    "Spectrum": "spectral.distance_spectrum",
    "self_symmetry": "matching.symmetry",
    "match": "matching.correspondence",
    "MatchResult": "matching.correspondence",
    "PreparedShape": "matching.prepared_shape",
    "barycentric_map": "matching.maps.barycentric",
    "commutative_eigenspectra": "spectral.commutative",
    "commutator_norm": "spectral.commutative",
    "joint_diagonalizer": "spectral.commutative",
    "compatibility": "matching.compatibility",
    "warmup": "geodesics.warmup",
    # filters
    "Filter": "filters.base",
    "registered": "filters.base",
    "Pipeline": "filters.pipeline",
    "DifferentialCoordinates": "filters.differential",
    "CorrectedNormals": "filters.differential",
    "SurfaceScalar": "filters.differential",
    "Curvatures": "filters.differential",
    "QuasiGeodesicDistances": "filters.geodesics",
    "QuasiGeodesicPath": "filters.geodesics",
    "QuasiGeodesicSpectrum": "filters.spectral",
    "LaplacianSpectrum": "filters.spectral",
    "SelfSymmetry": "filters.matching",
    "Correspondence": "filters.matching",
    "Paint": "filters.appearance",
    "TransferAttributes": "filters.transfer",
    "register_pymeshlab": "filters.meshlab_methods",
}
_MODULES = ("testing", "evaluation")

__all__ = [*_HOME, *_MODULES, "__version__"]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = importlib.import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
