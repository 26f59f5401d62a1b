"""What is arbitrary in an eigenbasis: signs, and the choice of basis where eigenvalues agree."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray

#: Neighbouring eigenvalues closer than this fraction of their size make a multiplet: the spread that the
#: triangulation gives to equal ones.
MULTIPLET_GAP = 0.02
# A third moment below this fraction of the absolute one is that of a function which is antisymmetric under a
# symmetry of the surface, and has the sign of the triangulation's noise.
_SKEWED = 0.05
# Entries this near to the largest count as equally large.
_NEAR_LARGEST = 0.99


def canonical_signs(functions: npt.ArrayLike, areas: npt.ArrayLike) -> FloatArray:
    r"""Factors of 1 or -1 for the columns of functions (n, k), shape (k,), that make their signs comparable.

    A column is turned so that its third moment :math:`\int \phi^3 dA` is positive. This does not depend on the
    solver, the numbering or the position, and hardly on the triangulation. For the constant function it
    means positive. A function that is antisymmetric under a symmetry of the surface has no third moment, nor any other
    intrinsic sign, as the symmetry swaps the two choices: where the moment is below 5 % of
    :math:`\int |\phi|^3 dA`, the first vertex whose absolute value reaches 99 % of the largest
    becomes positive. That rule depends on the numbering.
    """
    scaled, moment, _ = _moments(functions, areas)
    first = (np.abs(scaled) >= _NEAR_LARGEST).argmax(axis=0)
    at_first = scaled[first, np.arange(scaled.shape[1])]
    return np.where(np.where(is_antisymmetric(functions, areas), at_first, moment) < 0, -1.0, 1.0)


def is_antisymmetric(functions: npt.ArrayLike, areas: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    r"""Whether each column of functions (n, k) may change sign under a symmetry of the surface, shape (k,).

    True where :math:`|\int \phi^3 dA| \le .05 \int |\phi|^3 dA`: necessary for a function that some symmetry
    maps to its negative, and not sufficient.
    """
    _, moment, absolute = _moments(functions, areas)
    return np.abs(moment) <= _SKEWED * absolute


def _moments(functions: npt.ArrayLike, areas: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns scaled to largest absolute value 1, and their third moment and absolute third moment."""
    phi = np.asarray(functions, dtype=np.float64)
    weights = np.asarray(areas, dtype=np.float64)
    largest = np.abs(phi).max(axis=0, initial=0.0)
    scaled = np.divide(phi, largest, out=np.zeros_like(phi), where=largest > 0)
    return scaled, weights @ scaled**3, weights @ np.abs(scaled) ** 3


def group_multiplets(eigenvalues: npt.ArrayLike, gap: float = MULTIPLET_GAP) -> tuple[tuple[int, ...], ...]:
    """Partition of the indices of eigenvalues (k,) into groups of nearly equal ones, by first index.

    Two eigenvalues that follow each other in size are in one group if they differ by at most ``gap`` times
    the larger absolute value. Values of different sign never are, however equal in absolute value, so that a
    group need not be a range of indices.
    """
    values = np.asarray(eigenvalues, dtype=np.float64)
    if values.size == 0:
        return ()
    order = np.argsort(-values, kind="stable")
    ordered = values[order]
    size = np.maximum(np.abs(ordered[1:]), np.abs(ordered[:-1]))
    breaks = np.flatnonzero(ordered[:-1] - ordered[1:] > gap * size) + 1
    groups = [tuple(sorted(group.tolist())) for group in np.split(order, breaks)]
    return tuple(sorted(groups))


def subspace_sine(functions: npt.ArrayLike, others: npt.ArrayLike, areas: npt.ArrayLike) -> float:
    """Sine of the largest principal angle between the spans of two sets of columns, 0 to 1.

    Parameters
    ----------
    functions, others : array-like, shape (n, k)
        Linearly independent columns.
    areas : array-like, shape (n,)
        Weights of the inner product.

    Notes
    -----
    Taken from what is left of one set after projection on the other, which keeps full precision for small
    angles, where a cosine loses half of the digits (Bjoerck and Golub 1973).
    """
    root = np.sqrt(np.asarray(areas, dtype=np.float64))[:, None]
    x, y = (np.linalg.qr(root * np.asarray(values, dtype=np.float64))[0] for values in (functions, others))
    return min(float(np.linalg.norm(y - x @ (x.T @ y), 2)), 1.0)
