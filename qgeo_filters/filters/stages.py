"""Expensive stages that several filters share, each computed once for the same content."""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

import numpy as np

from qgeo_filters.caching import cache
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.fingerprint import content_key
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.matching.correspondence import MatchResult, match
from qgeo_filters.matching.prepared_shape import METRIC_WEIGHTS, PreparedShape, check_same_size
from qgeo_filters.matching.symmetry import Symmetry, self_symmetry
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, check_areas, check_count
from qgeo_filters.surface import Surface


def metric_of(surface: Surface, scalar: Scalar, weight: float, smoothing: float = 0.0) -> LiftedMetric:
    """The lifted metric of a surface, see `lifted_metric`."""
    content: Any = surface.attributes.get(scalar, scalar) if isinstance(scalar, str) else scalar
    if callable(content):  # two functions cannot be compared by content
        return lifted_metric(surface, content, weight, smoothing=smoothing)
    key = content_key("metric", surface.vertices, surface.faces, content, weight, smoothing)
    return cache.get(key, lambda: lifted_metric(surface, scalar, weight, smoothing=smoothing))


def matrix_of(metric: LiftedMetric, method: str, accuracy: float, progress: bool = False) -> np.ndarray:
    """All-pairs distances of a metric, see `distance_matrix`."""
    key = content_key("matrix", metric.edge_lengths, metric.surface.faces, metric.surface.n_vertices, method, accuracy)
    return cache.get(key, lambda: distance_matrix(metric.surface, metric, method, accuracy=accuracy, progress=progress))


def check_spectrum(surface: Surface, k: int) -> None:
    """Raise what `distance_spectrum` would, before distances are computed."""
    surface.require_connected("the spectrum of the distances")
    check_count(k, surface.n_vertices)
    check_areas(surface.vertex_areas)


def spectrum_of(
    metric: LiftedMetric,
    k: int,
    weights: Literal["area", "uniform"],
    landmarks: int | None,
    method: str,
    accuracy: float,
    progress: bool = False,
) -> Spectrum:
    """Eigenspectrum of the all-pairs distances of a metric, see `distance_spectrum`."""
    surface = metric.surface
    check_spectrum(surface, k)

    def compute() -> Spectrum:
        matrix = None if landmarks else matrix_of(metric, method, accuracy, progress)
        return distance_spectrum(
            surface,
            k,
            metric,
            weights,
            landmarks,
            matrix=matrix,
            method=method,
            accuracy=accuracy,
            progress=progress,
        )

    # The vertices enter as well as the lengths: areas and signs are those of the surface.
    key = content_key(
        "spectrum", surface.vertices, surface.faces, metric.edge_lengths, k, weights, landmarks, method, accuracy
    )
    return cache.get(key, compute)


def prepared_shape_of(surface: Surface, progress: bool = False) -> PreparedShape:
    """The surface prepared for matching, see `PreparedShape`; it shares its distances with the other stages."""
    # The weights enter these keys: a cache on disk outlives the version that filled it.
    key = content_key("descriptor", surface.vertices, surface.faces, METRIC_WEIGHTS)
    matrix = partial(matrix_of, method="graph", accuracy=1e-3, progress=progress)
    return cache.get(key, lambda: PreparedShape(surface, weights=METRIC_WEIGHTS, matrix=matrix).prepared())


def symmetry_of(surface: Surface, progress: bool = False) -> Symmetry:
    """Self-symmetry of a surface, see `self_symmetry`."""
    key = content_key("symmetry", surface.vertices, surface.faces, METRIC_WEIGHTS)
    return cache.get(key, lambda: self_symmetry(prepared_shape_of(surface, progress)))


def correspondence_of(x: Surface, y: Surface, normalize: bool, progress: bool = False) -> MatchResult:
    """Correspondence of two surfaces, see `match`."""
    if not normalize:
        check_same_size(x, y)  # before descriptors are made
    key = content_key("correspondence", x.vertices, x.faces, y.vertices, y.faces, normalize, METRIC_WEIGHTS)
    return cache.get(
        key, lambda: match(prepared_shape_of(x, progress), prepared_shape_of(y, progress), normalize=normalize)
    )
