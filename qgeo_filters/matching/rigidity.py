"""As-rigid-as-possible deformation of a surface towards target positions."""

from __future__ import annotations

from collections.abc import Callable

import igl
import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import splu

FloatArray = npt.NDArray[np.float64]
Solve = Callable[[FloatArray], FloatArray]

# Obtuse triangles have negative cotangents, which would reward bending; relative to the mean weight.
_LEAST_WEIGHT = 1e-3


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
        self._tail, self._head = weights.row[off].astype(np.int64), weights.col[off].astype(np.int64)
        values = weights.data[off]
        self._weight = np.maximum(values, _LEAST_WEIGHT * float(np.abs(values).mean()))
        self._edge = vertices[self._tail] - vertices[self._head]
        count = len(self._weight)
        self._gather = sparse.csr_matrix((np.ones(count), (self._tail, np.arange(count))), (n, count))
        symmetric = sparse.csr_matrix((self._weight, (self._tail, self._head)), (n, n))
        self._laplacian = sparse.diags_array(np.asarray(symmetric.sum(axis=1)).ravel()) - symmetric
        neighbours = sparse.csr_matrix((np.ones(count), (self._tail, self._head)), (n, n)) + sparse.eye_array(n)
        self._mean = sparse.diags_array(1 / np.asarray(neighbours.sum(axis=1)).ravel()) @ neighbours

    def pulled(self, pull: FloatArray) -> Solve:
        """Solver of the positions for right-hand sides (n, 3); factorised once for the pull s (n,)."""
        matrix = sparse.csc_matrix(self._laplacian + sparse.diags_array(pull))
        options = {"SymmetricMode": True}
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve

    def step(
        self, solve: Solve, pull: FloatArray, positions: FloatArray, targets: FloatArray, smooth: int
    ) -> FloatArray:
        """Positions (n, 3) after one turn: rotations, averaged ``smooth`` times over neighbours, then positions."""
        rotations = self._rotations(positions, smooth)
        between = 0.5 * (rotations[self._tail] + rotations[self._head])
        turned = self._weight[:, None] * np.einsum("eab,eb->ea", between, self._edge)
        return solve(self._gather @ turned + pull[:, None] * targets)

    def strain(self, positions: FloatArray) -> float:
        r"""What is not rigid of a deformation: :math:`\sum_{ij} w_{ij} |p_i - p_j - R_i (x_i - x_j)|^2`."""
        rotations = self._rotations(positions, 0)
        turned = np.einsum("eab,eb->ea", rotations[self._tail], self._edge)
        rest = positions[self._tail] - positions[self._head] - turned
        return float(self._weight @ np.einsum("ea,ea->e", rest, rest))

    def _rotations(self, positions: FloatArray, smooth: int) -> FloatArray:
        moved = positions[self._tail] - positions[self._head]
        outer = (self._weight[:, None, None] * moved[:, :, None] * self._edge[:, None, :]).reshape(-1, 9)
        covariance = self._gather @ outer
        for _ in range(smooth):
            covariance = self._mean @ covariance
        u, _, v = np.linalg.svd(covariance.reshape(-1, 3, 3))
        reflected = np.linalg.det(u @ v) < 0
        u[reflected, :, 2] *= -1
        return u @ v
