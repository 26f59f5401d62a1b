"""Positions of a surface's vertices from the gradients that its triangles should have."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.cholesky import factorised_spd
from qgeo_filters.jit import njit
from qgeo_filters.surface import Surface
from qgeo_filters.triangle_geometry import face_crosses

# Least area of a triangle, relative to its longest side squared: thinner ones would weigh without bound.
_THIN = 1e-6
# Least part of the area that a vertex stands for, of an equal share.
_LEAST_SHARE = 1e-6


class PoissonSolver:
    r"""Surfaces whose triangles are deformed as prescribed, all by one factorisation.

    Minimises :math:`\sum_f a_f |\nabla p - T_f \nabla v|_f^2 + \sum_i s_i |p_i - q_i|^2` over positions p, for a
    gradient T of each triangle from its rest position v and targets q.

    Parameters
    ----------
    vertices : (n, 3) float64
        At rest.
    faces : (m, 3) int
    pull : (n,) float64
        s: an area over a squared length. Each piece of the surface needs a vertex where it is positive.

    References
    ----------
    Sumner and Popovic, "Deformation transfer for triangle meshes", SIGGRAPH 2004; Botsch, Sumner, Pauly, Gross,
    "Deformation transfer for detail-preserving surface editing", VMV 2006, for the Laplacian on the left.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray, pull: FloatArray) -> None:
        self._faces: npt.NDArray[np.int64] = np.ascontiguousarray(faces, dtype=np.int64)
        self._vertices = np.ascontiguousarray(vertices)
        self._cotangents = half_cotangents(vertices, faces)
        self.pull = pull
        self._solve = factorised_spd(poisson_matrix(self._faces, self._cotangents, pull), points=vertices)

    def __call__(self, gradients: FloatArray, targets: FloatArray) -> FloatArray:
        """Positions (n, 3) for gradients (m, 3, 3) and targets (n, 3)."""
        right = gradient_sums(self._vertices, self._faces, self._cotangents, np.ascontiguousarray(gradients))
        return np.ascontiguousarray(self._solve(right + self.pull[:, None] * targets))


def poisson_matrix(faces: npt.NDArray[np.int64], cotangents: FloatArray, pull: FloatArray) -> sparse.csc_matrix:
    """The system (n, n) of `PoissonSolver`: cotangent Laplacian, and the pull on its diagonal."""
    n = len(pull)
    i, j = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    weights = cotangents.ravel()
    off = sparse.coo_array((np.concatenate([weights, weights]), (np.r_[i, j], np.r_[j, i])), (n, n)).tocsr()
    diagonal = np.asarray(off.sum(axis=1)).ravel() + pull
    return sparse.csc_matrix(sparse.diags_array(diagonal) - off)


def area_shares(surface: Surface) -> FloatArray:
    """Part of the area of each vertex, (n,); a little for those without any, so that each is somewhere."""
    shares = surface.vertex_areas / surface.area if surface.area > 0 else np.zeros(surface.n_vertices)
    return np.maximum(shares, _LEAST_SHARE / surface.n_vertices)


def half_cotangents(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Half the cotangent of the angle at each corner, (m, 3); bounded for triangles that are thinner than a hair."""
    double = np.linalg.norm(face_crosses(vertices, faces), axis=1)
    sides = np.stack([vertices[faces[:, (k + 2) % 3]] - vertices[faces[:, (k + 1) % 3]] for k in range(3)])
    squared = np.einsum("kij,kij->ki", sides, sides)
    double = np.maximum(double, _THIN * squared.max(axis=0))
    dots = 0.5 * (squared.sum(axis=0) - 2 * squared)
    return np.ascontiguousarray(np.divide(dots, 2 * double, out=np.zeros_like(dots), where=double > 0).T)


@njit()
def gradient_sums(
    vertices: FloatArray, faces: npt.NDArray[np.int64], cotangents: FloatArray, gradients: FloatArray
) -> FloatArray:
    """Sum of w T_f (v_i - v_j) over the triangles around each vertex, (n, 3): the divergence of the gradients."""
    result = np.zeros((len(vertices), 3))
    for t in range(len(faces)):
        for corner in range(3):
            i, j = faces[t, (corner + 1) % 3], faces[t, (corner + 2) % 3]
            weight = cotangents[t, corner]
            for a in range(3):
                moved = 0.0
                for b in range(3):
                    moved += gradients[t, a, b] * (vertices[i, b] - vertices[j, b])
                result[i, a] += weight * moved
                result[j, a] -= weight * moved
    return result
