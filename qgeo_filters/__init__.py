"""Curvature-guided quasi-geodesics, their spectrum, self-symmetry and correspondence for triangle meshes.

``import qgeo_filters as qg``. Every public name is loaded on first use, so that the import itself is quick
and needs no optional package.
"""

from __future__ import annotations

import importlib
import logging
import sys
import warnings
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the same names for type checkers and IDEs, which run nothing
    from . import evaluation as evaluation
    from . import testing as testing
    from .animation.interpolate import interpolate as interpolate
    from .animation.pose_transfer import Transfer as Transfer
    from .animation.sequence import Animation as Animation
    from .animation.transfer import transfer_deformation as transfer_deformation
    from .animation.transfer import transfer_pose as transfer_pose
    from .animation.transfer import transferred_poses as transferred_poses
    from .barycentric import BarycentricMap as BarycentricMap
    from .caching import cache as cache
    from .collection.collection import Collection as Collection
    from .collection.remesh import remesh_like as remesh_like
    from .compilation import warmup as warmup
    from .differential.coordinates import differential_coordinates as differential_coordinates
    from .differential.curvature import PrincipalCurvatures as PrincipalCurvatures
    from .differential.curvature import principal_curvatures as principal_curvatures
    from .differential.normals import vertex_normals as vertex_normals
    from .differential.scalar import surface_scalar as surface_scalar
    from .errors import DisconnectedError as DisconnectedError
    from .errors import MeshError as MeshError
    from .errors import MissingPackageError as MissingPackageError
    from .errors import NonManifoldError as NonManifoldError
    from .errors import ParameterError as ParameterError
    from .errors import QgeoError as QgeoError
    from .errors import TooLargeError as TooLargeError
    from .errors import WorkersLostError as WorkersLostError
    from .filters.appearance import Paint as Paint
    from .filters.base import Filter as Filter
    from .filters.base import Pipeline as Pipeline
    from .filters.deformation import DeformationTransfer as DeformationTransfer
    from .filters.deformation import Interpolate as Interpolate
    from .filters.differential import CorrectedNormals as CorrectedNormals
    from .filters.differential import Curvatures as Curvatures
    from .filters.differential import DifferentialCoordinates as DifferentialCoordinates
    from .filters.differential import SurfaceScalar as SurfaceScalar
    from .filters.geodesics import QuasiGeodesicDistances as QuasiGeodesicDistances
    from .filters.geodesics import QuasiGeodesicPath as QuasiGeodesicPath
    from .filters.matching import Correspondence as Correspondence
    from .filters.matching import SelfSymmetry as SelfSymmetry
    from .filters.meshlab_methods import register_pymeshlab as register_pymeshlab
    from .filters.registry import registered as registered
    from .filters.spectral import LaplacianSpectrum as LaplacianSpectrum
    from .filters.spectral import QuasiGeodesicSpectrum as QuasiGeodesicSpectrum
    from .filters.transfer import TransferAttributes as TransferAttributes
    from .geodesics.distance_solver import DistanceSolver as DistanceSolver
    from .geodesics.matrix import distance_matrix as distance_matrix
    from .geodesics.matrix import distances as distances
    from .geodesics.methods import register_method as register_method
    from .geodesics.metric import LiftedMetric as LiftedMetric
    from .geodesics.metric import lifted_metric as lifted_metric
    from .geodesics.operator import DistanceOperator as DistanceOperator
    from .geodesics.path.geodesic_path import GeodesicPath as GeodesicPath
    from .geodesics.path.paths import quasi_geodesic as quasi_geodesic
    from .geodesics.path.paths import quasi_geodesics as quasi_geodesics
    from .geodesics.solver import GeodesicSolver as GeodesicSolver
    from .hosts.dispatch import as_surface as as_surface
    from .hosts.lines import polylines as polylines
    from .hosts.protocol import Host as Host
    from .hosts.protocol import register_host as register_host
    from .hosts.repair import Repair as Repair
    from .hosts.repair import repair_surface as repair_surface
    from .hosts.wrap import Wrap as Wrap
    from .hosts.wrap import wrap_surface as wrap_surface
    from .io.landmark_files import read_landmarks as read_landmarks
    from .io.landmark_files import write_landmarks as write_landmarks
    from .io.landmarks import Landmarks as Landmarks
    from .matching.compatibility import Compatibility as Compatibility
    from .matching.compatibility import compatibility as compatibility
    from .matching.correspondence import match as match
    from .matching.maps.barycentric import barycentric_map as barycentric_map
    from .matching.match_log import MatchLog as MatchLog
    from .matching.match_result import MatchResult as MatchResult
    from .matching.parameters import MatchingParameters as MatchingParameters
    from .matching.pieces import PiecewiseMatch as PiecewiseMatch
    from .matching.pieces import match_pieces as match_pieces
    from .matching.prepared_shape import PreparedShape as PreparedShape
    from .matching.symmetry import self_symmetry as self_symmetry
    from .matching.symmetry_result import Symmetry as Symmetry
    from .report.animation_file import write_animation as write_animation
    from .spectral.block_krylov import streamed_spectrum as streamed_spectrum
    from .spectral.commutative import CommutativeSpectra as CommutativeSpectra
    from .spectral.commutative import commutative_eigenspectra as commutative_eigenspectra
    from .spectral.commutative import commutator_norm as commutator_norm
    from .spectral.commutative import joint_diagonalizer as joint_diagonalizer
    from .spectral.distance_spectrum import distance_spectrum as distance_spectrum
    from .spectral.landmarks import landmark_spectrum as landmark_spectrum
    from .spectral.laplacian import laplacian_spectrum as laplacian_spectrum
    from .spectral.proxy_spectrum import proxy_spectrum as proxy_spectrum
    from .spectral.spectrum import Spectrum as Spectrum
    from .surface import Surface as Surface

__version__ = "0.1.0"

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent until the user asks for it

_HOME = {
    "Surface": "surface",
    "LiftedMetric": "geodesics.metric",
    "QgeoError": "errors",
    "ParameterError": "errors",
    "MeshError": "errors",
    "NonManifoldError": "errors",
    "DisconnectedError": "errors",
    "MissingPackageError": "errors",
    "TooLargeError": "errors",
    "WorkersLostError": "errors",
    "as_surface": "hosts.dispatch",
    "repair_surface": "hosts.repair",
    "Repair": "hosts.repair",
    "wrap_surface": "hosts.wrap",
    "Wrap": "hosts.wrap",
    "polylines": "hosts.lines",
    "register_host": "hosts.protocol",
    "Host": "hosts.protocol",
    "cache": "caching",
    "Landmarks": "io.landmarks",
    "read_landmarks": "io.landmark_files",
    "write_landmarks": "io.landmark_files",
    # functions on a surface, and what they return
    "differential_coordinates": "differential.coordinates",
    "vertex_normals": "differential.normals",
    "surface_scalar": "differential.scalar",
    "principal_curvatures": "differential.curvature",
    "PrincipalCurvatures": "differential.curvature",
    "lifted_metric": "geodesics.metric",
    "GeodesicSolver": "geodesics.solver",
    "register_method": "geodesics.methods",
    "DistanceSolver": "geodesics.distance_solver",
    "distances": "geodesics.matrix",
    "distance_matrix": "geodesics.matrix",
    "quasi_geodesic": "geodesics.path.paths",
    "quasi_geodesics": "geodesics.path.paths",
    "GeodesicPath": "geodesics.path.geodesic_path",
    "DistanceOperator": "geodesics.operator",
    "distance_spectrum": "spectral.distance_spectrum",
    "landmark_spectrum": "spectral.landmarks",
    "streamed_spectrum": "spectral.block_krylov",
    "proxy_spectrum": "spectral.proxy_spectrum",
    "laplacian_spectrum": "spectral.laplacian",
    "Spectrum": "spectral.spectrum",
    "self_symmetry": "matching.symmetry",
    "Symmetry": "matching.symmetry_result",
    "match": "matching.correspondence",
    "MatchResult": "matching.match_result",
    "match_pieces": "matching.pieces",
    "PiecewiseMatch": "matching.pieces",
    "MatchLog": "matching.match_log",
    "MatchingParameters": "matching.parameters",
    "PreparedShape": "matching.prepared_shape",
    "barycentric_map": "matching.maps.barycentric",
    "BarycentricMap": "barycentric",
    "commutative_eigenspectra": "spectral.commutative",
    "CommutativeSpectra": "spectral.commutative",
    "commutator_norm": "spectral.commutative",
    "joint_diagonalizer": "spectral.commutative",
    "compatibility": "matching.compatibility",
    "Compatibility": "matching.compatibility",
    "transfer_deformation": "animation.transfer",
    "transferred_poses": "animation.transfer",
    "transfer_pose": "animation.transfer",
    "Transfer": "animation.pose_transfer",
    "interpolate": "animation.interpolate",
    "Animation": "animation.sequence",
    "write_animation": "report.animation_file",
    "Collection": "collection.collection",
    "remesh_like": "collection.remesh",
    "warmup": "compilation",
    # filters
    "Filter": "filters.base",
    "registered": "filters.registry",
    "Pipeline": "filters.base",
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
    "DeformationTransfer": "filters.deformation",
    "Interpolate": "filters.deformation",
    "register_pymeshlab": "filters.meshlab_methods",
}
_MODULES = ("testing", "evaluation")
_RENAMED = {"Descriptor": "PreparedShape"}  # old names, for one more release

__all__ = [*_HOME, *_MODULES, "__version__"]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = importlib.import_module(f"{__name__}.{name}")
    elif name in _RENAMED:
        new = _RENAMED[name]
        message = f"{__name__}.{name} is now called {new}; the old name goes with the next release"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return getattr(sys.modules[__name__], new)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
