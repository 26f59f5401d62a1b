r"""The self-symmetry measure of the paper, eq. (3), its bound, and the regions that it yields.

Eq. (3) calls two points symmetric if :math:`|s(p) - s(q)| \le \varepsilon` with
:math:`s = \sum_{k \le k_0} \phi_k` and :math:`k_0 \le 20`. Taken to the letter it fails: an isometry T that is its own
inverse maps an eigenfunction of a simple eigenvalue to itself or to its negative, and those of the second kind
enter :math:`s(p) - s(Tp)` with :math:`2 \phi_k(p)`. On five bilateral shapes of TOSCA a third of the first twenty are
such, and true mirror images differ .8 to .9 times as much as random points do
(`benchmarks/symmetry_measure.py`). Three readings are offered:

``"printed"``
    the sum as it stands. It also depends on the signs, which an eigenbasis leaves open.
``"even"``
    the sum without the functions that may be antisymmetric, by their vanishing third moment
    (`is_antisymmetric`): .04 to .7 on the same shapes, where a multiplet mixes the two kinds or one is mistaken for
    the other.
``"absolute"``
    :math:`\sum_k |\phi_k|`, for which both kinds and all signs are alike: .04 to .2. The default.

The level sets of s are curves, so that the measure can refute a symmetry but not establish one: for that the
map itself has to be found.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.spectral.canonical import is_antisymmetric
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.validation import checked_count, checked_indices

Reading = Literal["absolute", "even", "printed"]

# Rows of the distance matrix that are compared at a time.
_BLOCK = 256


def symmetry_sum(spectrum: Spectrum, k0: int | None = None, reading: Reading = "absolute") -> FloatArray:
    """The sum of eq. (3) at each vertex, shape (n,), without unit.

    Parameters
    ----------
    spectrum : Spectrum
        Of the distances.
    k0 : int, optional
        Number of eigenfunctions; 20 by default, or all if there are fewer.
    reading : {"absolute", "even", "printed"}
        See the module.

    Returns
    -------
    (n,) float64
        Times the square root of the total weight (of the area, or of n where the spectrum is that of the plain
        matrix): the sum of functions whose mean square is one. Divided by sqrt(n) it has the size of sums of unit
        eigenvectors, as in the paper.

    Raises
    ------
    ValueError
        k0 out of range, unknown reading.
    """
    count = _checked_count(spectrum, k0)
    functions = spectrum.eigenfunctions[:, :count] * np.sqrt(spectrum.areas.sum())
    if reading == "printed":
        return functions.sum(axis=1)
    if reading == "even":
        return functions[:, ~is_antisymmetric(functions, spectrum.areas)].sum(axis=1)
    if reading == "absolute":
        return np.abs(functions).sum(axis=1)
    raise ParameterError(f"reading must be 'absolute', 'even' or 'printed', got {reading!r}")


def symmetry_epsilon(
    spectrum: Spectrum, p2p: npt.ArrayLike | None = None, k0: int | None = None, reading: Reading = "absolute"
) -> float:
    r"""The shape's epsilon: root mean square of :math:`s(p) - s(q)` over pairs of points, without unit.

    Parameters
    ----------
    spectrum : Spectrum
    p2p : array-like of int, shape (n,), optional
        Image of each vertex under a symmetry: the pairs are (p, p2p[p]), and epsilon tells how well eq. (3) holds for
        it. None: all pairs, :math:`\sqrt 2` times the deviation of s, which is what the first is to be compared with.
    k0, reading
        As in `symmetry_sum`.

    Notes
    -----
    The paper prints neither definition nor normalisation. Five of the six values of its Table 1 are
    :math:`\sqrt{8 / n}` to .3 percent (n = 3400: .0485, printed .0485 or .0486; the seahorse, n = 2194: .0604, printed
    .0603): they tell the number of vertices and not the shape. Any sum of unit eigenvectors has such a size: this
    function over all pairs, of the printed sum with five eigenvectors of the plain matrix, over sqrt(n), gives .049 for
    the paper's wolf (`benchmarks/symmetry_measure.py`). Only the ratio of the two epsilons speaks of symmetry.
    """
    values = symmetry_sum(spectrum, k0, reading)
    weights = spectrum.areas / spectrum.areas.sum()
    if p2p is None:
        return float(np.sqrt(2 * weights @ (values - weights @ values) ** 2))
    image = checked_indices(p2p, spectrum.n_vertices, "p2p")
    if image.shape != values.shape:
        raise ParameterError(f"p2p must hold one vertex for each of the {len(values)}, got {len(image)}")
    return float(np.sqrt(weights @ (values - values[image]) ** 2))


def epsilon_bound(
    spectrum: Spectrum, matrix: Any, p: npt.ArrayLike, q: npt.ArrayLike, k0: int | None = None
) -> FloatArray:
    r"""Upper bound of :math:`|s(p) - s(q)|` by differences of distances, for pairs of vertices, shape (m,).

    An eigenfunction is an integral of distances, :math:`\phi_k(p) = \gamma_k^{-1} \int d(p, r) \phi_k(r) \, dA(r)`,
    so that for any signs :math:`\sigma_k`

    .. math:: \sum_k \sigma_k (\phi_k(p) - \phi_k(q)) = \int (d(p, r) - d(q, r))\, g(r)\, dA(r),
        \qquad g = \sum_k \sigma_k \phi_k / \gamma_k .

    By the Cauchy-Schwarz inequality and since the :math:`\phi_k` are orthonormal,

    .. math:: |s(p) - s(q)| \le \Big(\sum_{k \le k_0} \gamma_k^{-2}\Big)^{1/2}
        \Big(\int (d(p, r) - d(q, r))^2 dA(r)\Big)^{1/2} .

    It holds for each reading of s: the even one leaves terms out, and since
    :math:`\big||a| - |b|\big| \le |a - b|` there are signs that serve the absolute one.

    Parameters
    ----------
    spectrum : Spectrum
        Of this matrix.
    matrix : array-like, shape (n, n)
        Distances.
    p, q : array-like of int, shape (m,)
        The pairs.
    k0 : int, optional
        As in `symmetry_sum`.

    Returns
    -------
    (m,) float64
        In the unit of `symmetry_sum`. Small for points near each other; mirror images are far apart, and for them
        it is large although the two sides agree.
    """
    n = spectrum.n_vertices
    one, other = checked_indices(p, n, "p"), checked_indices(q, n, "q")
    if one.shape != other.shape:
        raise ParameterError(f"p and q must be of one length, got {len(one)} and {len(other)}")
    if np.shape(matrix) != (n, n):
        raise ParameterError(f"the matrix has shape {np.shape(matrix)}, expected {(n, n)}")
    inverse = 1 / spectrum.eigenvalues[: _checked_count(spectrum, k0)]
    bound = np.empty(len(one))
    for start in range(0, len(one), _BLOCK):
        block = slice(start, start + _BLOCK)
        difference = np.asarray(matrix[one[block]], dtype=np.float64) - matrix[other[block]]
        bound[block] = np.sqrt(difference**2 @ spectrum.areas)
    return bound * np.sqrt(spectrum.areas.sum()) * np.linalg.norm(inverse)


def symmetry_regions(
    spectrum: Spectrum,
    n_regions: int | None = None,
    epsilon: float | None = None,
    k0: int | None = None,
    reading: Reading = "absolute",
) -> npt.NDArray[np.int32]:
    """Band of the values of the sum that each vertex falls into, shape (n,) from 0, low to high.

    Symmetric points fall into the same band, up to vertices beside its limits; so may others (see the module).

    Parameters
    ----------
    spectrum : Spectrum
    n_regions : int, optional
        Number of bands, of equal area; 8 by default.
    epsilon : float, optional
        Width of the bands instead, from the smallest value on: any two vertices of one band satisfy eq. (3) with this
        epsilon. A band may be empty.
    k0, reading
        As in `symmetry_sum`.

    Raises
    ------
    ValueError
        Both n_regions and epsilon, or one that is not positive.
    """
    if n_regions is not None and epsilon is not None:
        raise ParameterError("give the number of regions or the width epsilon of one, not both")
    values = symmetry_sum(spectrum, k0, reading)
    if epsilon is not None:
        if not 0 < epsilon < np.inf:
            raise ParameterError(f"epsilon must be positive, got {epsilon!r}")
        if np.ptp(values) / epsilon >= np.iinfo(np.int32).max:
            raise ParameterError(
                f"epsilon = {epsilon!r} cuts the values, which range over {np.ptp(values):g}, too fine"
            )
        return ((values - values.min()) / epsilon).astype(np.int32)
    n = spectrum.n_vertices
    bands = checked_count(8 if n_regions is None else n_regions, 1, n, "n_regions", f"the {n} vertices")
    order = np.argsort(values, kind="stable")
    area = spectrum.areas[order]
    middle = (np.cumsum(area) - area / 2) / area.sum()
    regions = np.empty(len(values), dtype=np.int32)
    regions[order] = np.minimum((middle * bands).astype(np.int32), bands - 1)
    return regions


def _checked_count(spectrum: Spectrum, k0: int | None) -> int:
    if k0 is None:
        return min(20, spectrum.k)
    return checked_count(k0, 1, spectrum.k, "k0", f"the {spectrum.k} eigenpairs of the spectrum")
