"""Which triangles share edges and vertices: what is known of a mesh, wherever its vertices are."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from qgeo_filters import connectivity
from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.errors import NonManifoldError
from qgeo_filters.validation import listed, owned


class MeshConnectivity:
    """Edges, pieces, boundary and genus of a triangle mesh, each computed once, on first use; read-only.

    Attributes
    ----------
    vertices : (n, 3) float64
        Of which only the number counts here.
    faces : (m, 3) int32
        Checked: vertices from 0 to n - 1, three different ones each.
    """

    vertices: FloatArray
    faces: IntArray

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    @cached_property
    def _edge_table(self) -> tuple[IntArray, IntArray, npt.NDArray[np.int64]]:
        edges, face_edges, counts = connectivity.unique_edges(self.faces)
        return owned(edges), owned(face_edges), owned(counts)

    @property
    def edges(self) -> IntArray:
        """Undirected edges, shape (E, 2), smaller vertex first."""
        return self._edge_table[0]

    @property
    def face_edges(self) -> IntArray:
        """Edge of each half-edge, shape (m, 3); half-edge k runs from corner k to corner k + 1."""
        return self._edge_table[1]

    @cached_property
    def twins(self) -> IntArray:
        """Half-edge across each half-edge as ``3 f + k``, shape (m, 3); -1 on the boundary."""
        return owned(connectivity.halfedge_twins(self.faces, self.face_edges, len(self.edges)))

    @cached_property
    def components(self) -> tuple[int, IntArray]:
        """Number of pieces and the piece of each vertex; a vertex without faces counts as one."""
        count, labels = connectivity.vertex_components(self.edges, self.n_vertices)
        return count, owned(labels)

    @cached_property
    def unreferenced_vertices(self) -> npt.NDArray[np.int64]:
        """Vertices that no face names."""
        return owned(np.flatnonzero(np.bincount(self.faces.ravel(), minlength=self.n_vertices) == 0))

    @cached_property
    def boundary_edges(self) -> npt.NDArray[np.int64]:
        """Indices of the edges with one face."""
        return owned(np.flatnonzero(self._edge_table[2] == 1))

    @property
    def boundary_vertices(self) -> IntArray:
        """Vertices on the boundary, in increasing order."""
        return np.unique(self.edges[self.boundary_edges])

    @cached_property
    def boundary_loops(self) -> tuple[IntArray, ...]:
        """Boundary curves as vertex chains, longest first."""
        return tuple(owned(loop) for loop in connectivity.boundary_loops(self.edges[self.boundary_edges]))

    @property
    def is_closed(self) -> bool:
        """Whether no edge has fewer than two faces."""
        return self.boundary_edges.size == 0

    @cached_property
    def nonmanifold_edges(self) -> npt.NDArray[np.int64]:
        """Indices of the edges with three faces or more."""
        return owned(np.flatnonzero(self._edge_table[2] > 2))

    @cached_property
    def nonmanifold_vertices(self) -> npt.NDArray[np.int64]:
        """Vertices whose faces form more than one fan."""
        return owned(connectivity.nonmanifold_vertices(self.faces, self.twins, self.n_vertices))

    @property
    def is_manifold(self) -> bool:
        """Whether every edge has at most two faces and every vertex one fan of faces."""
        return self.nonmanifold_edges.size == 0 and self.nonmanifold_vertices.size == 0

    @cached_property
    def is_oriented(self) -> bool:
        """Whether neighbouring faces agree on which side is out."""
        return connectivity.flipped_edges(self.faces, self.twins).size == 0

    @property
    def euler_characteristic(self) -> int:
        """V - E + F over the vertices that have faces."""
        return self.n_vertices - self.unreferenced_vertices.size - len(self.edges) + self.n_faces

    @property
    def genus(self) -> int | None:
        """Handles, summed over the pieces, boundary loops capped; None for what is no oriented surface."""
        if not (self.is_manifold and self.is_oriented):
            return None
        pieces = self.components[0] - self.unreferenced_vertices.size
        return (2 * pieces - self.euler_characteristic - len(self.boundary_loops)) // 2

    def require_manifold(self, purpose: str) -> None:
        """Raise `NonManifoldError`, naming the first offending edge or vertex, unless manifold."""
        bad = self.nonmanifold_edges
        if bad.size:
            a, b = self.edges[bad[0]].tolist()
            count = int(self._edge_table[2][bad[0]])
            raise NonManifoldError(
                f"{purpose} needs a manifold mesh, but edge ({a}, {b}) has {count} faces "
                f"({bad.size} such {'edge' if bad.size == 1 else 'edges'}); repair=True splits or removes them"
            )
        bad = self.nonmanifold_vertices
        if bad.size:
            raise NonManifoldError(
                f"{purpose} needs a manifold mesh, but the faces at vertex {bad[0]} form more than one fan "
                f"({bad.size} such {'vertex' if bad.size == 1 else 'vertices'}: {listed(bad)}); "
                "repair=True splits them"
            )
