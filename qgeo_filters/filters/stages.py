"""The one door to what is expensive, for filters, commands and widgets: each computed once for the same content.

``progress`` and ``workers`` pass through and enter no key: results do not depend on them.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import numpy as np

from qgeo_filters._typing import MirrorOption, PartialOption, RepairOption
from qgeo_filters.caching import cache
from qgeo_filters.differential.scalar import BUILT_IN, Scalar
from qgeo_filters.fingerprint import content_key
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.methods import method_named
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.hosts.repair import Repair, needs_repair
from qgeo_filters.hosts.wrap import Wrap, wrap_surface
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.hints import Hints, LabelPair, LandmarkPairs
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.matchable import check_matchable, check_same_size
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.partial.partial_match import matched_as_part, may_be_part
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.search import checked_mirror
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.matching.symmetry_result import Symmetry
from qgeo_filters.parallel import default_workers, worker_count
from qgeo_filters.spectral.distance_spectrum import Landmarks, checked_landmarks, distance_spectrum, is_represented
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.spectral.spectrum import Mass, Spectrum, check_areas, check_count
from qgeo_filters.surface import Surface

Result = TypeVar("Result")

# A method of the caller's own (`register_method`) may be another one in the next process.
PROCESS = uuid.uuid4().hex


def metric_of(surface: Surface, scalar: Scalar, curvature_weight: float, smoothing: float = 0.0) -> LiftedMetric:
    """The lifted metric of a surface, see `lifted_metric`; that of a function is not kept."""
    if callable(scalar):  # two functions cannot be compared by content
        return lifted_metric(surface, scalar, curvature_weight, smoothing=smoothing)
    content: Any = scalar
    if isinstance(scalar, str) and scalar not in BUILT_IN:  # built-in scalars come before attributes of their names
        content = surface.attributes.get(scalar, scalar)
    key = content_key("metric", surface.vertices, surface.faces, content, curvature_weight, smoothing)
    return cache.get(key, lambda: lifted_metric(surface, scalar, curvature_weight, smoothing=smoothing))


def matrix_of(
    metric: LiftedMetric, method: str, accuracy: float, progress: bool = False, workers: int | None = None
) -> np.ndarray:
    """All-pairs distances of a metric, see `distance_matrix`."""
    surface = metric.surface
    key = content_key("matrix", metric.edge_lengths, surface.faces, surface.n_vertices, _known(method), accuracy)
    return _kept(
        key, lambda: distance_matrix(surface, metric, method, accuracy=accuracy, progress=progress), workers=workers
    )


def check_spectrum(surface: Surface, k: int) -> None:
    """Raise what `distance_spectrum` would, before distances are computed."""
    surface.require_connected("the spectrum of the distances")
    check_count(k, surface.n_vertices)
    check_areas(surface.vertex_areas)


def spectrum_of(
    metric: LiftedMetric,
    k: int,
    mass: Mass,
    landmarks: Landmarks,
    method: str,
    accuracy: float,
    progress: bool = False,
    workers: int | None = None,
) -> Spectrum:
    """Eigenspectrum of the all-pairs distances of a metric, see `distance_spectrum`."""
    surface = metric.surface
    check_spectrum(surface, k)
    checked_landmarks(landmarks)

    if landmarks == "auto" and not is_represented(surface, landmarks):
        landmarks = None  # the same spectrum

    def compute() -> Spectrum:
        needed = landmarks is None
        matrix = matrix_of(metric, method, accuracy, progress) if needed else None
        return distance_spectrum(
            surface,
            k,
            metric,
            mass,
            None if needed else landmarks,
            matrix=matrix,
            method=method,
            accuracy=accuracy,
            progress=progress,
        )

    # The vertices enter as well as the lengths: areas and signs are those of the surface.
    shape = surface.vertices, surface.faces, metric.edge_lengths
    return _kept(
        content_key("spectrum", *shape, k, mass, landmarks, _known(method), accuracy), compute, workers=workers
    )


def laplacian_spectrum_of(surface: Surface, k: int) -> Spectrum:
    """Spectrum of the Laplace-Beltrami operator, see `laplacian_spectrum`."""
    key = content_key("laplacian", surface.vertices, surface.faces, k)
    return cache.get(key, lambda: laplacian_spectrum(surface, k))


def wrap_of(surface: Surface) -> Wrap:
    """The closed surface around a mesh, see `wrap_surface`."""
    return cache.get(content_key("wrap", surface.vertices, surface.faces), lambda: wrap_surface(surface))


def prepared_shape_of(
    shape: Surface | Repair, progress: bool = False, workers: int | None = None, repair: RepairOption = "auto"
) -> PreparedShape:
    """The shape prepared for matching, see `PreparedShape`; it shares its distances with the other stages.

    A `Repair` stands as it is, and shares all that is expensive with the surface that it made.
    """
    shape, repair = _mended(shape, repair)
    key = content_key("prepared_shape", *_content(shape), MatchingParameters(), repair)
    matrix = partial(matrix_of, method="graph", accuracy=1e-3, progress=progress)

    def prepared() -> PreparedShape:
        if isinstance(shape, Repair):
            check_matchable(shape.surface, repaired=True)  # which says what there is besides a repair
            return prepared_shape_of(shape.surface, progress, repair=False).standing_for(shape)
        return PreparedShape(shape, parameters=MatchingParameters(), matrix=matrix, repair=repair).prepare()

    return _kept(key, prepared, workers=workers)


def symmetry_of(
    shape: Surface | Repair, progress: bool = False, workers: int | None = None, repair: RepairOption = "auto"
) -> Symmetry:
    """Self-symmetry of a shape, see `self_symmetry`: on the vertices that were given, of a `Repair` too."""
    shape, repair = _mended(shape, repair)
    key = content_key("symmetry", *_content(shape), MatchingParameters(), repair)
    return _kept(key, lambda: self_symmetry(prepared_shape_of(shape, progress, repair=repair)), workers=workers)


def correspondence_of(
    x: Surface | Repair,
    y: Surface | Repair,
    normalize: bool,
    progress: bool = False,
    workers: int | None = None,
    *,
    repair_x: RepairOption = "auto",
    repair_y: RepairOption = "auto",
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    landmarks: LandmarkPairs | None = None,
    labels: LabelPair | None = None,
) -> MatchResult:
    """Correspondence of two shapes, see `match`: on the vertices that were given, of a `Repair` too."""
    (x, repair_x), (y, repair_y) = _mended(x, repair_x), _mended(y, repair_y)
    hints = Hints.of(_given(x), _given(y), landmarks, labels)
    checked_mirror(mirror)
    full_x, full_y = _full(x), _full(y)
    as_part = matched_as_part(full_x, full_y, partial, normalize)
    if partial == "auto" and not as_part and not may_be_part(full_x, full_y):
        partial = False  # the same match
    if not normalize and not as_part:
        check_same_size(full_x, full_y)  # before shapes are prepared

    def prepared(shape: Surface | Repair, repair: RepairOption) -> PreparedShape:
        if as_part:  # which needs no distances between all vertices
            return PreparedShape(shape, parameters=MatchingParameters(), repair=repair)
        return prepared_shape_of(shape, progress, repair=repair)

    def compute() -> MatchResult:
        return match(
            prepared(x, repair_x),
            prepared(y, repair_y),
            normalize=normalize,
            partial=partial,
            mirror=mirror,
            landmarks=hints.landmarks if len(hints.landmarks) else None,
            labels=labels and hints.labels,
        )

    shapes = *_content(x), *_content(y), repair_x, repair_y
    key = content_key(
        "correspondence", *shapes, normalize, partial, mirror, MatchingParameters(), hints.landmarks, *hints.labels
    )
    return _kept(key, compute, workers=workers)


def _mended(shape: Surface | Repair, repair: RepairOption) -> tuple[Surface | Repair, RepairOption]:
    """The shape, as a wrap where one is asked for, and what is still to be repaired.

    One and the same for a surface that "auto" leaves as it is and one that is not to be repaired.
    """
    if isinstance(shape, Repair):
        return shape, False
    if repair == "wrap":
        return wrap_of(shape), False
    return shape, False if repair == "auto" and not needs_repair(shape) else repair


def _given(shape: Surface | Repair) -> Surface:
    return shape.given if isinstance(shape, Repair) else shape


def _full(shape: Surface | Repair) -> Surface:
    return shape.surface if isinstance(shape, Repair) else shape


def _content(shape: Surface | Repair) -> tuple[np.ndarray | float, ...]:
    """What a key knows a shape by."""
    if isinstance(shape, Surface):
        return shape.vertices, shape.faces
    made = shape.surface.vertices, shape.surface.faces, shape.origin, shape.vertex_of_original, shape.wrap_alpha
    return shape.given.vertices, shape.given.faces, *made


def _kept(key: str, compute: Callable[[], Result], workers: int | None) -> Result:
    """Kept result of a key, or the computed one, in so many threads."""
    worker_count(workers)  # refused whether or not there is a result

    def bounded() -> Result:
        with default_workers(workers):
            return compute()

    return cache.get(key, bounded)


def _known(method: str) -> str:
    """What a key knows a method of distances by: its name, and the process for methods that are not the package's."""
    home = getattr(method_named(method), "__module__", None) or ""
    return method if home.partition(".")[0] == __name__.partition(".")[0] else f"{method} of {PROCESS}"
