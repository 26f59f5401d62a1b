"""The class Spectrum, and that of a symmetric matrix of distances (paper, sec. 3, eq. 2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray
from qgeo_filters.array_likes import as_array, is_tensor
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.html_repr import card
from qgeo_filters.parallel import single_threaded_blas
from qgeo_filters.spectral.block_lanczos import block_eigenpairs
from qgeo_filters.spectral.canonical import canonical_signs, group_multiplets
from qgeo_filters.validation import checked_count, frozen, listed

#: Inner product of the eigenproblem: by the areas of the vertices, or the paper's plain one.
Mass = Literal["area", "uniform"]

# Two random vectors must agree to this on <x, D y> = <y, D x>; float32 distances do, one-sided ones do not.
_SYMMETRY = 1e-4
# Rows of an array on disk that are read at a time.
_ROWS = 1024


@dataclass(frozen=True, eq=False)
class Spectrum:
    r"""Eigenvalues and eigenfunctions of a symmetric operator on a surface.

    Attributes
    ----------
    eigenvalues : (k,) float64
        For a distance matrix by decreasing absolute value, in units of length^3 (length for uniform mass);
        for the Laplacian increasing, in units of 1 / area. A positive and a negative one of nearly equal size may
        change places from one shape to another, or with the number of landmarks: compare those of one sign.
    eigenfunctions : (n, k) float64
        One in each column, orthonormal under the mass: ``phi.T @ (areas[:, None] * phi)`` is the identity.
        The sign is fixed by `canonical_signs`.
    areas : (n,) float64
        Mass of each vertex in the inner product: its area, or 1 for the paper's unweighted matrix.
    multiplets : tuple of tuple of int
        Partition of ``range(k)`` into groups of nearly equal eigenvalues, see `group_multiplets`. Within a group only
        the span of the eigenfunctions has a meaning. The last group may be cut short by k.
    residuals : (k,) float64 or None
        Relative residual norms :math:`|K \phi - \gamma \phi| / |\gamma|`, where the solver measured them
        (`streamed_spectrum`). An eigenvalue of the operator lies that near, relatively; the sine of the angle between
        the span of some eigenfunctions and the true one is at most the norm of their residuals over the gap between
        their eigenvalues and all others.
    approximation : str
        What stands for the distances between all vertices: some landmarks, or a proxy of the surface. Empty where
        nothing does.

    Examples
    --------
    >>> spectrum = qg.distance_spectrum(qg.testing.sample_surface(), k=5)
    >>> spectrum.k, spectrum.n_vertices, spectrum.multiplets
    (5, 162, ((0,), (1,), (2, 3), (4,)))
    >>> round(float(spectrum.areas.sum() - qg.testing.sample_surface().area), 9)
    0.0
    """

    eigenvalues: FloatArray
    eigenfunctions: FloatArray
    areas: FloatArray
    multiplets: tuple[tuple[int, ...], ...]
    residuals: FloatArray | None = None
    approximation: str = ""

    def __repr__(self) -> str:
        source = f", from {self.approximation}" if self.approximation else ""
        return f"Spectrum({self.k} eigenpairs on {self.n_vertices} vertices{source})"

    def _repr_html_(self) -> str:
        equal = [" = ".join(str(k + 1) for k in group) for group in self.multiplets if len(group) > 1]
        facts = {
            "first eigenvalues": self.eigenvalues[:6].tolist(),
            "positive": f"{int((self.eigenvalues > 0).sum())} of {self.k}",
            "multiplets": equal or None,
            "largest residual": None if self.residuals is None else float(self.residuals.max()),
        }
        label = f"magnitudes of the eigenvalues, 1 to {self.k}"
        return card("Spectrum", facts, subtitle=repr(self), bars=np.abs(self.eigenvalues[:60]), bars_label=label)

    @classmethod
    def of(
        cls,
        eigenvalues: npt.ArrayLike,
        eigenfunctions: npt.ArrayLike,
        areas: npt.ArrayLike,
        residuals: FloatArray | None = None,
        approximation: str = "",
    ) -> Spectrum:
        """Spectrum of these eigenpairs, in their order, with canonical signs and multiplets."""
        values = np.array(eigenvalues, dtype=np.float64)
        mass = np.array(areas, dtype=np.float64)
        functions = np.array(eigenfunctions, dtype=np.float64)
        functions *= canonical_signs(functions, mass)
        if residuals is not None:
            residuals = frozen(np.array(residuals, dtype=np.float64))
        return cls(frozen(values), frozen(functions), frozen(mass), group_multiplets(values), residuals, approximation)

    @property
    def k(self) -> int:
        """Number of eigenpairs."""
        return len(self.eigenvalues)

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return len(self.areas)

    def truncated(self, k: int) -> Spectrum:
        """Spectrum of the first k eigenpairs."""
        checked_count(k, 1, self.k, "k", f"the {self.k} eigenpairs of this spectrum")
        return Spectrum(
            frozen(self.eigenvalues[:k].copy()),
            frozen(self.eigenfunctions[:, :k].copy()),
            self.areas,
            group_multiplets(self.eigenvalues[:k]),
            None if self.residuals is None else frozen(self.residuals[:k].copy()),
            self.approximation,
        )


@renamed_parameters(weights="mass")
@single_threaded_blas
def spectrum_of_matrix(
    matrix: Any, areas: npt.ArrayLike, k: int = 20, mass: Mass = "area", *, tolerance: float = 1e-6
) -> Spectrum:
    r"""Spectrum of a symmetric matrix of distances: the k eigenpairs of largest absolute value.

    With A the diagonal matrix of vertex areas, the eigenpairs :math:`(\gamma, u)` of :math:`A^{1/2} D A^{1/2}` give the
    eigenfunctions :math:`\phi = A^{-1/2} u` of the integral operator with kernel d, orthonormal in the area
    inner product. With ``mass="uniform"`` A is the identity: the paper's eq. (2).

    Parameters
    ----------
    matrix : array-like, zarr.Array or LinearOperator, shape (n, n)
        Symmetric, finite; float32 is used as it is. Only products with it are taken, three to eight for each
        eigenpair, sixteen at once; an array on disk is read once for these.
    areas : array-like, shape (n,)
        Area of each vertex, positive.
    k : int
        Number of eigenpairs, at most n.
    mass : {"area", "uniform"}
    tolerance : float
        Residual of the last eigenpair, as a fraction of its eigenvalue, see `block_eigenpairs`; those before it are
        more accurate.

    Returns
    -------
    Spectrum
        By decreasing absolute eigenvalue. The same input gives the same bits: the iteration starts from fixed vectors.

    Raises
    ------
    MeshError
        A vertex without area, under area mass.
    ValueError
        Shapes that do not match, k out of range, a matrix that is not symmetric or not finite (the
        distance between two pieces is infinite).
    """
    check_mass(mass)
    area = np.asarray(areas, dtype=np.float64)
    n = area.size
    if area.ndim != 1 or np.shape(matrix) != (n, n):
        raise ParameterError(
            f"the matrix has shape {np.shape(matrix)} and the areas {area.shape}; expected (n, n) and (n,)"
        )
    check_count(k, n)
    if mass == "uniform":
        area = np.ones(n)
    check_areas(area)
    root = np.sqrt(area)
    # Free of the unit of length, so that no scale leaves the range of float32.
    unit = root @ root
    operator = _symmetric(matrix, root / np.sqrt(unit))
    values, vectors = block_eigenpairs(operator, k, tolerance)
    return Spectrum.of(values * unit, vectors / root[:, None], area)


def check_mass(mass: str) -> None:
    """Raise ParameterError unless the mass is one of the two."""
    if mass not in ("area", "uniform"):
        raise ParameterError(f"mass must be 'area' or 'uniform', got {mass!r}")


def check_count(k: int, n: int) -> None:
    """Raise ValueError unless k eigenpairs can be had of n vertices."""
    checked_count(k, 1, n, "k", f"the number of vertices, {n}")


def check_areas(areas: FloatArray) -> None:
    """Raise MeshError, naming them, if a vertex has no area."""
    bad = np.flatnonzero(~(np.isfinite(areas) & (areas > 0)))
    if bad.size:
        raise MeshError(
            f"an eigenfunction has no value at a vertex without area, and there are {bad.size}: {listed(bad)}; "
            "remove vertices without faces and degenerate triangles, or repair=True"
        )


def _symmetric(matrix: Any, root: FloatArray) -> LinearOperator:
    """Operator x -> root D (root x) in float64, after a look at its symmetry and finiteness."""
    plain = _products(matrix)
    # A float64 vector would make NumPy copy a float32 matrix to float64 in each product.
    single = plain.dtype == np.float32

    def product(x: FloatArray) -> FloatArray:
        weighted = root[:, None] * x.reshape(len(root), -1)
        image = plain.matmat(weighted.astype(np.float32) if single else weighted)
        return (root[:, None] * image).reshape(x.shape)

    operator = LinearOperator(plain.shape, matvec=product, matmat=product, dtype=np.float64)
    x = np.random.default_rng(0).uniform(0.5, 1.5, (len(root), 2))
    with np.errstate(invalid="ignore", over="ignore"):
        image = operator.matmat(x)
        if not np.isfinite(image).all():
            raise ParameterError(
                "the matrix holds values that are not finite; distances between two pieces are infinite"
            )
        one, other = x[:, 0] @ image[:, 1], x[:, 1] @ image[:, 0]
    if abs(one - other) > _SYMMETRY * max(abs(one), abs(other)):
        raise ParameterError(f"the matrix is not symmetric: <x, D y> = {one:.6g}, <y, D x> = {other:.6g}")
    return operator


def _products(matrix: Any) -> LinearOperator:
    matrix = as_array(matrix) if is_tensor(matrix) else matrix
    has_products = isinstance(matrix, (np.ndarray, LinearOperator)) or sparse.issparse(matrix)
    if has_products:
        return aslinearoperator(matrix)
    if not hasattr(matrix, "__array__") and not hasattr(matrix, "dtype"):
        return aslinearoperator(np.asarray(matrix))
    # On disk: a block of rows at a time.
    n, dtype = matrix.shape[0], np.dtype(matrix.dtype)

    def product(x: np.ndarray) -> np.ndarray:
        return np.concatenate([np.asarray(matrix[i : i + _ROWS]) @ x for i in range(0, n, _ROWS)])

    return LinearOperator((n, n), matvec=product, matmat=product, dtype=dtype)
