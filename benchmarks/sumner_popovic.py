"""Deformation transfer as it was published, in plain NumPy and SciPy: a peer for ``deformation.py``.

Each triangle has a fourth vertex above it, as in the paper, and each target triangle the deformation gradient of the
source triangle that is nearest to its centre at rest. No smoothness term: correspondences are complete.

References
----------
Sumner and Popovic, "Deformation transfer for triangle meshes", SIGGRAPH 2004.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

import qgeo_filters as qg
from qgeo_filters.closest_points import closest_points


class PlainTransfer:
    """Poses of X brought to Y at rest, which lies on X at rest."""

    def __init__(self, x: qg.Surface, y: qg.Surface) -> None:
        self.faces, self.inverses = x.faces, np.linalg.inv(frames(x.vertices, x.faces))
        self.source = closest_points(y.vertices[y.faces].mean(axis=1), x).faces
        n, m = y.n_vertices, y.n_faces
        inverse = np.linalg.inv(frames(y.vertices, y.faces))
        # Column k of the gradient's transpose: sum of corner positions with these weights, the first corner last.
        weights = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
        corners = np.column_stack([y.faces, n + np.arange(m)])
        row = np.repeat(3 * np.arange(m)[:, None, None] + np.arange(3), 4, axis=1)
        column = np.repeat(corners[:, :, None], 3, axis=2)
        matrix = sparse.csc_array((weights.ravel(), (row.ravel(), column.ravel())), (3 * m, n + m))
        # One vertex stays: gradients say nothing of where the whole is.
        self.free, self.fixed = matrix[:, 1:], matrix[:, :1].toarray() @ y.vertices[:1]
        self.factors = splu(
            (self.free.T @ self.free).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        self.first, self.n = y.vertices[:1], n

    def __call__(self, pose: np.ndarray) -> np.ndarray:
        """Positions (n_y, 3) of Y in a pose (n_x, 3) of X, up to where the whole is."""
        gradients = frames(pose, self.faces) @ self.inverses
        wanted = gradients[self.source].transpose(0, 2, 1).reshape(-1, 3)
        found = self.factors.solve(self.free.T @ (wanted - self.fixed))
        return np.concatenate([self.first, found[: self.n - 1]])


def frames(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Two edges of each triangle and its normal over the root of its length, as columns, (m, 3, 3)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True))
    return np.stack([b - a, c - a, normal / length], axis=2)
