"""Maps between all vertices, tried as deformations and compared by what these cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.candidates import Candidate, between, distortion, mapped_points
from qgeo_filters.matching.initialization.sign_search import differ
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.selection.signatures import likeness, relief_likeness
from qgeo_filters.matching.smooth_shells import RECONSIDERING, SETTLING, TRIAL, Finished, Pass, factorised, finished
from qgeo_filters.parallel import concurrently

# Contenders that are tried, and how much more than the best they may distort distances.
_CONTENDERS = 10
_CONTENDING = 1.7
# An edge is torn if its ends are mapped this many mean edges apart.
_TORN = 3.0
# Shares of torn edges and folded triangles, strains and distortions below these do not tell maps apart.
_LEAST_TORN, _LEAST_FOLDED, _LEAST_STRAIN, _LEAST_DISTORTION = 1e-3, 5e-4, 1e-3, 1e-4
_LEAST_UNLIKE, _LEAST_RELIEF = 5e-3, 5e-3


@dataclass(frozen=True, eq=False)
class Contender:
    """A candidate after a trial, or further on.

    Attributes
    ----------
    result : Finished
    distortion : float
        As of a candidate, after the trial.
    strain : float
        What is not rigid of the deformation of X along the map, see `Rigidity.strain`.
    torn : float
        Share of X's edges whose ends are mapped far apart.
    folded : float
        Share of X's area that the deformation turns over.
    likeness : float
        See `likeness`.
    relief : float
        See `relief_likeness`.
    """

    result: Finished
    distortion: float
    strain: float
    torn: float
    folded: float
    likeness: float
    relief: float

    @property
    def cost(self) -> float:
        """Product of strain, torn and folded shares, root of the distortion, and how unlike the parts are.

        Larger for a map that is wrong in a part.
        """
        torn, folded = max(self.torn, _LEAST_TORN), self.folded + _LEAST_FOLDED
        strain, unlike = max(self.strain, _LEAST_STRAIN), 1 - self.likeness + _LEAST_UNLIKE
        return strain * torn * folded * unlike * np.sqrt(max(self.distortion, _LEAST_DISTORTION))

    @property
    def end_cost(self) -> float:
        """The cost, and how unlike the relief is, squared: for maps that have settled, details included."""
        return self.cost * (1 - self.relief + _LEAST_RELIEF) ** 2


def contenders(x: PreparedShape, y: PreparedShape, pool: list[Candidate]) -> list[Contender]:
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
        if near and all(differ(between(y, c.p2p, t.p2p)) for t in tried):
            tried.append(c)
    return sorted(taken_further(x, y, [c.p2p for c in tried], TRIAL, mapped_points(x)), key=lambda c: c.cost)


def taken_further(
    x: PreparedShape,
    y: PreparedShape,
    maps: list[IndexArray],
    passes: tuple[Pass, ...],
    points: IndexArray | None = None,
) -> list[Contender]:
    """The maps of ``points`` (of all vertices by default) after more passes of the finish, in order, side by side."""
    factorised(x, y, passes, points)
    return concurrently(lambda p2p: _contender(x, y, finished(x, y, p2p, passes, points)), maps)


def settled(x: PreparedShape, y: PreparedShape, maps: list[IndexArray]) -> list[Contender]:
    """The maps (n_x,) where they end, in order, side by side: settled, or reconsidered if that costs less."""
    factorised(x, y, SETTLING)
    factorised(x, y, RECONSIDERING)

    def ending(p2p: IndexArray) -> Contender:
        end = _contender(x, y, finished(x, y, p2p, SETTLING))
        again = _contender(x, y, finished(x, y, end.result.p2p, RECONSIDERING))
        return min(end, again, key=lambda c: c.end_cost)

    return concurrently(ending, maps)


def _contender(x: PreparedShape, y: PreparedShape, result: Finished) -> Contender:
    p2p = result.p2p
    a, b = p2p[x.unit.edges.T]
    lengths = np.linalg.norm(y.unit.vertices[a] - y.unit.vertices[b], axis=1)
    torn = float((lengths > _TORN * x.unit.edge_lengths.mean()).mean())
    deformed = x.unit.with_vertices(result.positions)
    against = np.einsum("ij,ij->i", deformed.face_normals, y.normals[p2p[x.unit.faces]].sum(axis=1)) < 0
    folded = float(x.unit.face_areas @ against) / x.unit.area
    mean = distortion(x, y, p2p[x.samples])
    strain, relief = x.rigidity.strain(result.positions), relief_likeness(x, y, p2p)
    return Contender(result, mean, strain, torn, folded, likeness(x, y, p2p), relief)
