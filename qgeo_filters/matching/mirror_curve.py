"""The curve on a surface that a reflection leaves in place, and the plane of one that is a reflection in space."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

# Loops shorter than this, in sqrt(area), are those of rounding about the curve.
_SHORT = 0.05


@dataclass(frozen=True, eq=False)
class MirrorPlane:
    """The plane in which a surface is its own mirror image, nearly.

    Attributes
    ----------
    normal : (3,) float64
        Unit vector; its sign has no meaning.
    origin : (3,) float64
        The point of the plane nearest to the centre of area.
    deviation : float
        Root mean square distance of the points, reflected, from their mirror points, in units of sqrt(area): 0 for an
        exact symmetry.
    """

    normal: FloatArray
    origin: FloatArray
    deviation: float

    def reflected(self, points: FloatArray) -> FloatArray:
        """Points (k, 3) reflected in the plane."""
        return points - 2 * ((points - self.origin) @ self.normal)[:, None] * self.normal


def mirror_plane(surface: Surface, images: FloatArray) -> MirrorPlane:
    """The plane that takes the vertices nearest to their mirror points, (n, 3), in the least squares sense.

    Points and their mirror points differ along the normal, and their middles lie in the plane.
    """
    weights = surface.vertex_areas / surface.area
    known = np.isfinite(images).all(axis=1)
    weights = weights[known] / weights[known].sum()
    points, images = surface.vertices[known], images[known]
    centre = weights @ (points + images) / 2
    one, other = points - centre, images - centre
    # The unit vector m for which p - 2 (p.m) m are nearest to q: the eigenvector of least eigenvalue of pq' + qp'.
    product = (one * weights[:, None]).T @ other
    normal = np.linalg.eigh(product + product.T)[1][:, 0]
    middle = weights @ points
    plane = MirrorPlane(frozen(normal), frozen(middle - ((middle - centre) @ normal) * normal), 0.0)
    gaps = np.linalg.norm(plane.reflected(points) - images, axis=1)
    return MirrorPlane(plane.normal, plane.origin, float(np.sqrt(weights @ gaps**2 / surface.area)))


def left_right_difference(surface: Surface, images: FloatArray, normals: FloatArray | None = None) -> FloatArray:
    """How far each vertex stands out of the mirror image of the other side, (n,), in the unit of the mesh.

    The other side is reflected in the plane of `mirror_plane`. The distance is measured along the normal at the vertex:
    positive where the shape has more than on the other side, negative where it has less. What a shape has bent to one
    side counts, too: it is meant for bones, not for poses.

    Parameters
    ----------
    surface : Surface
    images : (n, 3) float64
        Mirror point of each vertex, such as ``symmetry.barycentric.pulled_back(surface.vertices)``; NaN where there is
        none, and then in the result.
    normals : (n, 3) float64, optional
        Which way is out at each vertex; by default by the faces.
    """
    gaps = surface.vertices - mirror_plane(surface, images).reflected(images)
    return np.einsum("ij,ij->i", gaps, surface.vertex_normals if normals is None else normals)


def zero_curves(surface: Surface, values: FloatArray) -> tuple[FloatArray, ...]:
    """Polylines (k, 3) on the surface where a function, linear in each triangle, is zero, the longest first.

    A closed one ends where it begins. Those shorter than a twentieth of sqrt(area) are left out.
    """
    vertices, heights = np.ascontiguousarray(surface.vertices), np.ascontiguousarray(values)
    points, segments, _ = igl.isolines(vertices, surface.faces.astype(np.int64), heights, np.zeros(1))
    lines = [points[order] for order in _chains(len(points), segments)]
    lengths = [float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines]
    order = sorted(range(len(lines)), key=lambda i: -lengths[i])
    return tuple(frozen(lines[i]) for i in order if lengths[i] > _SHORT * np.sqrt(surface.area))


def _chains(count: int, segments: IndexArray) -> list[list[int]]:
    """Points of each connected line of segments, (m, 2), in order; where lines cross, each arm is one."""
    if not len(segments):
        return []
    graph = sparse.coo_array((np.ones(len(segments)), segments.T), shape=(count, count)).tocsr()
    graph = graph + graph.T
    neighbours = [set(graph.indices[graph.indptr[i] : graph.indptr[i + 1]].tolist()) for i in range(count)]
    label = connected_components(graph, directed=False)[1]
    # Ends and crossings first, so that an open line is walked from its end; then what is left are loops.
    degree = np.array([len(near) for near in neighbours])
    starts = np.lexsort((np.arange(count), degree == 2, label))
    chains = []
    for start in starts.tolist():
        while neighbours[start]:
            chain = [start]
            while neighbours[chain[-1]] and (len(chain) == 1 or degree[chain[-1]] == 2):
                after = min(neighbours[chain[-1]])
                neighbours[chain[-1]].discard(after)
                neighbours[after].discard(chain[-1])
                chain.append(after)
            chains.append(chain)
    return chains
