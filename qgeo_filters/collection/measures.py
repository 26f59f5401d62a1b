r"""How far the shapes of a collection are apart, as labelled squares.

=================  =========================================================================  ===================
name               what                                                                        needs
=================  =========================================================================  ===================
``c_xy``           distance of the paired eigenfunctions (paper, sec. 4.2)                     maps
``d_s``            D(S) of the two shapes (paper, eq. 5), see `compatibility`                  maps
``distortion``     mean distortion of distances along the map, in sqrt(area)                   maps
``eigenvalues``    of the quasi-geodesic distances: Euclidean distance of the first 20,        prepared shapes
                   relative to the square sum of each shape, those of one sign in order
``shape_dna``      of the Laplacian: the same of the first 20 after the zero, of unit area,    prepared shapes
                   each divided by its number (Weyl's law: all count alike)
=================  =========================================================================  ===================

ShapeDNA: Reuter, Wolter, Peinecke, "Laplace-Beltrami spectra as 'Shape-DNA' of surfaces and solids", CAD 38, 2006.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.distance import cdist

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.spectral.commutative import commutative_eigenspectra

#: Measures that are read from matches, and the value of a record that each is.
OF_MAPS = {"c_xy": "c_xy", "d_s": "d_s", "distortion": "score"}
#: Those that need no map, and the array of a prepared shape that each is computed from.
OF_SHAPES = {"eigenvalues": "spectrum_{last}_eigenvalues", "shape_dna": "laplacian_eigenvalues"}
MEASURES = (*OF_MAPS, *OF_SHAPES)
_COMPARED = 20


def checked_measure(measure: str) -> str:
    """The measure, or `ParameterError`."""
    if measure not in MEASURES:
        raise ParameterError(f"measure must be one of {', '.join(map(repr, MEASURES))}, got {measure!r}")
    return measure


def spectral_distances(measure: str, eigenvalues: Sequence[FloatArray]) -> FloatArray:
    """Distances (m, m) of shapes of unit area by their eigenvalues alone, NaN where a shape has none.

    Parameters
    ----------
    measure : {"eigenvalues", "shape_dna"}
    eigenvalues : sequence of (k,) float64
        Of each shape; empty for one that could not be prepared.
    """
    start = measure == "shape_dna"  # the constant function's eigenvalue is 0
    known = [len(values) - start for values in eigenvalues if len(values)]
    count = min([_COMPARED, *known])
    rows = np.full((len(eigenvalues), count), np.nan)
    for row, values in zip(rows, eigenvalues, strict=True):
        if len(values):
            chosen = values[start : start + count]
            row[:] = chosen / np.arange(1, count + 1) if start else chosen / np.linalg.norm(chosen)
    rows = rows if start else _by_sign(rows)
    return np.asarray(cdist(rows, rows), dtype=np.float64)


def _by_sign(rows: FloatArray) -> FloatArray:
    """The positive eigenvalues of each row by size, then the negative ones, zeros where others have more: (m, 2 k).

    By absolute value 9.1 and -9.0 change places under the least change of a shape, and compared place by place they
    would count as a difference of 18. Values of one sign move by no more than the operator does (Hoffman-Wielandt).
    """
    positive, negative = (-np.sort(-np.maximum(sign * rows, 0), axis=1) for sign in (1, -1))
    return np.concatenate([positive, -negative], axis=1)


def c_xy_by_vertex_order(shapes: Sequence[PreparedShape], names: Sequence[str]) -> FloatArray:
    """C_XY of each two poses of one mesh, (m, m): vertex i is the same point of all.

    Raises
    ------
    ParameterError
        Shapes whose triangles differ: which.
    """
    faces = shapes[0].given.faces
    for name, shape in zip(names, shapes, strict=True):
        if shape.given.n_vertices != shapes[0].given.n_vertices or not np.array_equal(shape.given.faces, faces):
            raise ParameterError(f"{names[0]} and {name} have different triangles: vertex i is not one point of both")
        if shape.repair is not None:
            raise ParameterError(f"{name} was repaired: its vertices are not numbered as they were")
    spectra = [shape.full_spectrum for shape in shapes]
    found, same = np.zeros((len(shapes), len(shapes))), np.arange(shapes[0].given.n_vertices)
    for j in range(len(shapes)):
        for i in range(j):
            found[i, j] = found[j, i] = commutative_eigenspectra(spectra[i], spectra[j], same).c_xy
    return found
