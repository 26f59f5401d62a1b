"""Widgets for Jupyter that show what `qgeo_filters` finds: ``import qgeo_widgets as qw``.

Each takes meshes of Open3D, PyMeshLab, PyVista or trimesh, paths and Surfaces alike, works in JupyterLab, Notebook 7
and Voila, has traits that can be read, set and observed from Python, and writes itself with ``.to_html(path)``
to one page that opens offline. What goes wrong is a sentence in the widget.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy.typing as npt

    from qgeo_filters.differential.scalar import Scalar
    from qgeo_widgets.geodesics_widget import GeodesicsWidget
    from qgeo_widgets.matrix_widget import MatrixWidget

__all__ = ["geodesics", "matrix"]


def geodesics(
    x: Any,
    source: int | None = None,
    target: int | None = None,
    *,
    curvature_weight: float = 0.03,
    scalar: Scalar = "mean_curvature",
    size: tuple[int, int] = (500, 420),
) -> GeodesicsWidget:
    """Widget of the quasi-geodesic between two points that are clicked, before and after it was straightened.

    Beside it the geodesic curvature along the path, with a cursor that moves on both. The slider of the
    curvature's weight shows how the path comes to avoid curved regions.

    Parameters
    ----------
    x : mesh object
        What `qgeo_filters.as_surface` takes.
    source, target : int, optional
        Vertices to begin with.
    curvature_weight : float
        Of the lifted metric at first; 0 is the surface's own.
    scalar : str, array-like or callable
        What lifts the metric, see `qgeo_filters.surface_scalar`.
    size : (int, int)
        Width and height of the canvas in pixels.
    """
    from qgeo_widgets.geodesics_widget import GeodesicsWidget

    return GeodesicsWidget(x, source=source, target=target, curvature_weight=curvature_weight, scalar=scalar, size=size)


def matrix(
    x: Any, *, matrix: npt.ArrayLike | None = None, curvature_weight: float = 0.03, size: int = 430
) -> MatrixWidget:
    """Widget of the distance matrix beside the shape (paper, Fig. 1).

    Move over a row of the matrix, or click on the shape, and see the distances from that vertex as a function on the
    surface.

    Parameters
    ----------
    x : mesh object
        What `qgeo_filters.as_surface` takes.
    matrix : array-like, shape (n, n), optional
        Distances in mesh units; by default those of at most 600 evenly spaced vertices to all are computed.
    curvature_weight : float
        Of the lifted metric; 0 is the surface's own.
    size : int
        Width and height of each canvas in pixels.
    """
    from qgeo_widgets.matrix_widget import MatrixWidget

    return MatrixWidget(x, matrix=matrix, curvature_weight=curvature_weight, size=size)
