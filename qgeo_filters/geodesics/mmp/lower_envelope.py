"""Lower envelope of the windows on one half-edge: which source is nearest where (Numba).

A window is an interval [lo, hi] of a half-edge, measured from its first vertex, together with the
pseudo-source that sees it through a strip of unfolded triangles: the source lies at abscissa sx and depth
sy >= 0 behind the half-edge and is itself sigma away from the true source. Point x of the window is then
at distance ``sigma + sqrt((x - sx)^2 + sy^2)`` (Mitchell, Mount, Papadimitriou, "The discrete geodesic
problem", SIAM J. Comput. 16, 1987). Windows of a half-edge do not overlap and are kept in a linked list
ordered by lo; a new one takes from the old ones exactly the points that it brings nearer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters.jit import inner, kernel

Records = npt.NDArray[np.void]

# One cache line.
WINDOW = np.dtype(
    [("lo", "f8"), ("hi", "f8"), ("sx", "f8"), ("sy", "f8"), ("sigma", "f8"), ("next", "i8"), ("pending", "i8"),
     ("_", "f8")]
)  # fmt: skip
LIST = np.dtype([("first", "i8"), ("count", "i8")])

# Distances closer than this, relatively, are a tie, which the window that came first keeps. Far above the
# rounding of a strip of a thousand triangles, far below the accuracy that is promised.
TIE = 1e-13
# Intervals narrower than this, relative to their edge, go to a neighbour: to pass a point at such a distance
# instead of through it makes a path longer by its square only.
SLIVER = 1e-12


class Pool(NamedTuple):
    """The windows of all half-edges: rows of one array, linked into a list for each half-edge."""

    windows: Records  # (capacity,) WINDOW; ``next`` is -1 at the end of a list, and links the rows given back too
    lists: Records  # (half-edges + 1,) LIST, ``first`` -1 where the list is empty; the last one holds the spare window
    free: Records  # (1,) LIST of the rows given back
    used: npt.NDArray[np.int64]  # (1,) rows that were ever in use; the rest of the array is untouched memory


@kernel
def distance_at(x: float, sx: float, sy: float, sigma: float) -> float:
    """Distance of the point at abscissa x from the true source."""
    return sigma + np.sqrt((x - sx) * (x - sx) + sy * sy)


@kernel
def nearest_distance(lo: float, hi: float, sx: float, sy: float, sigma: float) -> float:
    """Smallest distance in a window."""
    return distance_at(min(max(sx, lo), hi), sx, sy, sigma)


@kernel
def _lead(x: float, sx: float, sy: float, sigma: float, w: np.void) -> float:
    """How much farther the newcomer is at x than window w; negative where the newcomer wins."""
    return distance_at(x, sx, sy, sigma) - distance_at(x, w["sx"], w["sy"], w["sigma"])


@kernel
def _quadratic(a: float, b: float, sx: float, sy: float, sigma: float, w: np.void) -> tuple[float, float]:
    """Abscissae where the newcomer and w may be equally far, in ascending order; NaN where there is none.

    ``r - r_w = D`` with ``r^2 - r_w^2`` linear in x gives, squared once, a quadratic equation; it also has
    the roots of ``r + r_w = |D|``, which the caller rules out by what the distances are there.
    """
    # About the middle of the interval the coefficients cancel least.
    middle = 0.5 * (a + b)
    ax, bx = sx - middle, w["sx"] - middle
    d = w["sigma"] - sigma
    slope = 2.0 * (bx - ax)
    constant = (ax - bx) * (ax + bx) + (sy - w["sy"]) * (sy + w["sy"]) - d * d
    if d == 0.0:  # one vertex seen through two strips: the bisector is a line
        x = middle - constant / slope if slope != 0.0 else np.nan
        return x, np.nan
    p = slope * slope - 4.0 * d * d
    q = slope * constant + 4.0 * d * d * bx
    r = constant * constant - 4.0 * d * d * (bx * bx + w["sy"] * w["sy"])
    discriminant = q * q - p * r
    if discriminant < 0.0:
        return np.nan, np.nan
    t = -(q + np.copysign(np.sqrt(discriminant), q))
    x0 = middle + t / p if p != 0.0 else np.nan
    x1 = middle + r / t if t != 0.0 else np.nan
    if x1 < x0:
        return x1, x0
    return x0, x1


@kernel
def _crossing(a: float, b: float, margin: float, sx: float, sy: float, sigma: float, w: np.void) -> float:
    """Abscissa in [a, b] where the two are equally far; one of them wins at a, the other at b."""
    x0, x1 = _quadratic(a, b, sx, sy, sigma, w)
    if a <= x0 <= b and abs(_lead(x0, sx, sy, sigma, w)) <= 10.0 * margin:
        return x0
    if a <= x1 <= b and abs(_lead(x1, sx, sy, sigma, w)) <= 10.0 * margin:
        return x1
    # The equation was ill-conditioned (nearly equal sources): halve the interval instead.
    rising = _lead(a, sx, sy, sigma, w) < 0.0
    for _ in range(50):
        x = 0.5 * (a + b)
        if (_lead(x, sx, sy, sigma, w) < 0.0) == rising:
            a = x
        else:
            b = x
    return 0.5 * (a + b)


@kernel
def _contest(
    a: float, b: float, margin: float, sliver: float, sx: float, sy: float, sigma: float, w: np.void
) -> tuple[float, float, float]:
    """First stretch [p, q] of [a, b] that the newcomer takes from window w, and where to go on.

    The stretch is empty, p == q, where the window keeps all up to the third value returned.
    """
    at_a, at_b = _lead(a, sx, sy, sigma, w), _lead(b, sx, sy, sigma, w)
    wins_a, wins_b = at_a < -margin, at_b < -margin
    if wins_a != wins_b:
        x = b if wins_a else a  # where the other end is a tie
        if at_a * at_b < 0.0:
            x = _crossing(a, b, margin, sx, sy, sigma, w)
        if wins_a:
            if b - x <= sliver:
                return a, b, b
            return (a, x, b) if x - a > sliver else (b, b, b)
        if x - a <= sliver:
            return a, b, b
        return (x, b, b) if b - x > sliver else (b, b, b)
    # One is ahead at both ends, the other may be in between: not if the lead is more than it can lose, as
    # a distance changes by no more than the length walked, and not for equal sigma (one crossing).
    if w["sigma"] != sigma and min(abs(at_a), abs(at_b)) < 2.0 * (b - a):
        x0, x1 = _quadratic(a, b, sx, sy, sigma, w)
        if x0 > a and x1 < b and x1 - x0 > sliver:
            lead = _lead(0.5 * (x0 + x1), sx, sy, sigma, w)
            if wins_a and lead > margin:
                return a, x0, x1
            if not wins_a and lead < -margin:
                return x0, x1, x1
    if wins_a:
        return a, b, b
    return b, b, b


@inner
def new_pool(n_halfedges: int, capacity: int) -> Pool:
    """A pool that holds the spare window only, in row 0."""
    lists = np.empty(n_halfedges + 1, dtype=LIST)
    for h in range(n_halfedges):
        lists[h]["first"], lists[h]["count"] = -1, 0
    lists[-1]["first"], lists[-1]["count"] = 0, 1
    free = np.empty(1, dtype=LIST)
    free[0]["first"], free[0]["count"] = -1, 0
    windows = np.empty(capacity, dtype=WINDOW)
    windows[0]["next"], windows[0]["pending"] = -1, 0
    return Pool(windows, lists, free, np.ones(1, dtype=np.int64))


@kernel
def spare_list(pool: Pool) -> int:
    """Number of the list of the spare window."""
    return len(pool.lists) - 1


@kernel
def set_spare_window(pool: Pool, lo: float, hi: float, sx: float, sy: float, sigma: float) -> None:
    """Make the spare window, which is on no half-edge, this one, and pending."""
    w = pool.windows[0]
    w["lo"], w["hi"], w["sx"], w["sy"], w["sigma"], w["pending"] = lo, hi, sx, sy, sigma, 1


@inner
def grown_pool(pool: Pool) -> Pool:
    """The same windows in a pool of twice the size; all else is shared."""
    used = pool.used[0]
    windows = np.empty(2 * len(pool.windows), dtype=WINDOW)
    windows[:used] = pool.windows[:used]
    return Pool(windows, pool.lists, pool.free, pool.used)


@kernel
def insertion_room(pool: Pool, h: int) -> bool:
    """Whether the pool has enough free rows for one more window on half-edge h, however it is cut up."""
    return pool.free[0]["count"] + len(pool.windows) - pool.used[0] >= 3 * pool.lists[h]["count"] + 8


@kernel
def _add(pool: Pool, h: int, before: int, lo: float, hi: float, sx: float, sy: float, sigma: float) -> int:
    """Row of a new pending window, linked behind ``before`` (-1: in front) in the list of half-edge h."""
    windows, own, free = pool.windows, pool.lists[h], pool.free[0]
    row = free["first"]
    if row >= 0:
        free["first"] = windows[row]["next"]
        free["count"] -= 1
    else:
        row = pool.used[0]
        pool.used[0] += 1
    w = windows[row]
    own["count"] += 1
    w["lo"], w["hi"], w["sx"], w["sy"], w["sigma"], w["pending"] = lo, hi, sx, sy, sigma, 1
    if before < 0:
        w["next"] = own["first"]
        own["first"] = row
    else:
        w["next"] = windows[before]["next"]
        windows[before]["next"] = row
    return row


@kernel
def _remove_next(pool: Pool, h: int, before: int) -> int:
    """Row that follows ``before`` (-1: the front) once the one behind it is gone."""
    windows, own, free = pool.windows, pool.lists[h], pool.free[0]
    row = own["first"] if before < 0 else windows[before]["next"]
    after = windows[row]["next"]
    if before < 0:
        own["first"] = after
    else:
        windows[before]["next"] = after
    windows[row]["next"] = free["first"]
    free["first"] = row
    free["count"] += 1
    own["count"] -= 1
    return after


@kernel
def insert_window(
    pool: Pool, h: int, length: float, lo: float, hi: float, sx: float, sy: float, sigma: float, hint: int
) -> tuple[float, int]:
    """Smallest distance in what the newcomer took of half-edge h (inf: nothing), and the hint for the next.

    Parameters
    ----------
    hint : int
        Row of the list to start the search at, as returned for a window farther left; -1 for the front.
    """
    windows = pool.windows
    sliver = SLIVER * length
    margin = TIE * (sigma + abs(sx) + sy + length)
    nearest = np.inf
    before = hint if hint >= 0 and windows[hint]["hi"] <= lo else -1
    here = pool.lists[h]["first"] if before < 0 else windows[before]["next"]
    while here >= 0 and windows[here]["hi"] <= lo:
        before, here = here, windows[here]["next"]
    hint = before
    x = lo
    opened = False  # the newcomer holds [start, x] already
    start = lo
    while hi - x > sliver:
        while here >= 0 and windows[here]["hi"] <= x:
            before, here = here, windows[here]["next"]
        if here < 0 or windows[here]["lo"] >= hi:
            if not opened:
                opened, start = True, x
            x = hi
            break
        w = windows[here]
        a, b = max(x, w["lo"]), min(hi, w["hi"])
        if a - x > sliver and not opened:
            opened, start = True, x
        p, q, go_on = b, b, b
        if b - a > sliver:
            p, q, go_on = _contest(a, b, margin, sliver, sx, sy, sigma, w)
        if opened and p > a:  # the window keeps [a, p]
            nearest = min(nearest, nearest_distance(start, a, sx, sy, sigma))
            before = _add(pool, h, before, start, a, sx, sy, sigma)
            opened = False
        x = go_on
        if p == q:
            continue
        keeps_left, keeps_right = p - w["lo"] > sliver, w["hi"] - q > sliver
        if not opened:
            opened, start = True, p if keeps_left else w["lo"]
        if keeps_left and keeps_right:
            row = _add(pool, h, here, q, w["hi"], w["sx"], w["sy"], w["sigma"])
            windows[row]["pending"] = w["pending"]
            w["hi"] = p
            before, here = here, row
        elif keeps_left:
            q = w["hi"]
            w["hi"] = p
            before, here = here, w["next"]
        elif keeps_right:
            w["lo"] = q
        else:
            q = w["hi"]
            here = _remove_next(pool, h, before)
        if keeps_right:  # the newcomer ends where the rest of the window begins
            nearest = min(nearest, nearest_distance(start, q, sx, sy, sigma))
            before = _add(pool, h, before, start, q, sx, sy, sigma)
            opened = False
        else:
            x = max(x, q)
    if opened:
        nearest = min(nearest, nearest_distance(start, x, sx, sy, sigma))
        _add(pool, h, before, start, x, sx, sy, sigma)
    return nearest, hint
