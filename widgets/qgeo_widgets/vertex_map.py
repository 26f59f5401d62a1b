"""A point map between two surfaces as the widgets use it: forwards, backwards, and which way round."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.surface import Surface
from qgeo_filters.validation import listed


class VertexMap:
    """Map from the vertices of X to those of Y, checked.

    Parameters
    ----------
    x, y : Surface
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X.
    name : str
        What the caller calls the map, for messages.

    Raises
    ------
    ParameterError
        Wrong length, not whole numbers, or a vertex that Y does not have.
    """

    def __init__(self, x: Surface, y: Surface, p2p: npt.ArrayLike, name: str = "p2p") -> None:
        try:
            table = np.asarray(p2p)
        except ValueError as error:  # rows of different lengths
            raise ParameterError(f"{name} must be {x.n_vertices} vertex indices in one row: {error}") from error
        if table.shape != (x.n_vertices,) or table.dtype.kind not in "iu":
            raise ParameterError(
                f"{name} must be {x.n_vertices} vertex indices, one for each vertex of X, "
                f"got {table.dtype} of shape {table.shape}"
            )
        outside = np.flatnonzero((table < 0) | (table >= y.n_vertices))
        if outside.size:
            raise ParameterError(
                f"{name}[{outside[0]}] is vertex {table[outside[0]]}, but Y has {y.n_vertices} vertices "
                f"({outside.size} such: {listed(outside)})"
            )
        self.x, self.y = x, y
        self.forward: IndexArray = table.astype(np.int64)

    @cached_property
    def backward(self) -> IndexArray:
        """A vertex of X for each vertex of Y, (n_y,): one that is mapped there, or nearest to it along edges."""
        vertices, first = np.unique(self.forward, return_index=True)
        a, b = self.y.edges.T
        n = self.y.n_vertices
        edges = sparse.csr_matrix((self.y.edge_lengths, (a, b)), shape=(n, n))
        _, _, nearest = dijkstra(edges, directed=False, indices=vertices, min_only=True, return_predecessors=True)
        # Pieces of Y that nothing is mapped to take whatever comes first.
        nearest = np.where(nearest < 0, vertices[0], nearest)
        origin = np.zeros(n, dtype=np.int64)
        origin[vertices] = first
        return origin[nearest]

    @cached_property
    def orientation(self) -> float:
        """From -1 to 1: how far mapped triangles face the way Y does, see `qgeo_filters.matching.maps.orientation`."""
        return orientation(self.x, self.y, self.forward)

    def then(self, on_y: npt.ArrayLike) -> VertexMap:
        """The map followed by a map of Y to itself."""
        return VertexMap(self.x, self.y, np.asarray(on_y)[self.forward])
