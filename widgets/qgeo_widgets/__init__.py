"""Widgets for Jupyter that show what `qgeo_filters` finds: ``import qgeo_widgets as qw``.

Each takes meshes of Open3D, PyMeshLab, PyVista or trimesh, paths and Surfaces alike, works in JupyterLab, Notebook 7
and Voila, has traits that can be read, set and observed from Python, and writes itself with ``.to_html(path)``
to one page that opens offline. What goes wrong is a sentence in the widget.

What is shown is the mesh that was given, with its own vertices, faces and attributes, also where ``repair=`` has its
repair, or the closed surface around it, measured and matched in its place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from qgeo_filters.defaults import CURVATURE_WEIGHT

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    import numpy.typing as npt

    from qgeo_filters._typing import RepairOption
    from qgeo_filters.collection.collection import Collection
    from qgeo_filters.collection.consistent import How
    from qgeo_filters.differential.scalar import Scalar
    from qgeo_filters.matching.match_result import MatchResult
    from qgeo_widgets.animate_widget import AnimateWidget
    from qgeo_widgets.collection_widget import CollectionWidget
    from qgeo_widgets.compare_widget import CompareWidget
    from qgeo_widgets.geodesics_widget import GeodesicsWidget
    from qgeo_widgets.matrix_widget import MatrixWidget
    from qgeo_widgets.symmetry_widget import SymmetryWidget

__all__ = ["animate", "backend", "collection", "compare", "geodesics", "matrix", "symmetry"]


def animate(
    animation: Any,
    *,
    seconds: float | None = None,
    attribute: str | None = None,
    size: tuple[int, int] = (440, 400),
) -> AnimateWidget:
    """Widget of a shape in motion, with a slider over its time, play and pause, speed and loop.

    Two shapes, X and Y of a deformation transfer, move side by side at one time and turn together. The browser plays
    by itself, also while the kernel is busy. Between two frames all vertices go straight, as `Animation.at` has them.

    Parameters
    ----------
    animation : Animation, Transfer, or any iterable of mesh objects
        What `qgeo_filters.interpolate`, `transfer_deformation` and the like return; or meshes with equal triangles,
        anything that `qgeo_filters.as_surface` takes, one for each frame; after the first also arrays of positions.
        Of one MeshSet each layer is a frame, and the attributes are those of its current mesh.
    seconds : float, optional
        From the first frame to the last at speed 1. By default a fifteenth of a second a frame, from 2 to 12 in all.
    attribute : str, optional
        Of the surface, that colours it at first; the list has all. A value belongs to a vertex and goes with it. By
        default X and Y of a transfer have the colours of films, equal where they belong together.
    size : (int, int)
        Width and height of each canvas in pixels.

    Notes
    -----
    All frames are sent at once, 24 bytes for each vertex of each (position and normal in float32), at most 64 MB and
    250 frames a shape. Where that is not enough, a mesh of fewer vertices is drawn, and after that only some frames are
    sent, evenly chosen; the title says so. What Python has, `time` and `frame` too, stays as it is.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> x = qg.testing.sample_surface()
    >>> widget = qw.animate(qg.Animation(x, [x.vertices, 2 * x.vertices]))
    >>> widget.time = 1.0
    >>> widget.frame, widget.message
    (1, '')
    >>> widget.close()
    """
    from qgeo_widgets.animate_widget import AnimateWidget

    return AnimateWidget(animation, size=size, seconds=seconds, attribute=attribute)


def backend(name: Literal["webgl", "pythreejs"] | None = None) -> str:
    """Choose what draws the widgets that are made from now on; what draws now.

    Parameters
    ----------
    name : {"webgl", "pythreejs"}, optional
        ``"webgl"`` is the browser module of this package: one WebGL context a widget, values under the mouse, keys,
        and a panel for edges, shading, opacity, light, background and pictures. ``"pythreejs"`` goes through pythreejs:
        a canvas for each shape, of which a page keeps eight. By default nothing is changed.

    Returns
    -------
    str

    Raises
    ------
    ParameterError
        There is no such backend.
    MissingPackageError
        The package that it goes through is not installed.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> qw.backend("pythreejs")
    'pythreejs'
    >>> qw.backend("webgl")
    'webgl'
    """
    from qgeo_widgets.rendering.backends import choose_backend

    return choose_backend(name)


def collection(
    shapes: Collection | Mapping[str, Any],
    maps: How | Mapping[str, Any] = "matched",
    *,
    template: str | None = None,
    page: int = 1,
    size: tuple[int, int] = (260, 240),
) -> CollectionWidget:
    """Widget of many shapes in one colouring, whose views turn together: click a point and see it on all.

    Parameters
    ----------
    shapes : Collection, or mapping of name to mesh object
        What `qgeo_filters.as_surface` takes, by name.
    maps : str, or mapping of name to array-like of int (n,), or BarycentricMap
        Of a collection the kind of its maps, see `Collection.maps`: those that are not there yet are found now. Of
        other shapes the vertex (-1: none), or point, of the template for each vertex of each: what is carried is
        carried from there.
    template : str, optional
        Whose colours and points are carried to the others; the first shape by default.
    page : int
        A page has 24 shapes, eight with the backend of pythreejs, the template first: page 1 has the template and the
        first 23 others.
    size : (int, int)
        Width and height of each canvas in pixels.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> low = qg.testing.sample_surface()
    >>> high = low.with_vertices(low.vertices * [1, 1, 1.2])
    >>> widget = qw.collection({"low": low, "high": high}, {"high": np.arange(162)})
    >>> widget.picked = 17
    >>> widget.partners, widget.message
    ((17, 17), '')
    >>> widget.close()
    """
    from qgeo_widgets.collection_widget import CollectionWidget

    return CollectionWidget(shapes, maps, template=template, page=page, size=size)


def compare(
    x: Any,
    y: Any,
    *,
    p2p: npt.ArrayLike | MatchResult | None = None,
    truth: npt.ArrayLike | None = None,
    texture: str | os.PathLike[str] | npt.ArrayLike | None = None,
    texture_coordinates: str | npt.ArrayLike | None = None,
    curvature_weight: float = CURVATURE_WEIGHT,
    repair: RepairOption = "auto",
    size: tuple[int, int] = (440, 400),
    progress: bool = True,
) -> CompareWidget:
    """Widget of two shapes whose views move together, and of the map between them.

    Click a point on either shape: its partner is marked on the other, and the distances from both are
    shown. A second click draws the quasi-geodesics between the two points on both shapes, with their lengths. Colours
    are carried from X to Y, or show matched regions, an eigenfunction, an attribute, or the error against the truth.

    Parameters
    ----------
    x, y : mesh objects
        What `qgeo_filters.as_surface` takes, or a `Repair`, of which the mesh that was given is shown.
    p2p : MatchResult, or array-like of int, shape (n_x,), optional
        What `qgeo_filters.match` returned, with its regions, its score and whether it is sure; of wraps and of parts,
        too; "match again" goes by its options. Or the vertex of Y for each vertex of X; -1: no partner, which is grey.
        By default found by `qgeo_filters.match`, with a progress bar.
    truth : array-like of int, shape (n_x,), optional
        The true map, to show the error; -1: not known.
    texture : path, or array-like, shape (h, w), (h, w, 3) or (h, w, 4), optional
        A picture on X, carried to Y: a file that Pillow reads, bytes, or numbers from 0 to 1. Of more than 1024 pixels
        a side it is made smaller. The backend of pythreejs shows its colours at the vertices alone.
    texture_coordinates : str, or array-like, shape (n_x, 2), optional
        Places of the vertices of X on the picture, from 0 to 1, right and up; or the name of an attribute. By default
        the attribute ``uv`` (``s`` and ``t``, ``u`` and ``v``, ``texture_u`` and ``texture_v``) of X where there is
        one; else the picture is thrown at X from the front of the first view.
    curvature_weight : float
        Of the lifted metric in which distances are shown; 0 is the surfaces' own.
    repair : bool, "auto", "force" or "wrap"
        What is measured and matched in place of the meshes, as in `qgeo_filters.match`: with "wrap" the closed surface
        around each, for raw CT and models in many pieces. All vertices are those of the meshes that were given; where
        one has no place on what is measured it is grey. A match of wraps brings its own.
    size : (int, int)
        Width and height of each canvas in pixels.
    progress : bool
        Show progress while the map is sought.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> x = qg.testing.sample_surface()
    >>> widget = qw.compare(x, x.with_vertices(2 * x.vertices), p2p=np.arange(162))
    >>> widget.picked = ("x", 17)
    >>> widget.picked, widget.message
    (('x', 17), '')
    >>> widget.close()
    """
    from qgeo_widgets.compare_widget import CompareWidget

    return CompareWidget(
        x,
        y,
        p2p=p2p,
        truth=truth,
        texture=texture,
        texture_coordinates=texture_coordinates,
        curvature_weight=curvature_weight,
        repair=repair,
        size=size,
        progress=progress,
    )


def geodesics(
    x: Any,
    source: int | None = None,
    target: int | None = None,
    *,
    curvature_weight: float = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    repair: RepairOption = "auto",
    size: tuple[int, int] = (500, 420),
) -> GeodesicsWidget:
    """Widget of the shortest path between two points that are clicked, and of the one that straightening alone finds.

    The shortest goes down the exact distance. The other, thin and grey, is the shortest path along edges after
    straightening; it is locally shortest too, and often longer. Their lengths stand side by side. Below, the geodesic
    curvature along the shortest, with a cursor that moves on both. The slider of the curvature's weight shows how
    the path comes to avoid curved regions.

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
    repair : bool, "auto", "force" or "wrap"
        What is measured in place of the mesh, as in filters, see `compare`. The mesh that was given is shown.
    size : (int, int)
        Width and height of the canvas in pixels.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> widget = qw.geodesics(qg.testing.sample_surface(), source=0, target=50)
    >>> widget.path.converged, widget.message
    (True, '')
    >>> widget.close()
    """
    from qgeo_widgets.geodesics_widget import GeodesicsWidget

    return GeodesicsWidget(
        x,
        source=source,
        target=target,
        curvature_weight=curvature_weight,
        scalar=scalar,
        repair=repair,
        size=size,
    )


def matrix(
    x: Any,
    *,
    matrix: npt.ArrayLike | None = None,
    curvature_weight: float = CURVATURE_WEIGHT,
    repair: RepairOption = "auto",
    size: int = 430,
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
    repair : bool, "auto", "force" or "wrap"
        What is measured in place of the mesh, as in filters, see `compare`. The mesh that was given is shown.
    size : int
        Width and height of each canvas in pixels.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> widget = qw.matrix(qg.testing.sample_surface())
    >>> widget.row = 3
    >>> widget.message
    ''
    >>> widget.close()
    """
    from qgeo_widgets.matrix_widget import MatrixWidget

    return MatrixWidget(x, matrix=matrix, curvature_weight=curvature_weight, repair=repair, size=size)


def symmetry(
    x: Any,
    *,
    symmetry: Any = None,
    curvature_weight: float = CURVATURE_WEIGHT,
    repair: RepairOption = "auto",
    size: tuple[int, int] = (440, 400),
) -> SymmetryWidget:
    """Widget of a shape's self-symmetry, seen from two opposite sides.

    Mirror images in one colour with the axis between them, the two sides, the asymmetry, and the regions of eq. (3),
    which follow the sliders of epsilon and k0. Click a point and see its mirror image.
    The sides are called A (`Symmetry.side` 1) and B (-1): which of them is the left one is not known, nor whether the
    first view shows the front.

    Parameters
    ----------
    x : mesh object
        What `qgeo_filters.as_surface` takes.
    symmetry : Symmetry, optional
        By default found by `qgeo_filters.self_symmetry`. Of a mesh that was repaired or wrapped, on its own vertices.
    curvature_weight : float
        Of the lifted metric of the eigenfunctions in eq. (3); 0 is the surface's own.
    repair : bool, "auto", "force" or "wrap"
        What is measured in place of the mesh, as in filters, see `compare`. The mesh that was given is shown.
    size : (int, int)
        Width and height of each canvas in pixels.

    Examples
    --------
    >>> import qgeo_widgets as qw
    >>> surface = qg.testing.sample_surface()
    >>> ball = surface.vertices / [1.4, 1, 0.8]
    >>> ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    >>> radius = 1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]
    >>> body = surface.with_vertices(ball * [1, 1.6, 0.7] * radius)  # its own mirror image in x = 0
    >>> widget = qw.symmetry(body, symmetry=qg.self_symmetry(body))
    >>> widget.picked = 3
    >>> widget.message
    ''
    >>> widget.close()
    """
    from qgeo_widgets.symmetry_widget import SymmetryWidget

    return SymmetryWidget(x, symmetry=symmetry, curvature_weight=curvature_weight, repair=repair, size=size)
