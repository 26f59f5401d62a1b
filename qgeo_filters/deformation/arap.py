"""As-rigid-as-possible deformation of a surface towards target positions."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass

import igl
import numpy as np
from scipy import sparse

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.cholesky import factorised_spd
from qgeo_filters.deformation.arap_sums import covariances, rotated_edge_sums, rotation_misfit
from qgeo_filters.deformation.fit_rotations import fit_rotations

Solve = Callable[[FloatArray], FloatArray]

# Obtuse triangles have negative cotangents, which would reward bending; relative to the mean weight.
_LEAST_WEIGHT = 1e-3
# Flat triangles have infinite ones; relative to the median weight. Thin ones of real meshes come to four thousand.
_MOST_WEIGHT = 1e4
# Factorisations that are kept, the last used ones: maps of one shape go through the same pulls one after the other.
_FACTORS = 32


@dataclass(frozen=True, eq=False)
class Pull:
    """How strongly each vertex is drawn to its target.

    Attributes
    ----------
    key : hashable
        Equal for pulls that are equal, of one surface.
    values : (n,) float64
        s in the energy of `ArapSolver`: an area over a squared length.
    """

    key: Hashable
    values: FloatArray


class ArapSolver:
    r"""Deformations of a surface that keep each vertex's neighbourhood as rigid as possible.

    Minimises :math:`\sum_{ij} w_{ij} |p_i - p_j - R_i (x_i - x_j)|^2 + \sum_i s_i |p_i - q_i|^2` over positions p and
    rotations R, in turns, for targets q. With the pull :math:`s_i = a_i / h^2`, a the areas, details below the
    length h are not followed.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int

    References
    ----------
    Sorkine and Alexa, "As-rigid-as-possible surface modeling", SGP 2007.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        n = len(vertices)
        weights = igl.cotmatrix(vertices, faces.astype(np.int64)).tocoo()
        off = weights.row != weights.col
        values = _bounded(weights.data[off])
        symmetric = sparse.csr_matrix((values, (weights.row[off], weights.col[off])), (n, n))
        starts, heads = symmetric.indptr.astype(np.int64), symmetric.indices.astype(np.int64)
        edges = np.repeat(vertices, np.diff(starts), axis=0) - vertices[heads]
        self._half_edges = starts, heads, symmetric.data, edges
        self._laplacian = sparse.diags_array(np.asarray(symmetric.sum(axis=1)).ravel()) - symmetric
        neighbours = sparse.csr_matrix((np.ones(len(heads)), heads, starts), (n, n)) + sparse.eye_array(n)
        self._mean = sparse.csr_array(sparse.diags_array(1 / np.asarray(neighbours.sum(axis=1)).ravel()) @ neighbours)
        self._factors: OrderedDict[Hashable, Solve] = OrderedDict()

    def __getstate__(self) -> dict[str, object]:
        # Factorisations cannot be pickled.
        return {**self.__dict__, "_factors": OrderedDict()}

    @property
    def n_factorised(self) -> int:
        """Number of factorisations that are kept."""
        return len(self._factors)

    def prefactor(self, pull: Pull) -> Solve:
        """Solver of the positions for right-hand sides (n, 3), factorised once for each pull.

        Call it in the thread that calls `release`, see `cholesky`; the solver that it returns may be called in any.
        """
        solve = self._factors.pop(pull.key, None)
        if solve is None:
            solve = factorised_spd(sparse.csc_matrix(self._laplacian + sparse.diags_array(pull.values)))
        self._factors[pull.key] = solve
        if len(self._factors) > _FACTORS:
            self._factors.popitem(last=False)
        return solve

    def release(self) -> None:
        """Forget the factorisations: together they take as much memory as all else of a shape."""
        self._factors.clear()

    def iterate(
        self, solve: Solve, pull: Pull, positions: FloatArray, targets: FloatArray, smoothing: int
    ) -> FloatArray:
        """Positions (n, 3) after a local step, averaged ``smoothing`` times over neighbours, and a global one."""
        rotations = self._rotations(positions, smoothing)
        return solve(rotated_edge_sums(*self._half_edges, rotations) + pull.values[:, None] * targets)

    def energy(self, positions: FloatArray) -> float:
        r"""What is not rigid of a deformation: :math:`\sum_{ij} w_{ij} |p_i - p_j - R_i (x_i - x_j)|^2`."""
        return rotation_misfit(*self._half_edges, self._rotations(positions, 0), positions)

    def _rotations(self, positions: FloatArray, smoothing: int) -> FloatArray:
        sums = covariances(*self._half_edges, positions)
        flat = sums.reshape(-1, 9)
        for _ in range(smoothing):
            flat = np.asarray(self._mean @ flat)
        return fit_rotations(flat.reshape(-1, 3, 3))


def _bounded(cotangents: FloatArray) -> FloatArray:
    """Weights for which the system is positive definite and can be solved, whatever the triangles."""
    # The two infinities of a flat triangle beside another flat one make NaN.
    most = _MOST_WEIGHT * float(np.median(np.abs(cotangents[np.isfinite(cotangents)])))
    weights = np.clip(np.nan_to_num(cotangents, nan=0.0), -most, most)
    return np.maximum(weights, _LEAST_WEIGHT * float(np.abs(weights).mean()))
