"""Maps carried from the vertices at which they were found to more of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.closest_points import with_normals
from qgeo_filters.decimation import Proxy
from qgeo_filters.matching.level import Level
from qgeo_filters.parallel import worker_count
from qgeo_filters.surface import Surface


@dataclass(frozen=True, eq=False)
class CarriedMap:
    """A map between all vertices of two surfaces, in both directions.

    Attributes
    ----------
    p2p : (n_x,) int64
    inverse : (n_y,) int64
    positions : (n_x, 3) float64
        X deformed onto Y, in Y's frame and unit.
    """

    p2p: IndexArray
    inverse: IndexArray
    positions: FloatArray


def carried(positions: FloatArray, x: Proxy, y: Level, target: Surface) -> CarriedMap:
    """Map of the surface of which ``x`` is a proxy onto ``target``, from positions of the proxy on ``y``.

    Each vertex goes where its place on the deformed proxy is, and to the vertex of the target that is nearest there
    and faces the same way.

    Parameters
    ----------
    positions : (m, 3) float64
        The proxy deformed onto ``y.unit``.
    y : Level
        Of the shape whose surface at another resolution is ``target``.
    """
    deformed = x.surface.with_vertices(positions * y.scale + y.centre)
    points, normals = x.pulled_back(deformed.vertices), x.pulled_back(deformed.vertex_normals)
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0)
    here = with_normals(points, normals, target)
    there = with_normals(target.vertices, target.vertex_normals, target)
    p2p = cKDTree(there).query(here, workers=worker_count())[1]
    inverse = cKDTree(here).query(there, workers=worker_count())[1]
    return CarriedMap(np.asarray(p2p, dtype=np.int64), np.asarray(inverse, dtype=np.int64), points)
