"""Nearest points of convex cones in space, each spanned by a few vectors (Numba)."""

from __future__ import annotations

import numpy as np

from qgeo_filters.jit import inner, njit

# What lies off a cone by less than this fraction of the point's length lies in it.
_ROUNDING = 1e-9


@inner
def _nearest_on_pair(g, h, d, out):  # type: ignore[no-untyped-def]
    """Point of the plane sector between two unit vectors nearest to d, if it is not on one of its rays."""
    c = g[0] * h[0] + g[1] * h[1] + g[2] * h[2]
    dg = d[0] * g[0] + d[1] * g[1] + d[2] * g[2]
    dh = d[0] * h[0] + d[1] * h[1] + d[2] * h[2]
    s, t, size = dg - c * dh, dh - c * dg, 1.0 - c * c
    if size <= 0.0 or s <= 0.0 or t <= 0.0:
        return False
    for i in range(3):
        out[i] = (s * g[i] + t * h[i]) / size
    return True


@inner
def _project(cone, d, best, trial):  # type: ignore[no-untyped-def]
    """Nearest point to d of the cone of these unit vectors (k, 3), into ``best``.

    It is d itself, or lies on the surface of the cone: on the sector of two vectors, on one vector, or at the apex.
    """
    best[:] = 0.0
    least = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    slack = _ROUNDING * np.sqrt(least)
    for i in range(len(cone)):
        along = d[0] * cone[i, 0] + d[1] * cone[i, 1] + d[2] * cone[i, 2]
        for j in range(i, len(cone)):
            if j == i:
                if along <= 0.0:
                    continue
                for k in range(3):
                    trial[k] = along * cone[i, k]
            elif not _nearest_on_pair(cone[i], cone[j], d, trial):
                continue
            gap = (d[0] - trial[0]) ** 2 + (d[1] - trial[1]) ** 2 + (d[2] - trial[2]) ** 2
            if gap < least:
                least = gap
                best[:] = trial
    # The nearest point of a convex cone leaves no vector of it on the side of d; where it does, d is inside.
    for i in range(len(cone)):
        if ((d[0] - best[0]) * cone[i, 0] + (d[1] - best[1]) * cone[i, 1] + (d[2] - best[2]) * cone[i, 2]) > slack:
            best[:] = d
            return


@njit()
def projected_on_cones(vectors, start, member, points):  # type: ignore[no-untyped-def]
    """Nearest point to each of the points (n, 3) in its cone, spanned by ``vectors[member[start[i] : start[i + 1]]]``.

    Vectors (m, 3) are of unit length, or zero, which span nothing.
    """
    nearest = np.empty_like(points)
    trial = np.empty(3)
    most = 0
    for i in range(len(points)):
        most = max(most, start[i + 1] - start[i])
    cone = np.empty((most, 3))
    for i in range(len(points)):
        size = 0
        for e in range(start[i], start[i + 1]):
            g = vectors[member[e]]
            if g[0] != 0.0 or g[1] != 0.0 or g[2] != 0.0:
                cone[size] = g
                size += 1
        _project(cone[:size], points[i], nearest[i], trial)
    return nearest
