"""Spectrum of the Laplace-Beltrami operator, beside that of the distances."""

from __future__ import annotations

import numpy as np
import robust_laplacian
from scipy import sparse
from scipy.sparse.linalg import LinearOperator

from qgeo_filters._typing import RepairOption
from qgeo_filters.cholesky import factorised_spd
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.spectral.deflated_lanczos import largest_eigenpairs
from qgeo_filters.spectral.given_vertices import spectrum_of_mesh
from qgeo_filters.spectral.spectrum import Spectrum, check_areas, check_count
from qgeo_filters.surface import Surface

# Shift below zero, in units of 1 / area: the first eigenvalue is 0 and the next is of the order of 10.
_SHIFT = 0.1


def laplacian_spectrum(surface: SurfaceLike, k: int = 20, *, repair: RepairOption = "auto") -> Spectrum:
    r"""Spectrum of the Laplace-Beltrami operator: the k smallest eigenvalues, increasing, the constant one included.

    Solves :math:`L \phi = \lambda M \phi` with the intrinsic Delaunay cotangent matrix and lumped areas of
    `robust_laplacian`,
    which bad triangles cannot spoil. Boundaries are free (Neumann).

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        In one piece.
    k : int
        Number of eigenpairs.
    repair : bool, "auto" or "force"
        Whether the mesh is repaired first; by default, "auto", if it is not welded or would be refused. Eigenfunctions
        are on the vertices that were given, see `spectrum_on_given`.

    Returns
    -------
    Spectrum
        Eigenvalues in units of 1 / area; eigenfunctions orthonormal under ``areas``, the lumped areas.

    Raises
    ------
    MeshError
        Surface in several pieces, or with a vertex of no area.
    ValueError
        k out of range.

    References
    ----------
    Sharp and Crane, "A Laplacian for nonmanifold triangle meshes", SGP 2020.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> spectrum = qg.laplacian_spectrum(surface, k=4)
    >>> bool(abs(spectrum.eigenvalues[0]) < 1e-6), bool((np.diff(spectrum.eigenvalues) > 0).all())
    (True, True)
    """
    return spectrum_of_mesh(surface, repair, lambda mesh, _: _spectrum(mesh, k))


def _spectrum(surface: Surface, k: int) -> Spectrum:
    surface.require_connected("the spectrum of the Laplacian")
    n = surface.n_vertices
    check_count(k, n)
    check_areas(surface.vertex_areas)
    # Unit area: the mollification, the shift and ARPACK's tolerances are those of one scale.
    unit = surface.area
    stiffness, mass = robust_laplacian.mesh_laplacian(surface.vertices / np.sqrt(unit), surface.faces)
    areas = mass.diagonal()
    root = np.sqrt(areas)
    scale = sparse.diags_array(1 / root)
    symmetric = scale @ stiffness @ scale
    # The smallest eigenvalues are the largest of the inverse, moved off zero.
    moved = (symmetric + _SHIFT * sparse.eye_array(n)).tocsc()
    solve = factorised_spd(moved, points=surface.vertices)
    inverse = LinearOperator((n, n), matvec=solve, matmat=solve, dtype=np.float64)
    inverted, vectors = largest_eigenpairs(inverse, k)
    # The smallest is zero and comes out as rounding of either sign.
    values = np.maximum(1 / inverted - _SHIFT, 0.0) / unit
    return Spectrum.of(values, vectors / (root * np.sqrt(unit))[:, None], areas * unit)
