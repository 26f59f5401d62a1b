"""From the map that was chosen among coarse ones to one between all vertices."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_facing_points
from qgeo_filters.matching.level import LevelPair
from qgeo_filters.matching.maps.resolutions import CarriedMap, carried
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.smooth_shells import DenseMap, register


def finished(problem: MatchProblem, coarse: DenseMap) -> DenseMap:
    """The map registered to the end, between the vertices of the fine levels.

    X is deformed onto Y; but where X has handles that Y lacks, places where it has grown together, Y onto X: arms can
    be laid on a body, but not be torn from one without tearing all that is near. Then it does not go through low
    frequencies once more, which are those that a handle changes.
    """
    # What the map contradicts must not bend it any more.
    agreed = problem.with_known(problem.known and problem.known.agreeing(coarse.p2p))
    if problem.more_handles <= 0:
        return _registered(agreed, coarse)
    back = agreed.swapped()
    try:
        again = register(back, coarse.inverse, Schedule.of(back, problem.parameters.coarse_to_fine))
    finally:
        back.x.arap.release()
    return turned_round(agreed.fine, _registered(back, again))


def _registered(problem: MatchProblem, coarse: DenseMap) -> DenseMap:
    x, y, fine, given = problem.x, problem.y, problem.fine, problem.parameters
    same = fine.x is x and fine.y is y
    start: IndexArray = coarse.p2p if same else carried(coarse.positions, x.proxy, y, y.fine_proxy.surface).p2p
    try:
        return register(fine, start, Schedule.of(fine, given.grown_final if problem.more_handles else given.final))
    finally:
        fine.x.arap.release()  # 30 kB a vertex, and no match of the same X is quicker for them


def turned_round(pair: LevelPair, back: DenseMap) -> DenseMap:
    """The map from X to Y of the pair, of one from Y to X: X where it lies on the deformed Y."""
    x, y = pair.x.unit, pair.y.unit
    faces, coordinates = closest_facing_points(x.vertices, x.vertex_normals, y.with_vertices(back.positions))
    positions = BarycentricMap(faces, y.faces[faces].astype(np.int64), coordinates).pulled_back(y.vertices)
    return DenseMap(back.inverse, back.p2p, positions, back.embedding_y, back.embedding_x)


def at_full_resolution(problem: MatchProblem, dense: DenseMap) -> CarriedMap:
    """The finished map between all vertices, positions in Y's frame."""
    x, y, fine = problem.x, problem.y, problem.fine
    if x.fine_proxy.surface is x.oriented and y.fine_proxy.surface is y.oriented:
        return CarriedMap(dense.p2p, dense.inverse, dense.positions * fine.y.scale + fine.y.centre)
    return carried(dense.positions, x.fine_proxy, fine.y, y.oriented)
