"""Jets: the height of a surface over a tangent plane at each vertex, as a polynomial fitted to its neighbourhood."""

from __future__ import annotations

from math import comb
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.parallel import concurrently
from qgeo_filters.surface import Surface

#: Degree of the polynomials. With a quadric the curvatures are off by (r / R)^2, r the radius of the neighbourhood and
#: R that of curvature, since arcs are taken for parabolas; with terms to the fourth order, by (r / R)^4.
DEGREE: Final = 4
#: Rings of the narrow neighbourhood, which sees the detail of a coarse mesh; two leave noise as it is.
NARROW: Final = 3
#: The wide neighbourhood counts in full where the polynomial misses it by no more than it misses the narrow one (ratio
#: of the variances), as it does where noise is all that is missed, and not at all where it misses much more: detail.
AS_GOOD, WORSE = 1.5, 3.0
#: A neighbour weighs as the cosine between the two normals to this power, so that the neighbourhood ends where the
#: surface turns away.
NORMAL_POWER: Final = 4
#: Weight of the coefficients of third and fourth order themselves beside the residuals: these orders follow what many
#: points say and not the noise of a few, at the boundary and where vertices lie in few rows.
RIDGE: Final = 1e-3

_MONOMIALS: Final = [(total - j, j) for total in range(DEGREE + 1) for j in range(total + 1)]
_SIZE: Final = len(_MONOMIALS)
_QUADRIC: Final = 6
# The root of each coefficient's penalty: their sum over an order does not depend on the choice of the axes.
_PENALTIES: Final = np.array([np.sqrt(RIDGE / comb(i + j, j)) if i + j > 2 else 0.0 for i, j in _MONOMIALS])
# A column of a quadric that the columns before it determine up to this says nothing of its own.
_DEPENDENT: Final = 1e-6
# Rings do not run on through a vertex of more neighbours: the rim of a fan is not one neighbourhood, and its pairs
# would fill the memory.
_HUB: Final = 50
# Neighbours in a block of vertices that are fitted together.
_BLOCK: Final = 50_000


class Jets(NamedTuple):
    """Heights z(x, y) to second order at each vertex, in a frame of its own.

    Attributes
    ----------
    frames : (n, 3, 3) float64
        Rows: the axes x and y, then the angle-weighted normal.
    gradients : (n, 2) float64
        Slopes of the surface in its frame.
    hessians : (n, 2, 2) float64
        Second derivatives, in units of 1 / length.
    fitted : (n,) bool
        Whether the neighbours determine a quadric: six points or more, not all on one conic. Elsewhere all is zero.
    """

    frames: FloatArray
    gradients: FloatArray
    hessians: FloatArray
    fitted: npt.NDArray[np.bool_]


class _Fits(NamedTuple):
    """Jets of one size of neighbourhood, and the variance (n,) of the heights that they miss."""

    gradients: FloatArray
    hessians: FloatArray
    fitted: npt.NDArray[np.bool_]
    variances: FloatArray


def fitted_jets(surface: Surface, rings: int) -> Jets:
    """Jet of each vertex, by weighted least squares over the vertices within some rings of neighbours.

    A second jet is fitted to the narrow neighbourhood, and the two are mixed by how much worse the wide one describes
    its points. Neither the numbering of the vertices nor position, rotation or scale matter, but for rounding.

    References
    ----------
    Cazals, Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2005.
    """
    frames = _frames(surface.vertex_normals)
    adjacency = _adjacency(surface)
    wide = _fits(surface, frames, adjacency, rings)
    if rings <= NARROW:
        return Jets(frames, wide.gradients, wide.hessians, wide.fitted)
    narrow = _fits(surface, frames, adjacency, NARROW)
    share = _share_of_wide(adjacency, narrow, wide)
    gradients = narrow.gradients + share[:, None] * (wide.gradients - narrow.gradients)
    hessians = narrow.hessians + share[:, None, None] * (wide.hessians - narrow.hessians)
    return Jets(frames, gradients, hessians, narrow.fitted | wide.fitted)


def _share_of_wide(adjacency: sparse.csr_matrix, narrow: _Fits, wide: _Fits) -> FloatArray:
    """Share (n,) of the wide jets, by the variances in the mean over each vertex and its neighbours."""
    both = narrow.fitted & wide.fitted
    small, large = (adjacency @ np.where(both, fits.variances, 0.0) for fits in (narrow, wide))
    whole = (WORSE - AS_GOOD) * small
    share = np.clip(WORSE * small - large, 0, whole) / np.maximum(whole, np.finfo(float).tiny)
    return np.where(both, share, wide.fitted.astype(float))


def _frames(normals: FloatArray) -> FloatArray:
    """An orthonormal frame about each normal, (n, 3, 3); zero where the normal is."""
    across = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    x = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    return np.stack([x, np.cross(normals, x), normals], axis=1)


def _adjacency(surface: Surface) -> sparse.csr_matrix:
    """Ones for each vertex, its neighbours and itself."""
    a, b = surface.edges.T
    itself = np.arange(surface.n_vertices)
    ends = np.concatenate([a, b, itself]), np.concatenate([b, a, itself])
    return sparse.csr_matrix((np.ones(len(ends[0]), dtype=np.int32), ends), shape=(len(itself), len(itself)))


def _fits(surface: Surface, frames: FloatArray, adjacency: sparse.csr_matrix, rings: int) -> _Fits:
    n, normals = surface.n_vertices, surface.vertex_normals
    fits = _Fits(np.zeros((n, 2)), np.zeros((n, 2, 2)), np.zeros(n, dtype=bool), np.zeros(n))

    reach, blocks = _neighbourhoods(adjacency, rings)

    def fit(block: IndexArray) -> None:
        first, end = reach.indptr[block], reach.indptr[block + 1]
        at = first[:, None] + np.arange((end - first).max())
        inside = at < end[:, None]
        neighbours = reach.indices[np.where(inside, at, 0)]
        local = (surface.vertices[neighbours] - surface.vertices[block, None]) @ frames[block].transpose(0, 2, 1)
        cosines = (normals[neighbours] @ normals[block, :, None])[..., 0]
        weights = np.where(inside, np.maximum(cosines, 0.0), 0.0) ** NORMAL_POWER
        for whole, values in zip(fits, _fit(local, weights), strict=True):
            whole[block] = values

    concurrently(fit, blocks)
    return fits


def _neighbourhoods(adjacency: sparse.csr_matrix, rings: int) -> tuple[sparse.csr_matrix, list[IndexArray]]:
    """Neighbours of each vertex and itself, as rows of a matrix, and all vertices in blocks of as many neighbours."""
    valences = np.diff(adjacency.indptr)
    start = np.repeat(np.arange(len(valences)), valences)
    through = adjacency.copy()
    through.data[(valences[start] > _HUB) & (through.indices != start)] = 0
    through.eliminate_zeros()
    reach = adjacency
    for _ in range(rings - 1):
        reach = reach @ through
        reach.data[:] = 1  # else the number of ways to a neighbour grows without bound
    counts = np.diff(reach.indptr)
    # Vertices of about as many neighbours stand together, so that little is filled up.
    order = np.argsort(counts, kind="stable")
    full = np.diff(np.cumsum(counts[order], dtype=np.int64) // _BLOCK) > 0
    bounds = np.flatnonzero(full | (np.diff(np.log2(counts[order]).astype(int)) > 0)) + 1
    return reach, np.split(order, bounds)


def _fit(local: FloatArray, weights: FloatArray) -> _Fits:
    """Polynomials through points (b, m, 3) with weights (b, m), each at its origin."""
    total, count = weights.sum(axis=1), np.count_nonzero(weights, axis=1)
    squared = np.einsum("bm,bmi,bmi->b", weights, local[..., :2], local[..., :2])
    fitted = (count >= _QUADRIC) & (squared > 0)
    # In units of the neighbourhood's own radius, which the ridge is relative to.
    unit = np.sqrt(np.divide(squared, total, out=np.ones_like(total), where=fitted))
    x, y, z = np.moveaxis(local / unit[:, None, None], 2, 0)
    powers = [(np.ones_like(x), np.ones_like(y))]
    for _ in range(DEGREE):
        powers.append((powers[-1][0] * x, powers[-1][1] * y))
    penalties = np.sqrt(total)[:, None] * _PENALTIES
    m = weights.shape[1]
    system = np.empty((len(local), m + _SIZE, _SIZE + 1))
    for column, (i, j) in enumerate(_MONOMIALS):
        np.multiply(powers[i][0], powers[j][1], out=system[:, :m, column])
    system[:, :m, -1] = z
    system[:, :m] *= np.sqrt(weights)[..., None]
    system[:, m:] = penalties[:, :, None] * np.eye(_SIZE, _SIZE + 1)
    triangle = np.asarray(np.linalg.qr(system, mode="r"))  # NumPy's types promise a pair here
    pivots = np.abs(np.einsum("bii->bi", triangle))
    sizes = np.linalg.norm(system[:, :, :_QUADRIC], axis=1)
    fitted &= ((pivots[:, :_QUADRIC] > _DEPENDENT * sizes) & (sizes > 0)).all(axis=1)
    triangle[~fitted] = np.eye(_SIZE + 1)
    inverse = np.linalg.inv(triangle[:, :_SIZE, :_SIZE])
    coefficients = (inverse @ triangle[:, :_SIZE, -1:])[..., 0] * fitted[:, None]
    _, x, y, xx, xy, yy, *_ = coefficients.T
    hessians = np.stack([2 * xx, xy, xy, 2 * yy], axis=1).reshape(-1, 2, 2) / unit[:, None, None]
    # The last pivot is what is missed and what is penalised; a penalised coefficient is no whole degree of freedom.
    missed = np.maximum(pivots[:, -1] ** 2 - ((penalties * coefficients) ** 2).sum(axis=1), 0.0)
    freedom = count - _SIZE + ((penalties[:, :, None] * inverse) ** 2).sum(axis=(1, 2))
    mean = np.divide(missed, total, out=np.zeros_like(total), where=fitted)
    variances = mean * unit**2 * count / np.maximum(freedom, 0.5)
    return _Fits(np.column_stack([x, y]), hessians, fitted, variances)
