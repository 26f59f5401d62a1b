"""As-rigid-as-possible deformation of a surface towards target positions."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable

import igl
import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import splu

from qgeo_filters._typing import FloatArray
from qgeo_filters.deformation.arap_sums import covariances, strain, turned
from qgeo_filters.deformation.fit_rotations import nearest_rotations

Solve = Callable[[FloatArray], FloatArray]

# Obtuse triangles have negative cotangents, which would reward bending; relative to the mean weight.
_LEAST_WEIGHT = 1e-3
# Factorisations that are kept, the last used ones: contenders go through the same pulls one after the other.
_FACTORS = 32


class Rigidity:
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

    def __init__(self, vertices: FloatArray, faces: npt.NDArray[np.int32]) -> None:
        n = len(vertices)
        weights = igl.cotmatrix(vertices, faces.astype(np.int64)).tocoo()
        off = weights.row != weights.col
        values = weights.data[off]
        values = np.maximum(values, _LEAST_WEIGHT * float(np.abs(values).mean()))
        symmetric = sparse.csr_matrix((values, (weights.row[off], weights.col[off])), (n, n))
        starts, heads = symmetric.indptr.astype(np.int64), symmetric.indices.astype(np.int64)
        edges = np.repeat(vertices, np.diff(starts), axis=0) - vertices[heads]
        self._half_edges = starts, heads, symmetric.data, edges
        self._laplacian = sparse.diags_array(np.asarray(symmetric.sum(axis=1)).ravel()) - symmetric
        neighbours = sparse.csr_matrix((np.ones(len(heads)), heads, starts), (n, n)) + sparse.eye_array(n)
        self._mean = sparse.csr_array(sparse.diags_array(1 / np.asarray(neighbours.sum(axis=1)).ravel()) @ neighbours)
        self._factors: OrderedDict[bytes, Solve] = OrderedDict()

    def __getstate__(self) -> dict[str, object]:
        # SuperLU's factors cannot be pickled.
        return {**self.__dict__, "_factors": OrderedDict()}

    def pulled(self, pull: FloatArray) -> Solve:
        """Solver of the positions for right-hand sides (n, 3); factorised once for the pull s (n,)."""
        key = hashlib.sha256(pull.tobytes()).digest()
        solve = self._factors.pop(key, None)
        if solve is None:
            matrix = sparse.csc_matrix(self._laplacian + sparse.diags_array(pull))
            options = {"SymmetricMode": True}
            solve = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve
        self._factors[key] = solve
        if len(self._factors) > _FACTORS:
            self._factors.popitem(last=False)
        return solve

    def release(self) -> None:
        """Forget the factorisations: together they take as much memory as all else of a shape."""
        self._factors.clear()

    def step(
        self, solve: Solve, pull: FloatArray, positions: FloatArray, targets: FloatArray, smooth: int
    ) -> FloatArray:
        """Positions (n, 3) after one turn: rotations, averaged ``smooth`` times over neighbours, then positions."""
        rotations = self._rotations(positions, smooth)
        return solve(turned(*self._half_edges, rotations) + pull[:, None] * targets)

    def strain(self, positions: FloatArray) -> float:
        r"""What is not rigid of a deformation: :math:`\sum_{ij} w_{ij} |p_i - p_j - R_i (x_i - x_j)|^2`."""
        return strain(*self._half_edges, self._rotations(positions, 0), positions)

    def _rotations(self, positions: FloatArray, smooth: int) -> FloatArray:
        sums = covariances(*self._half_edges, positions)
        flat = sums.reshape(-1, 9)
        for _ in range(smooth):
            flat = np.asarray(self._mean @ flat)
        return nearest_rotations(flat.reshape(-1, 3, 3))
