"""Limbs of a shape that was placed on another, moved to what it leaves uncovered there.

An arm that has grown onto a body changes distances so much that maps are proposed which have all but the arm in place.
Of the other surface just the arm is uncovered then; the deformation tells whether the limb belongs there.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.connectivity import vertex_components
from qgeo_filters.matching.partial.distance_bounds import profile_costs
from qgeo_filters.matching.partial.part_choice import PartChoice, PlacedPart
from qgeo_filters.matching.partial.part_shape import PartShape


def with_limbs_moved(choice: PartChoice, to_ends: SingleArray, best: PlacedPart) -> tuple[PlacedPart, list[PlacedPart]]:
    """The cheapest place, after limbs were moved as long as that makes it cheaper, and all that were tried.

    Parameters
    ----------
    choice : PartChoice
        Where places are registered and compared.
    to_ends : (e, n_x) float32
        Distances of X's vertices from the ends of its limbs.
    best : PlacedPart
    """
    tried: list[PlacedPart] = []
    for _ in range(choice.given.limb_moves):
        maps = [p2p for area in uncovered(choice.y, best) for p2p in _moved(choice, to_ends, best, area)]
        if not maps:
            break
        placed = choice.placed([(choice.proposed(p2p, "a limb moved to what is not covered"), p2p) for p2p in maps])
        tried += placed
        cheapest = min(placed, key=lambda p: p.cost)
        if cheapest.cost >= best.cost:
            break
        best = cheapest
    return best, tried


def uncovered(y: PartShape, place: PlacedPart) -> list[npt.NDArray[np.bool_]]:
    """Connected parts of Y, each (n_y,) bool, that do not come back to themselves; the largest first."""
    given, found = y.given, place.map
    gaps = np.linalg.norm(y.vertices[found.p2p[found.back]] - y.vertices, axis=1)
    bare = gaps > max(given.uncovered_gap, given.uncovered_edges * y.surface.edge_lengths.mean())
    edges = y.surface.edges
    _, label = vertex_components(edges[bare[edges].all(axis=1)], y.n_vertices)
    areas = np.bincount(label, y.areas * bare)
    largest = np.argsort(-areas, kind="stable")[: given.uncovered_parts]
    return [(label == k) & bare for k in largest if areas[k] > given.uncovered_area]


def _moved(choice: PartChoice, to_ends: SingleArray, best: PlacedPart, area: npt.NDArray[np.bool_]) -> list[IndexArray]:
    """For each limb the images (s,) of X's points, with that limb's near an area."""
    y, mapper, given = choice.y, choice.mapper, choice.given
    points = choice.x.fps[: mapper.count]
    near = np.flatnonzero(y.rows[:, area].min(axis=1) < given.uncovered_reach)
    if not near.size:
        return []
    place = y.rows[:, best.map.p2p[points]].argmin(axis=0)
    found = []
    for distance in to_ends[:, points]:
        limb = np.flatnonzero(distance < given.limb_reach)
        others = np.setdiff1d(np.arange(len(points)), limb)
        if not (limb.size and others.size):
            continue
        images, some = place.copy(), others
        for _ in range(given.rounds):
            costs = profile_costs(
                np.ascontiguousarray(mapper.least[np.ix_(limb, some)]),
                np.ascontiguousarray(mapper.most[np.ix_(limb, some)]),
                np.ascontiguousarray(mapper.closeness[np.ix_(limb, some)]),
                mapper.between,
                images[some],
                given.within_bounds,
                given.pair_cap,
            )
            images[limb] = near[(costs + mapper.alone[limb])[:, near].argmin(axis=1)]
            some = np.arange(len(points))
        found.append(y.fps[images])
    return found
