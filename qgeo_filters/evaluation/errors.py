"""Error of a point map against the true one (Princeton protocol), with and without the mirrored truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.pairs import paired_distances
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.parallel import worker_count
from qgeo_filters.validation import checked_indices, frozen

Normalization = Literal["sqrt_area", "diameter", "none"]

#: Errors, in units of sqrt(area), below which the share of points is reported.
THRESHOLDS = (0.05, 0.10, 0.25)
#: Mean error beyond which a map counts as failed.
FAILED = 0.1
#: Largest threshold of the area under the curve of the share of points within an error.
AUC_UP_TO = 0.1


@dataclass(frozen=True)
class ErrorSummary:
    """What a table reports of the errors of one map or of many.

    Attributes
    ----------
    mean, median, maximum : float
    below : tuple of float
        Share of points, 0 to 1, with an error of at most each of `THRESHOLDS`.

    Examples
    --------
    >>> qg.evaluation.ErrorSummary.of([0.0, 0.25, 0.5], thresholds=[0.1, 0.3, 0.6])
    ErrorSummary(mean=0.25, median=0.25, maximum=0.5, below=(0.3333333333333333, 0.6666666666666666, 1.0))
    """

    mean: float
    median: float
    maximum: float
    below: tuple[float, ...]

    @classmethod
    def of(cls, errors: npt.ArrayLike, thresholds: Sequence[float] = THRESHOLDS) -> ErrorSummary:
        """Summary of errors, shape (n,), each point counting equally."""
        values = _checked_errors(errors)
        curve = error_curve(values, thresholds)
        return cls(float(values.mean()), float(np.median(values)), float(values.max()), tuple(curve.tolist()))


@dataclass(frozen=True, eq=False)
class SymmetricErrors:
    """Errors of a map against the truth and against its mirror image.

    Attributes
    ----------
    direct : (n,) float64
        Against the truth: the only one that a method with an orientation should be judged by.
    reflected : (n,) float64
        Against the truth followed by the true left/right map of Y.
    """

    direct: FloatArray
    reflected: FloatArray

    @property
    def mirrored(self) -> bool:
        """Whether the map as a whole is nearer to the mirrored truth."""
        return bool(self.reflected.mean() < self.direct.mean())

    @property
    def best_per_pair(self) -> FloatArray:
        """The better of the two for the map as a whole (n,): forgives a mirrored map."""
        return self.reflected if self.mirrored else self.direct

    @property
    def vertex_minimum(self) -> FloatArray:
        """The smaller of the two at each vertex (n,): forgives maps that mix left and right, and flatters."""
        return np.minimum(self.direct, self.reflected)


def geodesic_error(
    p2p: npt.ArrayLike,
    truth: npt.ArrayLike,
    y: SurfaceLike,
    normalization: Normalization = "sqrt_area",
    *,
    matrix: Any = None,
    workers: int | None = None,
) -> FloatArray:
    """Geodesic distance on Y from the image of each point to its true image, shape (n,).

    Parameters
    ----------
    p2p : array-like of int, shape (n,)
        Vertex of Y for each point.
    truth : array-like of int, shape (n,)
        The true one.
    y : Surface, or whatever `as_surface` takes
    normalization : {"sqrt_area", "diameter", "none"}
        Divide by the square root of Y's area (the Princeton protocol), by Y's geodesic diameter (about 1.5 times as
        large, so that errors look smaller; it takes all distances), or not at all. Never mix them in one table.
    matrix : array-like, shape (n_Y, n_Y), optional
        Distances on Y in the unit of its vertices, where they are at hand.
    workers : int, optional
        Threads for distances that are not; all cores by default. The errors do not depend on it.

    Raises
    ------
    ParameterError
        Lengths that differ, vertices out of range, unknown normalization.

    References
    ----------
    Kim, Lipman, Funkhouser, "Blended intrinsic maps", SIGGRAPH 2011, for the protocol.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> found = np.arange(162)
    >>> found[3] = int(x.faces[(x.faces == 3).any(axis=1)][0].max())  # at a neighbour instead
    >>> error = qg.evaluation.geodesic_error(found, np.arange(162), x)
    >>> int((error > 0).sum()), bool(error[3] < 0.3)  # in sqrt(area)
    (1, True)
    """
    threads = worker_count(workers)  # refused whether or not it is needed
    y = as_surface(y)
    image, target = checked_indices(p2p, y.n_vertices, "p2p"), checked_indices(truth, y.n_vertices, "truth")
    if image.shape != target.shape:
        raise ParameterError(f"p2p and truth must be of one length, got {len(image)} and {len(target)}")
    if normalization not in ("sqrt_area", "diameter", "none"):
        raise ParameterError(f"normalization must be 'sqrt_area', 'diameter' or 'none', got {normalization!r}")
    if matrix is None and normalization == "diameter":
        matrix = distance_matrix(y, workers=threads)
    if matrix is None:
        errors = paired_distances(y, image, target, workers=threads)
    else:
        if np.shape(matrix) != (y.n_vertices, y.n_vertices):
            raise ParameterError(f"the matrix has shape {np.shape(matrix)}, expected {(y.n_vertices, y.n_vertices)}")
        errors = np.asarray(matrix[image, target], dtype=np.float64)
    if normalization == "sqrt_area":
        return errors / np.sqrt(y.area)
    return errors / float(np.max(matrix)) if normalization == "diameter" else errors


def symmetric_errors(
    p2p: npt.ArrayLike,
    truth: npt.ArrayLike,
    symmetry: npt.ArrayLike,
    y: SurfaceLike,
    *,
    matrix: Any = None,
    workers: int | None = None,
) -> SymmetricErrors:
    """Errors against the truth and against the mirrored truth, in units of sqrt(area).

    Parameters
    ----------
    p2p, truth : array-like of int, shape (n,)
        As in `geodesic_error`.
    symmetry : array-like of int, shape (n_Y,)
        True left/right map of Y.
    y : Surface, or whatever `as_surface` takes
    matrix, workers
        As in `geodesic_error`.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> mirror = np.arange(162)[::-1]  # any map will do here
    >>> errors = qg.evaluation.symmetric_errors(mirror, np.arange(162), mirror, x)
    >>> errors.mirrored, float(errors.best_per_pair.max())
    (True, 0.0)
    """
    y = as_surface(y)
    mirror = checked_indices(symmetry, y.n_vertices, "symmetry")
    if len(mirror) != y.n_vertices:
        raise ParameterError(f"symmetry must hold a vertex for each of the {y.n_vertices} of Y, got {len(mirror)}")
    target = checked_indices(truth, y.n_vertices, "truth")
    direct = geodesic_error(p2p, target, y, matrix=matrix, workers=workers)
    reflected = geodesic_error(p2p, mirror[target], y, matrix=matrix, workers=workers)
    return SymmetricErrors(frozen(direct), frozen(reflected))


def mirrored(
    p2p: npt.ArrayLike,
    truth: npt.ArrayLike,
    symmetry: npt.ArrayLike,
    y: SurfaceLike,
    *,
    matrix: Any = None,
    workers: int | None = None,
) -> bool:
    """Whether a map is nearer, in the mean, to the mirrored truth than to the truth; see `symmetric_errors`.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> mirror = np.arange(162)[::-1]  # any map will do here
    >>> qg.evaluation.mirrored(mirror, np.arange(162), mirror, x)
    True
    """
    return symmetric_errors(p2p, truth, symmetry, y, matrix=matrix, workers=workers).mirrored


def error_curve(errors: npt.ArrayLike, thresholds: npt.ArrayLike) -> FloatArray:
    """Share of points, 0 to 1, with an error of at most each threshold; the shape of ``thresholds``.

    Examples
    --------
    >>> qg.evaluation.error_curve([0.0, 0.1, 0.2, 0.4], [0.05, 0.2])
    array([0.25, 0.75])
    """
    values = np.sort(_checked_errors(errors))
    return np.searchsorted(values, np.asarray(thresholds, dtype=np.float64), side="right") / len(values)


def area_under_curve(errors: npt.ArrayLike, largest: float = AUC_UP_TO) -> float:
    """Mean of the share of points within a threshold, over all thresholds from 0 to the largest: 1 for no error.

    Examples
    --------
    >>> round(qg.evaluation.area_under_curve([0.0, 0.1], largest=0.2), 6)
    0.75
    """
    return float(np.maximum(0.0, 1.0 - _checked_errors(errors) / largest).mean())


def _checked_errors(errors: npt.ArrayLike) -> FloatArray:
    values = np.asarray(errors, dtype=np.float64)
    if values.ndim != 1 or not values.size:
        raise ParameterError(f"errors must be a non-empty array in one dimension, got the shape {values.shape}")
    bad = np.flatnonzero(np.isnan(values) | (values < 0))
    if bad.size:
        raise ParameterError(f"errors[{bad[0]}] is {values[bad[0]]}, not a distance ({bad.size} such)")
    return values
