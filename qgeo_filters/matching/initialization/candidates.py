"""Maps of farthest points to vertices that the search proposes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.matching.initialization.agd_extrema import extremity_maps
from qgeo_filters.matching.initialization.sign_search import search
from qgeo_filters.matching.maps.orientation import facing
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.smooth_shells import grown, spread
from qgeo_filters.parallel import concurrently

# Maps that distort distances by more than this times the best are not worth growing.
_WORTHWHILE = 2.0
# Distortion of a coarse map below which the next ones count as well: a shape that turns onto itself has many as good as
# the identity between two copies of one mesh, but for the rounding to farthest points.
_ROUGH = 0.02
# Points between which distances are compared.
_POINTS = 300
# Farthest points that are mapped: enough for a trial, which begins with smooth functions.
_MAPPED = 800
# Triangles, each at a farthest point, that tell the orientation.
_TRIANGLES = 400
# A map whose orientation is nearer to 0 turns much of the surface over: the best right ones of sixteen pairs of the
# tuning categories have .38 and more.
_ONE_SIDED = 0.15


@dataclass(frozen=True, eq=False)
class Candidate:
    """A coarse map, right in the large or not.

    Attributes
    ----------
    p2p : (s,) int
        Vertex of Y for each of X's `mapped_points`.
    distortion : float
        Mean |d_X(p, q) - d_Y(Tp, Tq)|, in units of sqrt(area), over farthest points.
    orientation : float
        See `orientation`; over some of the triangles.
    """

    p2p: IndexArray
    distortion: float
    orientation: float


def mapped_points(x: PreparedShape) -> IndexArray:
    """The vertices of X that candidates map: its first farthest points."""
    return x.samples[:_MAPPED]


def candidates(x: PreparedShape, y: PreparedShape, *, identity: bool = True) -> list[Candidate]:
    """Different maps from X to Y, the least distorting first; see `search` for ``identity``.

    Maps that neither keep nor reverse the orientation are left out, unless there are no others.
    """
    hypotheses = search(x, y, identity=identity)
    # Without the identity, what is left near it may keep distances better than any reflection does.
    bound = _WORTHWHILE * max(hypotheses[0].distortion, _ROUGH) + 0.01 if identity and hypotheses else np.inf
    worth = [h for h in hypotheses if h.distortion <= bound]
    guesses = extremity_maps(x, y, identity=identity)
    points, triangles = mapped_points(x), _largest_triangles(x)
    vertices = np.concatenate([points, triangles.ravel()])

    def measured(images: IndexArray) -> Candidate:
        p2p, corners = images[: len(points)], images[len(points) :].reshape(-1, 3)
        return Candidate(p2p, distortion(x, y, p2p), float(facing(y.unit, corners).mean()))

    tasks = [partial(grown, x, y, hypothesis, vertices) for hypothesis in worth]
    tasks += [partial(spread, x, y, guess, vertices) for guess in guesses]
    found = sorted(concurrently(lambda task: measured(task()), tasks), key=lambda c: c.distortion)
    return [c for c in found if abs(c.orientation) > _ONE_SIDED] or found


def _largest_triangles(x: PreparedShape) -> IndexArray:
    """The largest triangle at each of the first farthest points, (t, 3)."""
    order = np.argsort(x.unit.face_areas, kind="stable")
    largest = np.empty(x.n_vertices, dtype=np.int64)
    largest[x.unit.faces[order]] = order[:, None]  # the last one stays
    return x.unit.faces[largest[x.samples[:_TRIANGLES]]].astype(np.int64)


def distortion(x: PreparedShape, y: PreparedShape, images: IndexArray) -> float:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over pairs of farthest points, in units of sqrt(area).

    One image of each pair is taken to the nearest farthest point of Y, from which distances are at hand.

    Parameters
    ----------
    images : (s,) int
        Of X's first farthest points: of how many, does not matter if they are at least 300.
    """
    s = min(_POINTS, len(x.rows))
    images = images[:s]
    near = np.argmin(y.rows[:, images], axis=0)
    return float(np.abs(x.rows[:s, x.samples[:s]] - y.rows[near][:, images]).mean())


def between(y: PreparedShape, one: IndexArray, other: IndexArray) -> SingleArray:
    """Distances on Y between the images of two maps (a close lower bound), in units of sqrt(area)."""
    # Distances to a landmark differ by at most the distance, and by nearly as much for one landmark of many.
    rows = y.rows[:100]
    return np.abs(rows[:, one] - rows[:, other]).max(axis=0)
