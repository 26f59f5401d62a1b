"""Maps between all vertices, deformed along, and what that costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.maps.map_distance import mean_distortion
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.registration_stages import Stages
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.selection.signatures import curvature_agreement, hks_agreements, relief_agreement
from qgeo_filters.matching.smooth_shells import DenseMap, register
from qgeo_filters.parallel import concurrently


@dataclass(frozen=True, eq=False)
class Contender:
    """A candidate after a preview, or further on.

    Attributes
    ----------
    dense : DenseMap
    mean_distortion : float
        See `mean_distortion`.
    strain : float
        What is not rigid of the deformation of X along the map, see `ArapSolver.energy`.
    torn : float
        Share of X's edges whose ends are mapped far apart.
    folded : float
        Share of X's area that the deformation turns over.
    hks_agreement : float
        See `hks_agreement`.
    relief_agreement : float
        See `relief_agreement`.
    cost : float
        Product of strain, torn and folded shares, root of the distortion, and how unlike the parts are. Larger for a
        map that is wrong in a part.
    end_cost : float
        The same for maps that have settled, with other powers, and with how unlike the relief, curvature, and heat
        kernels after little heat are.
    number : int
        In the log of the problem.
    without_kernels : float
        Product of strain, torn share, root of the distortion and how unlike the relief is: what is said by all that did
        not lead the map, where heat kernels did.
    penalty : float
        By which both costs were multiplied for what the map does to the hints; 1 without any.
    in_place : DenseMap, optional
        The map before heat kernels led a part of it elsewhere, if the deformation costs less there: a slender tail and
        a stout one correspond although they are unlike.
    """

    dense: DenseMap
    mean_distortion: float
    strain: float
    torn: float
    folded: float
    hks_agreement: float
    relief_agreement: float
    cost: float
    end_cost: float
    number: int
    without_kernels: float
    penalty: float = 1.0
    in_place: DenseMap | None = None

    @property
    def to_finish(self) -> DenseMap:
        """The map that is registered to the end."""
        return self.in_place or self.dense

    @property
    def unhinted_cost(self) -> float:
        """The cost where it ends, without the hints."""
        return self.end_cost / self.penalty


def registered(
    problem: MatchProblem, maps: list[tuple[int, IndexArray]], stages: Stages, start: IndexArray | None = None
) -> list[Contender]:
    """The maps after these stages and what they cost, in order, side by side.

    Parameters
    ----------
    maps : list of (number in the log, images of ``start`` or of all vertices)
    """
    schedule = Schedule.of(problem, stages, start)
    solvers = schedule.prefactor(problem.x.arap)
    return concurrently(lambda m: measured(problem, register(problem, m[1], schedule, solvers), m[0]), maps)


def measured(problem: MatchProblem, dense: DenseMap, number: int) -> Contender:
    """A map with what it costs."""
    x, y, given = problem.x, problem.y, problem.parameters
    p2p = dense.p2p
    deformed = x.unit.with_vertices(dense.positions)
    against = np.einsum("ij,ij->i", deformed.face_normals, y.normals[p2p[x.unit.faces]].sum(axis=1)) < 0
    folded = float(x.unit.face_areas @ against) / x.unit.area
    torn, strain = torn_share(problem, p2p), x.arap.energy(dense.positions)
    distortion = mean_distortion(problem, p2p[x.fps])
    kernels, relief = hks_agreements(problem, p2p), relief_agreement(problem, p2p)
    hks = min(kernels[given.hks_compared_from :])
    # Squared: the cost is a product of several terms, each of which may grow as the distortion does.
    penalty = float(problem.penalties(x.fps, p2p[x.fps])) ** 2
    terms = _Terms(
        strain=max(strain, given.least_strain),
        torn=max(torn, given.least_torn),
        folded=folded + given.least_folded,
        distortion=max(distortion, given.least_distortion),
        unlike=1 - hks + given.least_hks_gap,
        relief=1 - relief + given.least_curvature_gap,
        curvature=1 - curvature_agreement(problem, p2p) + given.least_curvature_gap,
        kernels=1 - kernels[0] + given.least_hks_gap,
    )
    powers = given.reflection_end_powers if problem.reflection else given.end_powers
    return Contender(
        dense, distortion, strain, torn, folded, hks, relief,
        penalty * terms.cost, penalty * terms.end_cost(powers), number, terms.without_kernels, penalty,
    )  # fmt: skip


def torn_share(problem: MatchProblem, p2p: IndexArray) -> float:
    """Share of X's edges whose ends are mapped far apart: by the edges of X, or by those of a coarser Y."""
    x, y, given = problem.x.unit, problem.y.unit, problem.parameters
    a, b = p2p[x.edges.T]
    lengths = np.linalg.norm(y.vertices[a] - y.vertices[b], axis=1)
    far = max(given.torn_edges * x.edge_lengths.mean(), given.torn_edges_of_y * y.edge_lengths.mean())
    return float((lengths > far).mean())


@dataclass(frozen=True)
class _Terms:
    """What a map costs, each term at least the noise of right maps."""

    strain: float
    torn: float
    folded: float
    distortion: float
    unlike: float
    relief: float
    curvature: float
    kernels: float

    @property
    def cost(self) -> float:
        return self.strain * self.torn * self.folded * self.unlike * self.distortion**0.5

    @property
    def without_kernels(self) -> float:
        return self.strain * self.torn * self.distortion**0.5 * self.relief

    def end_cost(self, powers: tuple[float, float, float, float, float]) -> float:
        shares, distortion, relief, curvature, kernels = powers
        product = self.strain * (self.torn * self.folded * self.unlike) ** shares * self.distortion**distortion
        return float(product * self.relief**relief * self.curvature**curvature * self.kernels**kernels)
