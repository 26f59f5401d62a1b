"""Maps between all vertices that the search proposes, and which of them is the best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters.matching.descriptor import Descriptor
from qgeo_filters.matching.finish import TRIAL, finished, grown
from qgeo_filters.matching.orientation import orientation
from qgeo_filters.matching.search import DISTINCT, search

IndexArray = npt.NDArray[np.int64]

# Maps that distort distances by more than this times the best are not worth growing.
_WORTHWHILE = 2.0
# Points between which distances are compared.
_POINTS = 300
# Contenders that are tried, and how much more than the best they may distort distances.
_CONTENDERS = 8
_CONTENDING = 1.7
# An edge is torn if its ends are mapped this many mean edges apart.
_TORN = 3.0
# Shares of torn edges and folded triangles, strains and distortions below these do not tell maps apart.
_LEAST_TORN, _LEAST_FOLDED, _LEAST_STRAIN, _LEAST_DISTORTION = 1e-3, 5e-4, 1e-3, 1e-4


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


@dataclass(frozen=True, eq=False)
class Contender:
    """A candidate after a trial.

    Attributes
    ----------
    p2p : (n_x,) int
    distortion : float
        As of a candidate, after the trial.
    strain : float
        What is not rigid of the deformation of X along the map, see `Rigidity.strain`.
    torn : float
        Share of X's edges whose ends are mapped far apart.
    folded : float
        Share of X's area that the deformation turns over.
    """

    p2p: IndexArray
    distortion: float
    strain: float
    torn: float
    folded: float

    @property
    def cost(self) -> float:
        """Product of strain, torn and folded shares, and root of the distortion: larger for a map wrong in a part."""
        torn, folded = max(self.torn, _LEAST_TORN), self.folded + _LEAST_FOLDED
        return max(self.strain, _LEAST_STRAIN) * torn * folded * np.sqrt(max(self.distortion, _LEAST_DISTORTION))


def candidates(x: Descriptor, y: Descriptor, *, identity: bool = True) -> list[Candidate]:
    """Different maps from X to Y, the least distorting first; see `search` for ``identity``."""
    hypotheses = search(x, y, identity=identity)
    # Without the identity, what is left near it may keep distances better than any reflection does.
    bound = _WORTHWHILE * hypotheses[0].distortion + 0.01 if identity and hypotheses else np.inf
    worth = [h for h in hypotheses if h.distortion <= bound]
    found = [candidate(x, y, grown(x, y, hypothesis)) for hypothesis in worth]
    return sorted(found, key=lambda c: c.distortion)


def candidate(x: Descriptor, y: Descriptor, p2p: IndexArray) -> Candidate:
    """The map with its measures."""
    return Candidate(p2p, distortion(x, y, p2p), orientation(x.unit, y.unit, p2p))


def contenders(x: Descriptor, y: Descriptor, pool: list[Candidate]) -> list[Contender]:
    """The best different candidates, deformed onto Y on trial, the cheapest first.

    A map that is right in one part and wrong in another, such as one that swaps two legs, can keep distances better
    than the right one does between two poses; but a deformation that follows it has to tear, fold or twist the surface
    in between. The maps must keep the orientation.
    """
    ranked = sorted(pool, key=lambda c: c.distortion)
    best = ranked[0].distortion
    tried: list[Candidate] = []
    for c in ranked:
        near = len(tried) < _CONTENDERS and c.distortion <= _CONTENDING * best + 0.01
        if near and all(difference(y, c.p2p, t.p2p) > DISTINCT for t in tried):
            tried.append(c)
    return sorted((_trial(x, y, c) for c in tried), key=lambda c: c.cost)


def _trial(x: Descriptor, y: Descriptor, candidate: Candidate) -> Contender:
    result = finished(x, y, candidate.p2p, TRIAL)
    a, b = result.p2p[x.unit.edges.T]
    lengths = np.linalg.norm(y.unit.vertices[a] - y.unit.vertices[b], axis=1)
    torn = float((lengths > _TORN * x.unit.edge_lengths.mean()).mean())
    deformed = x.unit.with_vertices(result.positions)
    against = np.einsum("ij,ij->i", deformed.face_normals, y.normals[result.p2p[x.unit.faces]].sum(axis=1)) < 0
    folded = float(x.unit.face_areas @ against) / x.unit.area
    strain = x.rigidity.strain(result.positions)
    return Contender(result.p2p, distortion(x, y, result.p2p), strain, torn, folded)


def distortion(x: Descriptor, y: Descriptor, p2p: IndexArray) -> float:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over pairs of farthest points, in units of sqrt(area).

    One image of each pair is taken to the nearest farthest point of Y, from which distances are at hand.
    """
    s = min(_POINTS, len(x.rows))
    points = x.samples[:s]
    near = np.argmin(y.rows[:, p2p[points]], axis=0)
    between = y.rows[near][:, p2p[points]]
    return float(np.abs(x.rows[:s, points] - between).mean())


def difference(y: Descriptor, one: IndexArray, other: IndexArray) -> float:
    """Mean distance on Y between the images of two maps (a close lower bound), in units of sqrt(area)."""
    # Distances to a landmark differ by at most the distance, and by nearly as much for one landmark of many.
    rows = y.rows[:100]
    return float(np.abs(rows[:, one] - rows[:, other]).max(axis=0).mean())
