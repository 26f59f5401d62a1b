"""Maps between all vertices that the search proposes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters.matching.concurrency import concurrently
from qgeo_filters.matching.descriptor import Descriptor
from qgeo_filters.matching.extremities import extremity_maps
from qgeo_filters.matching.finish import grown, spread
from qgeo_filters.matching.orientation import orientation
from qgeo_filters.matching.search import search

SingleArray = npt.NDArray[np.float32]
IndexArray = npt.NDArray[np.int64]

# Maps that distort distances by more than this times the best are not worth growing.
_WORTHWHILE = 2.0
# Distortion of a coarse map below which the next ones count as well: a shape that turns onto itself has many as good as
# the identity between two copies of one mesh, but for the rounding to farthest points.
_ROUGH = 0.02
# Points between which distances are compared.
_POINTS = 300


@dataclass(frozen=True, eq=False)
class Candidate:
    """A map between all vertices, right in the large or not.

    Attributes
    ----------
    p2p : (n_x,) int
    distortion : float
        Mean |d_X(p, q) - d_Y(Tp, Tq)|, in units of sqrt(area), over farthest points.
    orientation : float
        See `orientation`.
    """

    p2p: IndexArray
    distortion: float
    orientation: float


def candidates(x: Descriptor, y: Descriptor, *, identity: bool = True) -> list[Candidate]:
    """Different maps from X to Y, the least distorting first; see `search` for ``identity``."""
    hypotheses = search(x, y, identity=identity)
    # Without the identity, what is left near it may keep distances better than any reflection does.
    bound = _WORTHWHILE * max(hypotheses[0].distortion, _ROUGH) + 0.01 if identity and hypotheses else np.inf
    worth = [h for h in hypotheses if h.distortion <= bound]
    guesses = extremity_maps(x, y, identity=identity)
    found = concurrently(lambda hypothesis: candidate(x, y, grown(x, y, hypothesis)), worth)
    found += concurrently(lambda guess: candidate(x, y, spread(x, y, guess)), guesses)
    return sorted(found, key=lambda c: c.distortion)


def candidate(x: Descriptor, y: Descriptor, p2p: IndexArray) -> Candidate:
    """The map with its measures."""
    return Candidate(p2p, distortion(x, y, p2p), orientation(x.unit, y.unit, p2p))


def distortion(x: Descriptor, y: Descriptor, p2p: IndexArray) -> float:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over pairs of farthest points, in units of sqrt(area).

    One image of each pair is taken to the nearest farthest point of Y, from which distances are at hand.
    """
    s = min(_POINTS, len(x.rows))
    points = x.samples[:s]
    near = np.argmin(y.rows[:, p2p[points]], axis=0)
    images = y.rows[near][:, p2p[points]]
    return float(np.abs(x.rows[:s, points] - images).mean())


def between(y: Descriptor, one: IndexArray, other: IndexArray) -> SingleArray:
    """Distances on Y between the images of two maps (a close lower bound), in units of sqrt(area)."""
    # Distances to a landmark differ by at most the distance, and by nearly as much for one landmark of many.
    rows = y.rows[:100]
    return np.abs(rows[:, one] - rows[:, other]).max(axis=0)
