"""Connectivity of triangle lists: edges, neighbours, boundary, pieces and what is not a surface.

Everything here is a pure function of the face list; half-edge ``(f, k)`` runs from ``faces[f, k]`` to
``faces[f, (k + 1) % 3]`` and is numbered ``3 f + k``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from qgeo_filters._typing import IndexArray, IntArray


def unique_edges(faces: IntArray) -> tuple[IntArray, IntArray, npt.NDArray[np.int64]]:
    """Undirected edges, the edge of every half-edge, and how many faces meet at each edge.

    Returns
    -------
    edges : (E, 2) int32
        Vertex pairs, smaller index first, in lexicographic order.
    face_edges : (m, 3) int32
        Edge of half-edge k of each face.
    counts : (E,) int64
        Number of incident faces.
    """
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    ends.sort(axis=1)
    stride = int(ends.max()) + 1 if ends.size else 1
    keys, inverse, counts = np.unique(ends[:, 0] * stride + ends[:, 1], return_inverse=True, return_counts=True)
    edges = np.column_stack([keys // stride, keys % stride]).astype(np.int32)
    return edges, inverse.reshape(-1, 3).astype(np.int32), counts


def halfedge_twins(faces: IntArray, face_edges: IntArray, n_edges: int) -> IntArray:
    """Half-edge on the other side of each half-edge, -1 on the boundary and where three faces meet.

    Orientation is not assumed: across an edge of two faces that disagree, the twin runs the same way.

    Returns
    -------
    twins : (m, 3) int32
    """
    flat = face_edges.ravel()
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(n_edges))
    counts = np.bincount(flat, minlength=n_edges)
    twins = np.full(flat.size, -1, dtype=np.int32)
    pairs = starts[counts == 2]
    first, second = order[pairs], order[pairs + 1]
    twins[first], twins[second] = second, first
    return twins.reshape(faces.shape)


def flipped_edges(faces: IntArray, twins: IntArray) -> npt.NDArray[np.int64]:
    """Half-edges whose twin runs the same way, so that the two faces disagree on the orientation."""
    half = np.flatnonzero(twins.ravel() >= 0)
    other = twins.ravel()[half]
    return half[(faces.ravel()[half] == faces.ravel()[other]) & (half < other)]


def corner_fans(faces: IntArray, twins: IntArray) -> IntArray:
    """Fan to which each corner belongs, shape (3 m,): corners at one vertex, joined across shared edges."""
    m = len(faces)
    half = np.flatnonzero(twins.ravel() >= 0)
    other = twins.ravel()[half]
    tail = faces.ravel()[half]
    f, k = half // 3, half % 3
    g, j = other // 3, other % 3
    same = faces[g, j] == tail
    at_tail = np.where(same, 3 * g + j, 3 * g + (j + 1) % 3)
    at_head = np.where(same, 3 * g + (j + 1) % 3, 3 * g + j)
    rows = np.concatenate([half, 3 * f + (k + 1) % 3])
    columns = np.concatenate([at_tail, at_head])
    graph = sparse.coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), shape=(3 * m, 3 * m))
    return connected_components(graph, directed=False)[1].astype(np.int32)


def nonmanifold_vertices(faces: IntArray, twins: IntArray, n_vertices: int) -> npt.NDArray[np.int64]:
    """Vertices whose faces do not form one fan or one disc (bow-ties).

    Two corners at a vertex are joined where their faces share an edge at that vertex; a vertex of a
    surface has all of its corners in one component. Edges of three and more faces join nothing here,
    so the ends of such an edge are listed too.
    """
    fan = corner_fans(faces, twins)
    vertex_of_fan = np.zeros(int(fan.max()) + 1, dtype=np.int64)
    vertex_of_fan[fan] = faces.ravel()
    return np.flatnonzero(np.bincount(vertex_of_fan, minlength=n_vertices) > 1)


def vertex_components(edges: IntArray, n_vertices: int) -> tuple[int, IntArray]:
    """Number of connected pieces and the piece of every vertex; a vertex without faces is a piece."""
    graph = sparse.coo_matrix(
        (np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), shape=(n_vertices, n_vertices)
    )
    count, labels = connected_components(graph, directed=False)
    return int(count), labels.astype(np.int32)


def boundary_loops(boundary_edges: IntArray) -> list[IntArray]:
    """Closed chains of boundary vertices from the edges (b, 2) with one face, longest loop first."""
    neighbours: dict[int, list[int]] = {}
    for tail, head in boundary_edges.tolist():
        neighbours.setdefault(tail, []).append(head)
        neighbours.setdefault(head, []).append(tail)
    loops = []
    for start in sorted(neighbours):
        if not neighbours[start]:
            continue
        loop = [start]
        here = start
        while neighbours[here]:
            there = neighbours[here].pop()
            neighbours[there].remove(here)
            if there == start:
                break
            loop.append(there)
            here = there
        loops.append(np.array(loop, dtype=np.int32))
    return sorted(loops, key=len, reverse=True)


def smallest_connected(pairs: IndexArray, n: int) -> IndexArray:
    """Smallest member of the group of each of n things, of which these pairs (m, 2) belong together; shape (n,)."""
    graph = sparse.coo_matrix((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    count, group = connected_components(graph, directed=False)
    smallest = np.full(count, n, dtype=np.int64)
    np.minimum.at(smallest, group, np.arange(n))
    return smallest[group]
