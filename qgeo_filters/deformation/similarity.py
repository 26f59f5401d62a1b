"""Turn, size and shift that bring points onto others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray


@dataclass(frozen=True, eq=False)
class Similarity:
    """x -> scale * rotation x + shift.

    Attributes
    ----------
    scale : float
    rotation : (3, 3) float64
        Its determinant is 1.
    shift : (3,) float64
    """

    scale: float
    rotation: FloatArray
    shift: FloatArray

    @classmethod
    def between(
        cls, points: FloatArray, targets: FloatArray, weights: FloatArray, scale: float | None = None
    ) -> Similarity:
        """The one, of a given scale or any, that brings points (k, 3) nearest to their targets in the mean square.

        References
        ----------
        Umeyama, "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991.
        """
        share = weights / weights.sum()
        centre, other = share @ points, share @ targets
        here, there = points - centre, targets - other
        u, s, vt = np.linalg.svd((there * share[:, None]).T @ here)
        signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt)) or 1.0])
        rotation = (u * signs) @ vt
        if scale is None:
            spread = float(share @ np.einsum("ij,ij->i", here, here))
            scale = float(s @ signs) / spread if spread > 0 else 1.0
        return cls(scale, rotation, other - scale * rotation @ centre)

    @classmethod
    def identity(cls) -> Similarity:
        """The one that changes nothing."""
        return cls(1.0, np.eye(3), np.zeros(3))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Points (..., 3), brought there."""
        moved: FloatArray = self.scale * points @ self.rotation.T + self.shift
        return moved
