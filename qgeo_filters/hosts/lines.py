"""Curves on a surface as lines of the library that shows them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.protocol import load_host, registered_hosts


def polylines(curves: Any, library: str) -> Any:
    """Curves as lines that a library draws: a LineSet of Open3D, a PolyData of PyVista, a Path3D of trimesh.

    Parameters
    ----------
    curves : GeodesicPath, array-like of shape (k, 3), or a sequence of them
        Such as ``qg.quasi_geodesic(...)``, or the axis of a symmetry, ``symmetry.curve``. A closed curve ends where it
        begins.
    library : {"open3d", "pyvista", "trimesh", "vedo", "meshio", "pymeshlab"}, or the name of another host
        One that has a function ``lines``, see `Host`.

    Returns
    -------
    open3d.geometry.LineSet, pyvista.PolyData, trimesh.path.Path3D, vedo.Lines, meshio.Mesh or pymeshlab.MeshSet

    Raises
    ------
    ParameterError
        No points in space, or a library that draws no lines.
    MissingPackageError
        The library is not installed.

    Examples
    --------
    >>> path = qg.quasi_geodesic(qg.testing.sample_surface(), 0, 50)
    >>> drawn = qg.polylines(path, "pyvista")
    >>> drawn.n_lines, drawn.n_points == len(path.points)
    (1, True)
    >>> drawn = qg.polylines([path, path], "open3d")  # a LineSet for its windows
    >>> len(drawn.lines) == 2 * (len(path.points) - 1)
    True
    """
    points = _listed(curves)
    host = load_host(library) if library in registered_hosts() else None
    make = getattr(host, "lines", None)
    if make is None:
        drawing = [name for name in registered_hosts() if hasattr(load_host(name), "lines")]
        raise ParameterError(f"library must be one of {', '.join(drawing)}, got {library!r}")
    return make(points)


def _listed(curves: Any) -> list[FloatArray]:
    """The points of each curve."""
    if isinstance(curves, (list, tuple)) and not (curves and np.ndim(curves[0]) == 1):
        return [_checked(curve) for curve in curves]
    return [_checked(curves)]


def _checked(curve: Any) -> FloatArray:
    points: npt.ArrayLike = curve.points if hasattr(curve, "points") else curve
    array = as_array(points).astype(np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ParameterError(f"a curve is points in space, of shape (k, 3), got {array.shape}")
    return array
