"""What a user knows of the map that is sought: points that belong together, and parts of one name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import ParameterError
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen, listed

#: Points that belong together: pairs (vertex of X, vertex of Y), two arrays of points, or two sets of equal names.
LandmarkPairs = (
    npt.ArrayLike | tuple[npt.ArrayLike, npt.ArrayLike] | Sequence[tuple[int, int]] | tuple[Landmarks, Landmarks]
)
#: Number of the part that each vertex belongs to, of X and of Y; negative where that is not known.
LabelPair = tuple[npt.ArrayLike, npt.ArrayLike]

#: Points farther from the surface than this are no points of it, in sqrt(area) of the surface.
NEAR_THE_SURFACE = 0.05


@dataclass(frozen=True, eq=False)
class Hints:
    """Landmarks and labels, checked, in vertices of the surfaces that were given.

    Attributes
    ----------
    landmarks : (k, 2) int64
        Vertex of X and vertex of Y that belong together, to within a few edges.
    labels : (n_x,) and (n_y,) int64
        Number of the part of each vertex, negative where it is not known; empty if no labels were given.
    """

    landmarks: IndexArray
    labels: tuple[IndexArray, IndexArray]

    @classmethod
    def of(
        cls, x: Surface, y: Surface, landmarks: LandmarkPairs | None = None, labels: LabelPair | None = None
    ) -> Hints:
        """What is known, checked.

        Parameters
        ----------
        x, y : Surface
        landmarks : sequence of (int, int), pair of (k, 3) arrays, or pair of Landmarks, optional
            Vertices of X and Y; or points of X and Y, each of which stands for the nearest vertex; or two `Landmarks`,
            of which those of equal names belong together.
        labels : pair of array-like of int, shapes (n_x,) and (n_y,), optional
            Vertices of equal number lie in the same part; negative where that is not known.

        Raises
        ------
        ParameterError
            No landmarks, no pairs, a vertex that is not there, a point that is not on the surface, one vertex with two
            partners; labels of another length, or without a number that both shapes have.
        """
        if landmarks is None:
            pairs = np.zeros((0, 2), dtype=np.int64)
        else:
            pairs = _without_repetitions(vertex_pairs(landmarks, x, y))
        numbers = (np.zeros(0, dtype=np.int64),) * 2 if labels is None else _checked_labels(labels, x, y)
        return cls(frozen(pairs), (frozen(numbers[0]), frozen(numbers[1])))

    def __bool__(self) -> bool:
        return bool(len(self.landmarks) or len(self.labels[0]))

    def __repr__(self) -> str:
        return f"Hints({len(self.landmarks)} landmarks, {len(self.common_labels)} labels)"

    @property
    def common_labels(self) -> IndexArray:
        """Numbers of the parts that both shapes have, increasing."""
        common = np.intersect1d(*self.labels)
        return common[common >= 0]


def vertex_pairs(landmarks: LandmarkPairs, x: Surface, y: Surface) -> IndexArray:
    """Vertices (k, 2) of landmarks of any form."""
    if isinstance(landmarks, (tuple, list)) and len(landmarks) == 2:
        one, other = landmarks
        if isinstance(one, Landmarks) and isinstance(other, Landmarks):
            return _of_equal_names(one, other, x, y)
    points = _as_points(landmarks)
    if points is None:
        return _checked_pairs(landmarks, x, y)
    return np.column_stack([_nearest_vertices("X", x, points[0]), _nearest_vertices("Y", y, points[1])])


def _of_equal_names(one: Landmarks, other: Landmarks, x: Surface, y: Surface) -> IndexArray:
    """Vertices (k, 2) of the landmarks whose names both sets have, known in both."""
    known = [[name for name, there in zip(s.names, s.is_known, strict=True) if there] for s in (one, other)]
    common = [name for name in known[0] if name in known[1]]
    for side, names in zip("XY", known, strict=True):
        repeated = [name for name in common if names.count(name) > 1]
        if repeated:
            raise ParameterError(f"two landmarks of {side} are called {repeated[0]!r}: which belongs to which?")
    if not common:
        raise ParameterError(
            f"no landmark of X has the name of one of Y: those of X are {', '.join(known[0][:5]) or 'none'}, those of "
            f"Y {', '.join(known[1][:5]) or 'none'}"
        )
    columns = []
    for side, shape, some in (("X", x, one), ("Y", y, other)):
        places = [some.names.index(name) for name in common]
        vertices = some.vertices[places].copy()
        open_ = vertices < 0
        if open_.any():
            vertices[open_] = _nearest_vertices(side, shape, some.points[places][open_])
        columns.append(vertices)
    return _checked_pairs(np.column_stack(columns), x, y)


def _as_points(landmarks: LandmarkPairs) -> tuple[FloatArray, FloatArray] | None:
    """The two arrays of points, or None if these are no points."""
    if not isinstance(landmarks, (tuple, list)) or len(landmarks) != 2:
        return None
    try:
        first, second = (as_array(part).astype(np.float64) for part in landmarks)
    except (TypeError, ValueError):
        return None
    if first.ndim != 2 or second.ndim != 2:
        return None
    if first.shape != second.shape or first.shape[1] != 3 or not len(first):
        raise ParameterError(
            "landmarks as points must be two arrays of one shape (k, 3), of X and of Y, "
            f"got {first.shape} and {second.shape}"
        )
    return first, second


def _nearest_vertices(name: str, surface: Surface, points: FloatArray) -> IndexArray:
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise ParameterError(f"landmark {bad[0]} on {name} is {points[bad[0]].tolist()}: coordinates must be finite")
    found = cKDTree(surface.vertices).query(points)
    gaps, nearest = np.asarray(found[0]), np.asarray(found[1], dtype=np.int64)
    # Where triangles are large, a point in the middle of one is far from every vertex.
    far = np.flatnonzero(gaps > max(NEAR_THE_SURFACE * np.sqrt(surface.area), surface.edge_lengths.max()))
    if far.size:
        raise ParameterError(
            f"landmark {far[0]} is {gaps[far[0]]:.4g} from the nearest vertex of {name}, which is "
            f"{np.ptp(surface.vertices, axis=0).max():.4g} wide ({far.size} such: {listed(far)}): give points on the "
            "surface, in its own frame and unit"
        )
    return nearest


def _checked_pairs(landmarks: LandmarkPairs, x: Surface, y: Surface) -> IndexArray:
    wanted = "landmarks must be pairs (vertex of X, vertex of Y), or a pair of arrays of points, (k, 3) each"
    try:
        pairs = as_array(landmarks)
    except (TypeError, ValueError) as error:  # rows of different lengths
        raise ParameterError(f"{wanted}: {error}") from error
    if pairs.ndim != 2 or pairs.shape[1:] != (2,) or not len(pairs):
        raise ParameterError(f"{wanted}, at least one, got shape {pairs.shape}")
    if pairs.dtype.kind not in "iu":
        raise ParameterError(f"{wanted}, got {pairs.dtype}")
    for column, (name, surface) in enumerate((("X", x), ("Y", y))):
        outside = np.flatnonzero((pairs[:, column] < 0) | (pairs[:, column] >= surface.n_vertices))
        if outside.size:
            raise ParameterError(
                f"landmark {outside[0]} is vertex {pairs[outside[0], column]} of {name}, which has "
                f"{surface.n_vertices} vertices, numbered from 0 ({outside.size} such: {listed(outside)})"
            )
    return pairs.astype(np.int64)


def _without_repetitions(pairs: IndexArray) -> IndexArray:
    """The pairs in order, each once; `ParameterError` for a vertex with two partners."""
    pairs = pairs[np.sort(np.unique(pairs, axis=0, return_index=True)[1])]
    for column, (here, there) in enumerate((("X", "Y"), ("Y", "X"))):
        vertices, counts = np.unique(pairs[:, column], return_counts=True)
        if counts.max() > 1:
            repeated = vertices[counts > 1]
            partners = pairs[pairs[:, column] == repeated[0], 1 - column]
            raise ParameterError(
                f"landmarks contradict each other: vertex {repeated[0]} of {here} belongs to vertices "
                f"{listed(partners)} of {there} ({repeated.size} such: {listed(repeated)}); keep one of them"
            )
    return pairs


def _checked_labels(labels: LabelPair, x: Surface, y: Surface) -> tuple[IndexArray, IndexArray]:
    if not isinstance(labels, (tuple, list)) or len(labels) != 2:
        raise ParameterError("labels must be two arrays, a number for each vertex of X and for each of Y")
    checked = []
    for name, surface, values in zip("XY", (x, y), labels, strict=True):
        array = as_array(values)
        if array.shape != (surface.n_vertices,):
            raise ParameterError(
                f"labels of {name} must be a whole number for each of its {surface.n_vertices} vertices, "
                f"got shape {array.shape}"
            )
        if array.dtype.kind not in "iu":
            raise ParameterError(f"labels of {name} must be whole numbers, negative where unknown, got {array.dtype}")
        checked.append(array.astype(np.int64))
    known = [np.unique(array[array >= 0]) for array in checked]
    if not np.intersect1d(known[0], known[1]).size:
        raise ParameterError(
            f"labels of X and Y have no number in common: those of X are {listed(known[0]) or 'all unknown'}, "
            f"those of Y {listed(known[1]) or 'all unknown'}"
        )
    return checked[0], checked[1]
