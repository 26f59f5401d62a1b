"""From the map that was chosen among coarse ones to one between all vertices."""

from __future__ import annotations

from qgeo_filters.matching.maps.resolutions import CarriedMap, carried
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.smooth_shells import DenseMap, register


def finished(problem: MatchProblem, coarse: DenseMap) -> DenseMap:
    """The map registered to the end, between the vertices of the fine levels."""
    # What the map contradicts must not bend it any more.
    agreed = problem.with_known(problem.known and problem.known.agreeing(coarse.p2p))
    x, y, fine = problem.x, problem.y, agreed.fine
    same = fine.x is x and fine.y is y
    start = coarse.p2p if same else carried(coarse.positions, x.proxy, y, y.fine_proxy.surface).p2p
    try:
        return register(fine, start, Schedule.of(fine, problem.parameters.final))
    finally:
        fine.x.arap.release()  # 30 kB a vertex, and no match of the same X is quicker for them


def at_full_resolution(problem: MatchProblem, dense: DenseMap) -> CarriedMap:
    """The finished map between all vertices, positions in Y's frame."""
    x, y, fine = problem.x, problem.y, problem.fine
    if x.fine_proxy.surface is x.oriented and y.fine_proxy.surface is y.oriented:
        return CarriedMap(dense.p2p, dense.inverse, dense.positions * fine.y.scale + fine.y.centre)
    return carried(dense.positions, x.fine_proxy, fine.y, y.oriented)
