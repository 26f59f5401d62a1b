"""Maps between all shapes of a collection through few of them: along a tree, or through one shape."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.composition import Maps, Pair, along, checked_maps
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_filters.validation import listed


def spanning_tree(names: Iterable[str], costs: Mapping[Pair, float]) -> list[Pair]:
    """Pairs that join all shapes at the least sum of costs.

    Parameters
    ----------
    names : iterable of str
    costs : mapping of (x, y) to float
        What a pair costs: inconsistency, distortion, C_XY; pairs that may not be used are left out. A pair with a cost
        each way has the smaller one.

    Returns
    -------
    list of (x, y)
        One less than there are shapes, x before y in the order of the names.

    Raises
    ------
    ParameterError
        A shape that no pair joins to the rest, a cost that is negative or not finite.
    """
    names = list(names)
    place = {name: i for i, name in enumerate(names)}
    best: dict[tuple[int, int], float] = {}
    for (x, y), cost in costs.items():
        if x not in place or y not in place:
            raise ParameterError(f"there is a cost of {x} - {y}, but no shape called {y if x in place else x!r}")
        if not 0 <= cost < np.inf:
            raise ParameterError(f"the cost of {x} - {y} must be a number, not negative, got {cost!r}")
        if x != y:
            key = min(place[x], place[y]), max(place[x], place[y])
            best[key] = min(cost, best.get(key, np.inf))
    rows, columns = (np.array([key[side] for key in best], dtype=np.int32) for side in (0, 1))
    # Zeros are no edges to SciPy.
    values = np.array(list(best.values())) + 1.0
    graph = sparse.csr_array((values, (rows, columns)), (len(names), len(names)))
    pieces, piece = connected_components(graph, directed=False)
    if pieces > 1:
        away = [name for name, p in zip(names, piece, strict=True) if p != np.bincount(piece).argmax()]
        raise ParameterError(f"no pair joins {', '.join(away[:5])} to the rest ({len(away)} such shapes)")
    tree = minimum_spanning_tree(graph).tocoo()
    found = sorted((min(i, j), max(i, j)) for i, j in zip(tree.row.tolist(), tree.col.tolist(), strict=True))
    return [(names[i], names[j]) for i, j in found]


def tree_maps(shapes: Mapping[str, Surface], maps: Maps, tree: Iterable[Pair]) -> dict[Pair, BarycentricMap]:
    """Maps between all pairs of shapes along the edges of a tree: along any circle they come back.

    Parameters
    ----------
    shapes : mapping of name to Surface
    maps : mapping
        At least one for each edge of the tree, in both directions.
    tree : iterable of (x, y)

    Raises
    ------
    ParameterError
        No tree of these shapes, or a map of an edge that is missing.
    """
    edges = list(tree)
    checked = checked_maps(shapes, _of_edges(maps, edges))
    names = list(shapes)
    place = {name: i for i, name in enumerate(names)}
    i, j = (np.array([place[pair[side]] for pair in edges], dtype=np.int64) for side in (0, 1))
    graph = sparse.csr_array((np.ones(len(edges)), (i, j)), (len(names), len(names)))
    if len(edges) != len(names) - 1 or connected_components(graph, directed=False)[0] != 1:
        raise ParameterError(f"{len(edges)} pairs are no tree of the {len(names)} shapes: {listed_pairs(edges)}")
    found = {}
    for root, name in enumerate(names):
        order, before = breadth_first_order(graph, root, directed=False)
        path = {root: [name]}
        for here in order[1:].tolist():
            previous = int(before[here])
            path[here] = [*path[previous], names[here]]
            step = {(names[previous], names[here]): checked[names[previous], names[here]]}
            if previous == root:
                found[name, names[here]] = step[name, names[here]]
            else:
                step[name, names[previous]] = found[name, names[previous]]
                found[name, names[here]] = along([name, names[previous], names[here]], shapes, step)
    return found


def template_maps(shapes: Mapping[str, Surface], maps: Maps, template: str) -> dict[Pair, BarycentricMap]:
    """Maps between all pairs of shapes through one of them.

    Raises
    ------
    ParameterError
        No such shape, or a map from or to it that is missing.
    """
    if template not in shapes:
        raise ParameterError(f"there is no shape called {template!r} among {listed(list(shapes))}")
    return tree_maps(shapes, maps, [(template, name) for name in shapes if name != template])


def listed_pairs(pairs: Iterable[Pair], limit: int = 5) -> str:
    """First few pairs for an error message."""
    return listed([" - ".join(pair) for pair in pairs], limit)


def _of_edges(maps: Maps, edges: list[Pair]) -> Maps:
    needed = [pair for x, y in edges for pair in ((x, y), (y, x))]
    missing = [pair for pair in needed if pair not in maps]
    if missing:
        raise ParameterError(f"{len(missing)} maps of the tree are missing: {listed_pairs(missing)}")
    return {pair: maps[pair] for pair in needed}
