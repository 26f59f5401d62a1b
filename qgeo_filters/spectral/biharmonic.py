"""Smooth interpolation over a surface from its values at some vertices."""

from __future__ import annotations

from collections.abc import Callable

import igl
import numpy as np
from scipy import sparse

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.cholesky import factorised_spd
from qgeo_filters.geodesics.metric import LiftedMetric

Product = Callable[[FloatArray], FloatArray]

# Triangles are kept from degenerating by this fraction of the mean side (Sharp and Crane, SGP 2020, sec. 4.5).
_MOLLIFY = 1e-5
# Blocks of unknowns that are not dissected further.
_LEAF = 100


def biharmonic_interpolation(metric: LiftedMetric, points: IndexArray) -> tuple[Product, Product]:
    r"""Products with the matrix W (n, m) that interpolates from m vertices, and with its transpose.

    W g is the minimiser of :math:`\int (\Delta f)^2` among the functions with values g at the vertices, in the metric
    given; constants are reproduced. Boundaries are free. One factorisation serves all products.

    Returns
    -------
    spread : callable, (m, j) -> (n, j)
    gathered : callable, (n, j) -> (m, j)
    """
    n = metric.surface.n_vertices
    stiffness, areas = intrinsic_laplacian(metric)
    energy = (stiffness @ sparse.diags_array(1 / areas) @ stiffness).tocsr()
    unknown = np.setdiff1d(np.arange(n), points)
    if unknown.size == 0:
        place = np.argsort(points)
        return (lambda values: values[place]), (lambda values: values[points])
    # The orderings that come with SuperLU take minutes where nested dissection takes a second.
    unknown = unknown[_nested_dissection(energy[unknown][:, unknown], metric.surface.vertices[unknown])]
    coupling = energy[unknown][:, points]
    solve = factorised_spd(energy[unknown][:, unknown].tocsc(), ordering="NATURAL")

    def spread(values: FloatArray) -> FloatArray:
        result = np.empty((n, values.shape[1]))
        result[points] = values
        result[unknown] = -solve(coupling @ values)
        return result

    def gathered(values: FloatArray) -> FloatArray:
        return values[points] - coupling.T @ solve(values[unknown])

    return spread, gathered


def intrinsic_laplacian(metric: LiftedMetric) -> tuple[sparse.csc_matrix, FloatArray]:
    """Positive semidefinite cotangent matrix of the intrinsic Delaunay triangulation, and vertex areas (n,).

    From side lengths alone, in units of the mean side; the triangles are mollified first.
    """
    sides = metric.intrinsic("the interpolation over the surface").lengths
    sides = sides / sides.mean()
    excess = 2 * sides.max(axis=1) - sides.sum(axis=1)  # longest side less the two others: negative in a triangle
    sides = sides + max(0.0, float(excess.max()) + _MOLLIFY)
    # libigl wants the side opposite to each corner: side k runs from corner k to corner k + 1.
    opposite = np.ascontiguousarray(np.roll(sides, -1, axis=1))
    lengths, faces = igl.intrinsic_delaunay_triangulation(opposite, metric.surface.faces.astype(np.int64))[:2]
    areas = np.zeros(metric.surface.n_vertices)
    np.add.at(areas, faces.ravel(), np.repeat(igl.doublearea(lengths, 0.0) / 6, 3))
    return -igl.cotmatrix_intrinsic(lengths, faces), areas


def _nested_dissection(pattern: sparse.csr_matrix, positions: FloatArray) -> IndexArray:
    """Elimination order (n,) of a symmetric sparse matrix whose unknowns lie on a surface.

    Halves the unknowns across their longest extent, puts those of one half that touch the other last, and goes on
    within each half (George, "Nested dissection of a regular finite element mesh", 1973).
    """
    n = pattern.shape[0]
    order = np.empty(n, dtype=np.int64)
    half_of = np.zeros(n, dtype=np.int64)
    pending = [(np.arange(n), n)]  # unknowns, and where their block of the order ends
    cut = 0
    while pending:
        block, end = pending.pop()
        if len(block) > _LEAF:
            middle = len(block) // 2
            axis = np.ptp(positions[block], axis=0).argmax()
            split = np.argpartition(positions[block, axis], middle)
            one, other = block[split[:middle]], block[split[middle:]]
            cut += 1
            half_of[other] = cut
            rows = pattern[one]
            touching = (
                np.bincount(np.repeat(np.arange(len(one)), np.diff(rows.indptr)), half_of[rows.indices] == cut) > 0
            )
            if not touching.all():
                separator, one = one[touching], one[~touching]
                order[end - len(separator) : end] = separator
                end -= len(separator)
                pending += [(other, end), (one, end - len(other))]
                continue
        order[end - len(block) : end] = block
    return order
