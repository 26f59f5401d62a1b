"""What a vertex sees through a side that it lies on: past triangles without height over their longest side (Numba).

A triangle whose corners lie on one line closes the gap where the edge of one face meets two edges of its neighbours, as
hole fillers and CAD exporters leave it. The corner between the others sees all that is behind the opposite side through
one point of that side, where no interval of it could tell the directions apart. So such views are kept beside the mesh,
by the side through which the vertex looks into a face that it sees at full width, or into the next flat one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.jit import inner, kernel, njit

# Height over a side, as a fraction of its length, up to which a corner has a view. An interval of that width still
# tells directions apart by 1e-10 radian.
FLAT = 1e-6

VIEW = np.dtype(
    [
        ("half", "i8"),  # half-edge looked through, about to cross its face
        ("lo", "f8"),  # the part of it that is seen, from its first vertex
        ("hi", "f8"),
        ("sx", "f8"),  # the vertex that looks: abscissa, and depth behind the half-edge
        ("sy", "f8"),
    ]
)
Records = npt.NDArray[np.void]


@kernel
def split_at(sx: float, sy: float, cx: float, cy: float) -> float:
    """Abscissa at which the ray from (sx, -sy) to the apex (cx, cy) crosses the x-axis."""
    return sx + sy * ((cx - sx) / (sy + cy)) if sy + cy > 0.0 else sx


@kernel
def carried(
    near: float, far: float, sx: float, sy: float, split: float, cx: float, cy: float, side: float
) -> tuple[float, float, float, float]:
    """Window [near, far] of the x-axis as it falls on the side from the origin to the apex (cx, cy).

    The source is at (sx, -sy); its ray through ``split`` meets the apex. Returned are the ends and the source
    in the frame of the side.
    """
    ux, uy = cx / side, cy / side
    lo, hi = 0.0, side
    if near > 0.0:
        along, across = sy * near, ux * sy - uy * (near - sx)
        lo = along / across if along < side * across else side
    if far < split:
        along, across = sy * far, ux * sy - uy * (far - sx)
        hi = along / across if along < side * across else side
    return lo, hi, sx * ux - sy * uy, max(sx * uy + sy * ux, 0.0)


@kernel
def _look_on(view: np.void, onto_left: bool, sides: Records, out: np.void) -> bool:
    """Whether the view goes on through one side of the face with the vertex still on that side; if so, into ``out``."""
    h = view["half"]
    base = 3 * (h // 3)
    own, ahead, back = sides[h], sides[base + (h - base + 1) % 3], sides[base + (h - base + 2) % 3]
    lo, hi, sx, sy, cx, cy = view["lo"], view["hi"], view["sx"], view["sy"], own["cx"], own["cy"]
    split = split_at(sx, sy, cx, cy)
    side = back
    if not onto_left:  # the same, seen from the other end
        length = own["length"]
        side, cx = ahead, own["from_head"]
        lo, hi, sx, split = length - hi, length - lo, length - sx, length - split
    width = side["length"]
    if side["twin"] < 0 or width == 0.0 or lo >= split:
        return False
    lo, hi, sx, sy = carried(lo, hi, sx, sy, split, cx, cy, width)
    if sy > FLAT * width or not 0.0 < sx < width or not lo < hi:
        return False
    if (side["aligned"] != 0) == onto_left:  # the twin starts at the apex
        lo, hi, sx = width - hi, width - lo, width - sx
    out["half"], out["lo"], out["hi"], out["sx"], out["sy"] = side["twin"], lo, hi, sx, sy
    return True


@inner
def _doubled(viewer: IndexArray, views: Records, count: int) -> tuple[IndexArray, Records]:
    """The first so many of both, with room for as many more as there were."""
    more_viewers, more = np.empty(2 * len(views), dtype=np.int64), np.empty(2 * len(views), dtype=VIEW)
    more_viewers[:count], more[:count] = viewer[:count], views[:count]
    return more_viewers, more


@njit()
def _views(sides: Records) -> tuple[IndexArray, Records]:
    """The vertex that looks, and its view, for every flat corner and all flat faces in a row behind it."""
    viewer, views = np.empty(64, dtype=np.int64), np.empty(64, dtype=VIEW)
    looked_through = np.full(len(sides), -1, dtype=np.int64)  # by the corner opposite to which side
    count = 0
    for h in range(len(sides)):
        side = sides[h]
        if side["twin"] < 0 or side["cy"] > FLAT * side["length"] or side["cx"] <= 0.0 or side["from_head"] <= 0.0:
            continue
        vertex = sides[3 * (h // 3) + (h + 2) % 3]["tail"]
        following = count
        view = views[count]
        view["half"], view["lo"], view["hi"], view["sy"] = side["twin"], 0.0, side["length"], side["cy"]
        view["sx"] = side["cx"] if side["aligned"] else side["from_head"]
        viewer[count] = vertex
        count += 1
        while following < count:
            if count + 3 > len(views):  # one by either hand, and the next corner's first
                viewer, views = _doubled(viewer, views, count)
            looked_through[views[following]["half"]] = h
            for onto_left in (True, False):
                goes_on = _look_on(views[following], onto_left, sides, views[count])
                if goes_on and looked_through[views[count]["half"]] != h:
                    viewer[count] = vertex
                    count += 1
            following += 1
    return viewer[:count].copy(), views[:count].copy()


def flat_views(sides: Records, n_vertices: int) -> tuple[IndexArray, Records]:
    """Views by vertex: those of v are ``views[start[v]:start[v + 1]]``; most meshes have none.

    Parameters
    ----------
    sides : (3 m,) of dtype SIDE
        The triangles laid flat, see `unfolding`.
    n_vertices : int

    Returns
    -------
    start : (n + 1,) int64
    views : (v,) of dtype VIEW
    """
    viewer, views = _views(sides)
    start = np.concatenate([[0], np.cumsum(np.bincount(viewer, minlength=n_vertices))])
    return start, views[np.argsort(viewer, kind="stable")]
