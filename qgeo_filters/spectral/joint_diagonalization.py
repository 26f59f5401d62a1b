"""How far operators are from commuting, and the orthogonal basis that comes closest to diagonalising them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError

# Relative asymmetry that rounding may leave in a matrix that is symmetric by construction.
_SYMMETRIC = 1e-8


@dataclass(frozen=True, eq=False)
class JointDiagonalization:
    """The basis in which several symmetric matrices are as diagonal as one basis can make them.

    Attributes
    ----------
    basis : (k, k) float64
        Orthogonal, one basis vector in each column, by decreasing total size of the diagonal.
    diagonals : (m, k) float64
        Diagonal of ``basis.T @ matrices[i] @ basis``: the joint eigenvalues, where the matrices commute.
    residual : float
        Off-diagonal share of the squared Frobenius norms in this basis, 0 to 1; 0 for commuting matrices.
    sweeps : int
        Passes over all pairs of axes.
    """

    basis: FloatArray
    diagonals: FloatArray
    residual: float
    sweeps: int


def commutator_norm(a: npt.ArrayLike, b: npt.ArrayLike, relative: bool = True) -> float:
    r"""Frobenius norm of the commutator, :math:`\|AB - BA\|_F` (paper, sec. 2.4.1).

    Parameters
    ----------
    a, b : array-like, shape (k, k)
        Operators in one basis, or on one set of vertices. To bring the operators of two shapes together takes a map,
        see `commutative_eigenspectra` and `operator_on_x`.
    relative : bool
        Divide by :math:`2 \|A\|_F \|B\|_F`, which makes it at most 1 and free of units.

    Raises
    ------
    ValueError
        Shapes that differ or are not square.

    Examples
    --------
    >>> a = np.diag([3.0, 2.0, 1.0])
    >>> qg.commutator_norm(a, np.diag([5.0, 4.0, 0.0]))
    0.0
    >>> bool(qg.commutator_norm(a, np.ones((3, 3))) > 0.1)
    True
    """
    left, right = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if left.shape != right.shape or left.ndim != 2 or left.shape[0] != left.shape[1]:
        raise ParameterError(f"the operators must be square and of one shape, got {left.shape} and {right.shape}")
    norm = float(np.linalg.norm(left @ right - right @ left))
    if not relative:
        return norm
    size = 2 * float(np.linalg.norm(left)) * float(np.linalg.norm(right))
    return norm / size if size > 0 else 0.0


def joint_diagonalizer(
    matrices: Sequence[npt.ArrayLike] | npt.ArrayLike, tolerance: float = 1e-10, max_sweeps: int = 100
) -> JointDiagonalization:
    r"""Orthogonal basis that minimises the off-diagonal entries of all matrices together, by Jacobi angles.

    .. math:: \min_{B^T B = I} \sum_i \sum_{p \ne q} (B^T M_i B)_{pq}^2

    Each pair of axes in turn is rotated by the angle that is best for it, in closed form, until no angle exceeds the
    tolerance. The sum never grows, and the end is a stationary point (for commuting matrices the exact solution).

    Parameters
    ----------
    matrices : array-like, shape (m, k, k)
        Symmetric. Scale them to equal norms if they are to count equally.
    tolerance : float
        Largest angle, in radians, that counts as none.
    max_sweeps : int
        Bound on the passes over all pairs.

    Raises
    ------
    ValueError
        Matrices that are not square, of different sizes, not symmetric or not finite; no convergence.

    References
    ----------
    Cardoso and Souloumiac, "Jacobi angles for simultaneous diagonalization", SIAM Journal on Matrix Analysis and
    Applications 17(1), 1996.

    Examples
    --------
    >>> turn, _ = np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))
    >>> a, b = (turn @ np.diag(values) @ turn.T for values in ([3.0, 2, 1], [1.0, 5, 2]))
    >>> found = qg.joint_diagonalizer([a, b])
    >>> in_both = found.basis.T @ a @ found.basis
    >>> np.allclose(in_both, np.diag(np.diag(in_both)), atol=1e-8)
    True
    """
    stack = _checked_stack(matrices)
    k = stack.shape[1]
    total = float((stack**2).sum())
    basis = np.eye(k)
    sweeps = 1
    while _sweep(stack, basis, tolerance):
        sweeps += 1
        if sweeps > max_sweeps:
            raise ParameterError(
                f"no convergence in {max_sweeps} sweeps; raise max_sweeps or the tolerance, {tolerance}"
            )
    diagonals = np.einsum("ijj->ij", stack)
    order = np.argsort(-(diagonals**2).sum(axis=0), kind="stable")
    rest = stack.copy()
    rest[:, np.arange(k), np.arange(k)] = 0
    residual = float((rest**2).sum()) / total if total > 0 else 0.0
    return JointDiagonalization(basis[:, order], diagonals[:, order].copy(), residual, sweeps)


def _sweep(stack: FloatArray, basis: FloatArray, tolerance: float) -> bool:
    """Rotate each pair of axes by its best angle, in place; whether any angle exceeded the tolerance."""
    k = stack.shape[1]
    turned = False
    for p in range(k - 1):
        for q in range(p + 1, k):
            difference, both = stack[:, p, p] - stack[:, q, q], stack[:, p, q] + stack[:, q, p]
            on = float(difference @ difference - both @ both)
            off = float(2 * (difference @ both))
            angle = 0.5 * np.arctan2(off, on + np.hypot(on, off))
            if abs(angle) <= tolerance:
                continue
            turned = True
            rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            stack[:, :, [p, q]] = stack[:, :, [p, q]] @ rotation
            stack[:, [p, q], :] = rotation.T @ stack[:, [p, q], :]
            basis[:, [p, q]] = basis[:, [p, q]] @ rotation
    return turned


def _checked_stack(matrices: Sequence[npt.ArrayLike] | npt.ArrayLike) -> FloatArray:
    """Own copy of the matrices as (m, k, k), after a look at shape, finiteness and symmetry."""
    stack = np.array(matrices, dtype=np.float64)
    if stack.ndim != 3 or stack.shape[1] != stack.shape[2] or 0 in stack.shape:
        raise ParameterError(f"the matrices must be a stack of square ones, (m, k, k), got the shape {stack.shape}")
    if not np.isfinite(stack).all():
        raise ParameterError("the matrices hold values that are not finite")
    defect = np.abs(stack - stack.transpose(0, 2, 1)).max(axis=(1, 2))
    bad = np.flatnonzero(defect > _SYMMETRIC * np.abs(stack).max(axis=(1, 2)))
    if bad.size:
        raise ParameterError(f"matrix {bad[0]} is not symmetric (off by {defect[bad[0]]:.3g}; {bad.size} such)")
    return (stack + stack.transpose(0, 2, 1)) / 2
