"""Wrong maps of a collection, matched again from where all others say that they should go."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.composition import Maps, Pair, checked_maps
from qgeo_filters.collection.cycles import TOLERANCE, CycleConsistency
from qgeo_filters.collection.synchronisation import synchronised_map
from qgeo_filters.errors import QgeoError, reason
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.map_errors import map_errors
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.restart import match_from
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.surface import Surface

# How many times what the wrong map costs the mended one may: where the true map strains more than a wrong one, the
# cheaper would be kept, and all others say which of the two it is. Measured by benchmarks/consistent_maps.py.
_DEARER = 2.0
# Points at which maps are compared.
_POINTS = 80


#: Match of two shapes, by name, from a map that is right in the large, with a rival or none; see `match_from`.
Registration: TypeAlias = Callable[[str, str, IndexArray, IndexArray | None], MatchResult]


@dataclass(frozen=True)
class MendedPair:
    """What became of a wrong pair.

    Attributes
    ----------
    x, y : str
    inconsistency : float
        Of the wrong map, see `CycleConsistency`.
    apart : float
        Mean geodesic distance between the images of the map that was found and where the others say, in sqrt(area);
        NaN if none was found.
    dearer : float
        How many times what the wrong map costs the new one does, both registered in the same way.
    mended : bool
    explanation : str
    """

    x: str
    y: str
    inconsistency: float
    apart: float
    dearer: float
    mended: bool
    explanation: str


def mended_maps(
    shapes: Mapping[str, Surface],
    maps: Maps,
    consistency: CycleConsistency,
    *,
    tolerance: float = TOLERANCE,
    register: Registration | None = None,
    repairs: Mapping[str, Repair] | None = None,
    workers: int | None = None,
) -> tuple[dict[Pair, BarycentricMap], list[MendedPair]]:
    """The maps with wrong ones matched again from the composed maps, and what became of each.

    Parameters
    ----------
    shapes, maps : mapping
        As for `cycle_consistency`.
    consistency : CycleConsistency
        Of these maps.
    tolerance : float
        Above which a pair is wrong, and within which a mended map must agree with the others, in sqrt(area).
    register : callable, optional
        Takes the place of `match_from`, where prepared shapes or what was found before are at hand; takes the names of
        two shapes, a map to start from and its rival, or None.
    repairs : mapping of name to Repair, optional
        As for `cycle_consistency`.
    workers : int, optional

    Returns
    -------
    maps : dict of (x, y) to BarycentricMap
        All maps; those of mended pairs in both directions.
    pairs : list of MendedPair
        Every wrong pair, the worst first, mended or named.

    Notes
    -----
    A new map is taken if it stays where all others say, and costs at most twice what the wrong one does: costs alone
    chose the wrong one, and only keep out what strains or tears beyond that.
    """
    found = checked_maps(shapes, maps)
    register = register or registration(lambda name: PreparedShape(shapes[name]), workers)
    report = []
    for x, y in consistency.wrong(tolerance):
        pair, forth, back = _mended(
            x, y, shapes, found, consistency, tolerance, register, (repairs or {}).get(y), workers
        )
        report.append(pair)
        if forth is not None and back is not None:
            found |= {(x, y): forth, (y, x): back}
    return found, report


def registration(shape_of: Callable[[str], PreparedShape], workers: int | None = None) -> Registration:
    """`match_from` of shapes by name, each of which is asked for once."""
    kept = functools.cache(shape_of)

    def register(x: str, y: str, start: IndexArray, rival: IndexArray | None) -> MatchResult:
        return match_from(kept(x), kept(y), start, rival=rival, workers=workers)

    return register


def _mended(
    x: str,
    y: str,
    shapes: Mapping[str, Surface],
    maps: dict[Pair, BarycentricMap],
    consistency: CycleConsistency,
    tolerance: float,
    register: Registration,
    repair: Repair | None,
    workers: int | None,
) -> tuple[MendedPair, BarycentricMap | None, BarycentricMap | None]:
    def failed(why: str) -> tuple[MendedPair, None, None]:
        return MendedPair(x, y, consistency.of(x, y), np.nan, np.nan, False, why), None, None

    others = {pair: place for pair, place in maps.items() if set(pair) != {x, y}}
    start = synchronised_map(x, y, shapes, others, consistency)
    if start is None:
        return failed("there is no way from one to the other through a third shape")
    rival = maps.get((x, y))
    try:
        given = None if rival is None else rival.nearest_corner
        new = register(x, y, start.nearest_corner, given)
    except QgeoError as error:
        return failed(reason(error))
    some = farthest_in_embedding(shapes[x].vertices, min(_POINTS, shapes[x].n_vertices))
    lengths = map_errors(shapes[y], new.p2p[some], start.nearest_corner[some], False, repair, workers)
    apart, dearer = float(np.nanmean(lengths)), 1 / new.margin
    if apart > tolerance:
        why = f"registered from where the others say it ends {apart:.3f} sqrt(area) away from there"
    elif dearer > _DEARER:
        why = f"the map that the others say costs {dearer:.1f} times as much"
    else:
        why = f"matched again from where the others say, {apart:.3f} sqrt(area) from there"
    mended = apart <= tolerance and dearer <= _DEARER
    pair = MendedPair(x, y, consistency.of(x, y), apart, dearer, mended, why)
    return (pair, new.barycentric, new.inverse_barycentric) if mended else (pair, None, None)
