r"""Commutative eigenspectra of two shapes and the distance between them (paper, sec. 2.4.1, 4.1, 4.2).

The paper pairs eigenfunctions of two shapes under the idea that the operators of isometric shapes commute. As printed,
eq. (4) multiplies :math:`\Phi_X^T \Phi_Y \Delta_Y`, with rows of :math:`\Phi_X` for the vertices of X and rows of
:math:`\Phi_Y` for those of Y: the product exists only for equal numbers of vertices, and means something only if
vertex i of X *is* vertex i of Y. Equal order is itself a map, and the paper's use of it hides one. Here the map is an
argument: Y's eigenfunctions are read at ``p2p`` and all inner products are taken on X.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.html_repr import card
from qgeo_filters.spectral.joint_diagonalization import commutator_norm, joint_diagonalizer
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.validation import checked_count, checked_indices, frozen

__all__ = [
    "CommutativeSpectra",
    "commutative_eigenspectra",
    "commutator_norm",
    "coupling",
    "joint_diagonalizer",
    "operator_on_x",
    "spectral_distance",
]

Normalization = Literal["area", "vertices"]

# Shares of coupling that differ by less are equal: what rounding and triangulation leave.
_EQUAL_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class CommutativeSpectra:
    """Eigenfunctions of two shapes in pairs, on the vertices of X.

    Attributes
    ----------
    index_x, index_y : (m,) int
        Which eigenfunctions make the pairs, by increasing ``index_x``.
    signs : (m,) float64
        1 or -1, for Y's.
    eigenvalues_x, eigenvalues_y : (m,) float64
        Of the pairs, as in the spectra.
    functions_x, functions_y : (n_x, m) float64
        Eigenfunctions of X, and Y's read through the map and signed; of mean square 1 (Y's: on Y).
    coupling : (m, m) float64
        Inner products on X. The identity for an isometry with simple eigenvalues.
    residual : float
        What eq. (4) leaves: off-diagonal share of the couplings times eigenvalues, 0 to 1.
    c_xy : float
        `spectral_distance` of the pairs.

    Examples
    --------
    >>> x = qg.distance_spectrum(qg.testing.sample_surface(), k=5)
    >>> same = qg.commutative_eigenspectra(x, x, np.arange(162))
    >>> same.signs, round(same.c_xy, 6), bool(same.residual < 1e-9)
    (array([1., 1., 1., 1., 1.]), 0.0, True)
    >>> same.coupling.round(6).diagonal()
    array([1., 1., 1., 1., 1.])
    """

    index_x: IndexArray
    index_y: IndexArray
    signs: FloatArray
    eigenvalues_x: FloatArray
    eigenvalues_y: FloatArray
    functions_x: FloatArray
    functions_y: FloatArray
    coupling: FloatArray
    residual: float
    c_xy: float

    def __repr__(self) -> str:
        return f"CommutativeSpectra({len(self.signs)} pairs, C_XY = {self.c_xy:.4g}, residual {self.residual:.4g})"

    def _repr_html_(self) -> str:
        table = list(
            zip(
                (self.index_x + 1).tolist(),
                (self.index_y + 1).tolist(),
                np.where(self.signs > 0, "+", "-").tolist(),
                self.eigenvalues_x.tolist(),
                self.eigenvalues_y.tolist(),
                self.coupling.diagonal().tolist(),
                strict=True,
            )
        )
        columns = ("of X", "of Y", "sign", "eigenvalue of X", "of Y", "coupling")
        facts = {"C_XY": self.c_xy, "residual, eq. (4)": self.residual}
        return card(
            f"CommutativeSpectra: {len(self.signs)} pairs of eigenfunctions", facts, table=table, columns=columns
        )


def commutative_eigenspectra(
    spectrum_x: Spectrum,
    spectrum_y: Spectrum,
    p2p: npt.ArrayLike,
    size: int | None = None,
    normalization: Normalization = "area",
) -> CommutativeSpectra:
    r"""Subsets of equal size, order and signs of two eigenbases that commute best under a map (paper, eq. 4).

    With :math:`G = \Phi_X^T A_X \Phi_Y[T]` the two terms of eq. (4) are :math:`G \Delta_Y` and
    :math:`G^T \Delta_X`, each k x k. The entries for eigenfunctions i of X and j of Y that are no pair should vanish:

    .. math:: \min \sum_{(i, j)\ \text{no pair}} G_{ij}^2 \,(\gamma_{X,i}^2 + \gamma_{Y,j}^2) .

    For whole bases the sum over all entries is given, so that the best pairs maximise the diagonal: an assignment
    problem. For smaller subsets the pair that couples most with the others is left out, again and again. Signs make
    each :math:`G_{ij}` of a pair positive.

    Parameters
    ----------
    spectrum_x, spectrum_y : Spectrum
        Of the same operator on both shapes. Only ratios of eigenvalues enter, so that size does not matter.
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; ``numpy.arange(n)`` is the paper's equal vertex order.
    size : int, optional
        Number of pairs; all by default.
    normalization : {"area", "vertices"}
        Of ``c_xy``, see `spectral_distance`.

    Raises
    ------
    ValueError
        A map of the wrong length or range; size out of range.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> x = qg.distance_spectrum(surface, k=5)
    >>> y = qg.distance_spectrum(surface.with_vertices(1.05 * surface.vertices * [1, 1, 0.97]), k=5)
    >>> pairs = qg.commutative_eigenspectra(x, y, np.arange(162))
    >>> pairs.index_y, bool(pairs.c_xy < 1)
    (array([0, 1, 2, 3, 4]), True)
    """
    functions_x, pulled = _mean_square_one(spectrum_x), _mean_square_one(spectrum_y)
    pulled = pulled[_checked_map(spectrum_x, spectrum_y, p2p)]
    weights = spectrum_x.areas / spectrum_x.areas.sum()
    most = min(spectrum_x.k, spectrum_y.k)
    bound = f"{most}, the eigenfunctions that both spectra have"
    count = most if size is None else checked_count(size, 1, most, "size", bound)
    products = functions_x.T @ (weights[:, None] * pulled)
    energy = products**2 * (_relative(spectrum_x, most)[:, None] ** 2 + _relative(spectrum_y, most) ** 2)
    index_x, index_y = linear_sum_assignment(energy, maximize=True)
    index_x, index_y = _smaller(energy, index_x, index_y, int(count))
    signs = np.where(products[index_x, index_y] < 0, -1.0, 1.0)
    chosen = energy[np.ix_(index_x, index_y)]
    total = float(chosen.sum())
    left, right = functions_x[:, index_x], pulled[:, index_y] * signs
    return CommutativeSpectra(
        frozen(index_x),
        frozen(index_y),
        frozen(signs),
        frozen(spectrum_x.eigenvalues[index_x]),
        frozen(spectrum_y.eigenvalues[index_y]),
        frozen(left),
        frozen(right),
        frozen(products[np.ix_(index_x, index_y)] * signs),
        1 - float(np.trace(chosen)) / total if total > 0 else 0.0,
        spectral_distance(left, right, weights, normalization),
    )


def spectral_distance(
    functions_x: npt.ArrayLike,
    functions_y: npt.ArrayLike,
    areas: npt.ArrayLike,
    normalization: Normalization = "area",
) -> float:
    r"""Distance of two shapes by their paired eigenfunctions, :math:`C_{XY} = \sum_k \|\phi_X^k - \phi_Y^k\|_2`.

    Parameters
    ----------
    functions_x, functions_y : array-like, shape (n, m)
        Paired and signed, on the vertices of X, of mean square 1.
    areas : array-like, shape (n,)
        Of the vertices of X.
    normalization : {"area", "vertices"}
        The paper (sec. 4.2, Table 2) prints none. ``"area"``: the norm is that of mean squares over X, so that two
        orthogonal functions are sqrt(2) apart, whatever the triangulation. ``"vertices"``: eigenvectors of unit length,
        and the sum divided by sqrt(n), which has the printed table's order of magnitude and depends on n; only
        figures for meshes of like size may be compared.
    """
    difference = np.asarray(functions_x, dtype=np.float64) - np.asarray(functions_y, dtype=np.float64)
    weights = np.asarray(areas, dtype=np.float64)
    if difference.ndim != 2 or weights.shape != difference.shape[:1]:
        raise ParameterError(f"expected functions (n, m) and areas (n,), got {difference.shape} and {weights.shape}")
    norms = np.sqrt((weights / weights.sum()) @ difference**2)
    if normalization == "area":
        return float(norms.sum())
    if normalization == "vertices":
        return float(norms.sum() / np.sqrt(len(weights)))
    raise ParameterError(f"normalization must be 'area' or 'vertices', got {normalization!r}")


def coupling(spectrum_x: Spectrum, spectrum_y: Spectrum, p2p: npt.ArrayLike) -> FloatArray:
    r"""Inner products on X of its eigenfunctions with Y's read through the map, :math:`G`, shape (k_x, k_y).

    Orthogonal for an isometry and complete multiplets; it is then the functional map.
    """
    pulled = _mean_square_one(spectrum_y)[_checked_map(spectrum_x, spectrum_y, p2p)]
    return _mean_square_one(spectrum_x).T @ ((spectrum_x.areas / spectrum_x.areas.sum())[:, None] * pulled)


def operator_on_x(spectrum_x: Spectrum, spectrum_y: Spectrum, p2p: npt.ArrayLike) -> FloatArray:
    r"""Y's operator in X's eigenbasis through the map, :math:`G \Delta_Y G^T`, shape (k_x, k_x).

    For an isometry it is the diagonal matrix of X's own eigenvalues, and commutes with it: see `commutator_norm`, and
    `joint_diagonalizer` for the basis that serves both.
    """
    products = coupling(spectrum_x, spectrum_y, p2p)
    return (products * spectrum_y.eigenvalues) @ products.T


def _smaller(energy: FloatArray, rows: IndexArray, columns: IndexArray, count: int) -> tuple[IndexArray, IndexArray]:
    """Pairs left after dropping, one at a time, the pair with the largest share of coupling to the others."""
    while len(rows) > count:
        among = energy[np.ix_(rows, columns)]
        own = np.diag(among)
        others = among.sum(axis=0) + among.sum(axis=1) - 2 * own
        size = others + own
        share = np.divide(others, size, out=np.ones_like(size), where=size > 0)
        worst = np.flatnonzero(share >= share.max() - _EQUAL_SHARE)[-1]  # of equals, the one of highest frequency
        rows, columns = np.delete(rows, worst), np.delete(columns, worst)
    return rows, columns


def _mean_square_one(spectrum: Spectrum) -> FloatArray:
    """Eigenfunctions (n, k) of the shape scaled to unit area."""
    return spectrum.eigenfunctions * np.sqrt(spectrum.areas.sum())


def _relative(spectrum: Spectrum, count: int) -> FloatArray:
    """Eigenvalues without unit: the first ``count`` have a square sum of 1."""
    return spectrum.eigenvalues / np.linalg.norm(spectrum.eigenvalues[:count])


def _checked_map(spectrum_x: Spectrum, spectrum_y: Spectrum, p2p: npt.ArrayLike) -> IndexArray:
    image = checked_indices(p2p, spectrum_y.n_vertices, "p2p")
    if image.shape != (spectrum_x.n_vertices,):
        raise ParameterError(
            f"p2p must hold a vertex of Y for each of the {spectrum_x.n_vertices} vertices of X, got {len(image)}"
        )
    return image
