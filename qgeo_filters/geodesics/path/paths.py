"""Quasi-geodesic paths: locally shortest in any metric of the surface, with their discrete geodesic curvature."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import DisconnectedError, MeshError, ParameterError
from qgeo_filters.geodesics.metric import LiftedMetric, Metric, metric_for
from qgeo_filters.geodesics.path.backtrace import edge_sleeve, exact_sleeve
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.geodesics.path.straightening import describe, straighten, vertex_nodes
from qgeo_filters.geodesics.unfolding import UnfoldedMesh, unfolded
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.jit import ZERO, njit
from qgeo_filters.parallel import in_threads
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_index, checked_indices, frozen

INITIAL = ("exact", "edges")


def quasi_geodesic(
    surface: SurfaceLike,
    i: int,
    j: int,
    metric: Metric | None = "cartesian",
    *,
    initial: str = "exact",
    tolerance: float = 1e-6,
) -> GeodesicPath:
    """Locally shortest path between two vertices, with its geodesic curvature.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Manifold; open, closed, orientable or not.
    i, j : int
        Vertices.
    metric : LiftedMetric, "cartesian" or "lifted"
        By name: the surface's own metric, or `lifted_metric` as it is.
    initial : {"exact", "edges"}
        First path: down the exact distance from j, which gives the shortest path of all; or the shortest
        path along edges, much faster, which in some cases straightens to one that is only locally shortest.
    tolerance : float
        Largest geodesic curvature, radians, that counts as straight.

    Returns
    -------
    GeodesicPath

    Raises
    ------
    DisconnectedError
        The vertices lie in different pieces of the surface.
    NonManifoldError
        Three faces on an edge, or several fans at a vertex.
    ParameterError, MeshError
        A vertex out of range, an unknown first path, the metric of another surface.

    Notes
    -----
    Martinez, Velho and Carvalho, "Computing geodesics on triangular meshes", Computers & Graphics 29(5),
    2005: a point inside an edge goes to where the unfolded triangles make the path straight, at a vertex the
    path goes to the side whose angle is below pi and stays if both are at least pi. All points inside edges are
    corrected at once by the taut path through the unfolded triangles.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> path = qg.quasi_geodesic(surface, 0, 50)
    >>> path.converged, bool(np.isclose(path.length, qg.distances(surface, 0, method="exact")[0, 50]))
    (True, True)
    >>> path.points.shape[1], len(path.kappa_g) == len(path.points) - 2
    (3, True)
    """
    surface = as_surface(surface)
    finder = PathFinder(surface, metric_for(surface, metric, "cartesian"), initial, tolerance)
    return finder(checked_index(i, surface.n_vertices, "i"), checked_index(j, surface.n_vertices, "j"))


def quasi_geodesics(
    surface: SurfaceLike,
    pairs: npt.ArrayLike,
    metric: Metric | None = "cartesian",
    *,
    initial: str = "edges",
    tolerance: float = 1e-6,
    workers: int | None = None,
    progress: bool = False,
) -> list[GeodesicPath]:
    """Locally shortest paths between many pairs of vertices, in their order.

    Parameters
    ----------
    pairs : array-like of int, shape (k, 2)
        Start and end of each path.
    workers : int, optional
        Threads; all cores by default. The result does not depend on it.
    progress : bool
        Show a progress bar.
    surface, metric, initial, tolerance
        See `quasi_geodesic`; here the faster first path is the default.

    Raises
    ------
    DisconnectedError, NonManifoldError, ParameterError, MeshError
        As `quasi_geodesic`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> paths = qg.quasi_geodesics(surface, [(0, 50), (3, 99)])
    >>> [path.converged for path in paths]
    [True, True]
    """
    surface = as_surface(surface)
    table = as_array(pairs)
    if table.ndim != 2 or table.shape[1] != 2:
        raise MeshError(f"pairs must have shape (k, 2), got {table.shape}")
    table = checked_indices(table.ravel(), surface.n_vertices, "pairs").reshape(-1, 2)
    finder = PathFinder(surface, metric_for(surface, metric, "cartesian"), initial, tolerance)
    return in_threads(
        lambda pair: finder(int(pair[0]), int(pair[1])),
        table,
        workers,
        progress=progress,
        description="paths",
        unit="path",
    )


@njit()
def _find(
    start: int, end: int, exact: bool, tolerance: float, max_rounds: int, mesh: UnfoldedMesh
) -> tuple[npt.NDArray[np.void], npt.NDArray[np.void], float, FloatArray]:
    """Nodes of the straightened and of the first path, length of the first one (inf: none), lengths by round."""
    if exact:
        sleeve, length = exact_sleeve(start, end, mesh)
        vertices = np.empty(0, dtype=np.int64)
    else:
        sleeve, length, vertices = edge_sleeve(start, end, mesh)
    if length == np.inf:
        return vertex_nodes(vertices[:0]), vertex_nodes(vertices[:0]), length, np.empty(0)
    if exact:
        taut, flat, _ = straighten(sleeve, start, end, tolerance, ZERO, mesh)
        first = describe(taut, flat, start, end, mesh)
    else:
        first = vertex_nodes(vertices)
    taut, flat, lengths = straighten(sleeve, start, end, tolerance, max_rounds, mesh)
    return describe(taut, flat, start, end, mesh), first, length, lengths


class PathFinder:
    """All that the paths of one surface and metric share."""

    def __init__(self, surface: Surface, metric: LiftedMetric, initial: str, tolerance: float) -> None:
        if initial not in INITIAL:
            raise ParameterError(f"initial must be one of {', '.join(map(repr, INITIAL))}, got {initial!r}")
        if not 0.0 < tolerance < 1.0:
            raise ParameterError(f"tolerance must be an angle between 0 and 1 radian, got {tolerance!r}")
        self.surface = surface
        self.exact = initial == "exact"
        self.tolerance = tolerance
        # A string is pulled tight among triangles in general position: they keep the height that rounding gives them.
        self.mesh: UnfoldedMesh = unfolded(metric.intrinsic("a geodesic path"), rounding=0.0)

    def __call__(self, start: int, end: int) -> GeodesicPath:
        if start == end:
            return self._standing(start)
        rounds = 4 * self.surface.n_vertices  # a guard: each vertex is left a few times at most
        nodes, first, length, lengths = _find(start, end, self.exact, self.tolerance, rounds, self.mesh)
        if not np.isfinite(length):
            raise DisconnectedError(
                f"vertices {start} and {end} lie in different pieces of the surface "
                f"({self.surface.components[0]} pieces): there is no path between them"
            )
        left, right = nodes["left_angle"][1:-1], nodes["right_angle"][1:-1]
        total = left + right
        # Without any angle, where a mesh is drawn together to a point, nothing bends.
        kappa = 2 * np.pi / np.where(total > 0, total, 1.0) * (0.5 * total - right)
        return GeodesicPath(
            points=frozen(self._positions(nodes)),
            faces=frozen(nodes["face"].astype(np.int32)),
            barycentric=frozen(self._barycentric(nodes)),
            vertices=frozen(nodes["vertex"].astype(np.int32)),
            length=float(lengths[-1]),
            left_angle=frozen(left.copy()),
            right_angle=frozen(right.copy()),
            kappa_g=frozen(kappa),
            converged=self._is_locally_shortest(nodes["vertex"][1:-1], left, right, kappa),
            initial_points=frozen(self._positions(first)),
            lengths=frozen(np.concatenate([[length], lengths])),
        )

    def _is_locally_shortest(self, vertices: IntArray, left: FloatArray, right: FloatArray, kappa: FloatArray) -> bool:
        straight = np.abs(kappa) < self.tolerance
        smaller, larger = np.minimum(left, right), np.maximum(left, right)
        wide = np.pi - self.tolerance
        stays = (vertices >= 0) & (larger >= wide) & ((smaller >= wide) | self.mesh.boundary[vertices])
        return bool((straight | stays).all())

    def _positions(self, nodes: np.ndarray) -> FloatArray:
        t = nodes["t"][:, None]
        vertices = self.surface.vertices
        left, right = vertices[nodes["left"]], vertices[nodes["right"]]
        return np.where(nodes["vertex"][:, None] >= 0, left, (1.0 - t) * left + t * right)

    def _barycentric(self, nodes: np.ndarray) -> FloatArray:
        corners = self.surface.faces[nodes["face"]]
        t = np.where(nodes["vertex"] >= 0, 0.0, nodes["t"])[:, None]
        weights = (corners == nodes["left"][:, None]) * (1.0 - t)
        return weights + np.where(nodes["vertex"][:, None] >= 0, 0.0, (corners == nodes["right"][:, None]) * t)

    def _standing(self, vertex: int) -> GeodesicPath:
        """The path that stays where it is: start and end, no length."""
        at = np.argwhere(self.surface.faces == vertex)[:1]
        face, corner = at[0] if len(at) else (-1, -1)
        weights = np.zeros((2, 3))
        if corner >= 0:
            weights[:, corner] = 1.0
        points = frozen(np.repeat(self.surface.vertices[[vertex]], 2, axis=0))
        none = frozen(np.empty(0))
        return GeodesicPath(
            points=points,
            faces=frozen(np.full(2, face, dtype=np.int32)),
            barycentric=frozen(weights),
            vertices=frozen(np.full(2, vertex, dtype=np.int32)),
            length=0.0,
            left_angle=none,
            right_angle=none,
            kappa_g=none,
            converged=True,
            initial_points=points,
            lengths=frozen(np.zeros(1)),
        )
