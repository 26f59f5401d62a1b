"""Point maps and functional maps: from one to the other, and to higher frequencies.

Direction: ``p2p[i]`` is the point of Y for point i of X. A functional map C (k_x, k_y) takes the coordinates of
X's points in X's eigenfunctions to those in Y's: ``phi_x @ C`` approximates ``phi_y[p2p]``.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.parallel import worker_count

# Rows of the similarity matrix at once.
_BLOCK = 1024
# Rows from which on a search is shared by all cores.
_THREADED = 3000


def nearest_neighbors(points: npt.NDArray, others: npt.NDArray) -> IndexArray:
    """Row of others (m, d) nearest to each row of points (..., n, d), shape (..., n); the first of equals."""
    half = 0.5 * np.einsum("ij,ij->i", others, others)
    rows = points.reshape(-1, points.shape[-1])
    result = np.empty(len(rows), dtype=np.int64)
    for first in range(0, len(rows), _BLOCK):
        similarity = rows[first : first + _BLOCK] @ others.T
        similarity -= half
        result[first : first + _BLOCK] = similarity.argmax(axis=1)
    return result.reshape(points.shape[:-1])


def nearest_neighbors_both_ways(
    points: npt.NDArray, others: npt.NDArray, tree: cKDTree | None = None
) -> tuple[IndexArray, IndexArray]:
    """Nearest row of others (m, d) to each of points (n, d), and the reverse, shapes (n,) and (m,).

    Both lie near surfaces: a few columns, such as positions, should vary by much more than the rest, so that a tree
    leaves out most rows; for eigenfunctions alone `nearest_neighbors` is faster. ``tree`` is that of others, if it is
    there already.
    """
    workers = 1 if max(len(points), len(others)) < _THREADED else worker_count()
    forth = (cKDTree(others) if tree is None else tree).query(points, workers=workers)[1]
    back = cKDTree(points).query(others, workers=workers)[1]
    return np.asarray(forth, dtype=np.int64), np.asarray(back, dtype=np.int64)


def functional_map(
    basis_x: npt.NDArray, basis_y: npt.NDArray, p2p: IndexArray, weights: npt.NDArray | None = None
) -> npt.NDArray:
    """Least-squares functional map C (..., k_x, k_y) of point maps: ``basis_x @ C`` close to ``basis_y[p2p]``.

    Parameters
    ----------
    basis_x : (n, k_x), or a stack (..., n, k_x)
    basis_y : (m, k_y)
    p2p : (n,) int, or a stack (..., n)
    weights : (n,), optional
        Area of each point of X; equal by default.
    """
    left = basis_x if weights is None else basis_x * weights[:, None]
    across = np.swapaxes(left, -1, -2)
    return np.linalg.solve(across @ basis_x, across @ basis_y[p2p])


def procrustes(functional: npt.NDArray) -> npt.NDArray:
    """Nearest orthogonal matrix (polar projection), also of a stack (..., k, k)."""
    u, _, v = np.linalg.svd(functional)
    return u @ v


def zoomout(
    basis_x: npt.NDArray, basis_y: npt.NDArray, p2p: IndexArray, points: IndexArray, sizes: Iterable[int]
) -> npt.NDArray:
    """Functional map (k, k) of the largest size, from a point map of some points, by spectral upsampling.

    Parameters
    ----------
    basis_x, basis_y : (n_x, k), (n_y, k)
        Eigenfunctions of both shapes.
    p2p : (s,) int
        Vertex of Y for each of ``points``.
    points : (s,) int
        Vertices of X.
    sizes : iterable of int
        Numbers of eigenfunctions, increasing.

    References
    ----------
    Melzi, Ren, Rodola, Sharma, Wonka, Ovsjanikov, "ZoomOut: spectral upsampling for efficient shape
    correspondence", SIGGRAPH Asia 2019.
    """
    result = None
    for k in sizes:
        if result is not None:
            width = result.shape[0]
            p2p = nearest_neighbors(basis_x[points, :width] @ result, basis_y[:, :width])
        result = procrustes(functional_map(basis_x[points, :k], basis_y[:, :k], p2p))
    if result is None:
        raise ParameterError("spectral upsampling needs at least one number of eigenfunctions")
    return result
