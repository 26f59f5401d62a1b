"""A surface that lies near another one, put onto it with few or no triangles turned over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.matching.maps.barycentric import nearest_around, triangles_around
from qgeo_filters.repair.welding import welded
from qgeo_filters.surface import Surface

# Rings around turned triangles that are evened out, and how often, in one attempt after the other.
_ATTEMPTS = ((0, 2), (1, 2), (1, 8), (2, 8), (3, 16), (4, 32)) * 2
# Rings of triangles that are looked at around the last vertex, and how often a point goes on from there.
_RINGS, _STEPS = 2, 6


def put_onto(body: Surface, target: Surface, starts: IndexArray) -> tuple[FloatArray, IndexArray]:
    """Vertices (n, 3) of a body that lies near a surface, on it, and the triangles that are turned over there.

    Each vertex goes to the nearest point, looked for along the surface from a vertex that is known to be near, so that
    sheets that pass close to each other are kept apart. Around triangles that are turned over vertices are moved
    to the means of their neighbours, and put onto the surface again, where that leaves fewer of them.

    Parameters
    ----------
    body, target : Surface
    starts : (n,) int64
        A vertex of the target near each vertex; -1: the vertex stays where it is.

    Returns
    -------
    vertices : (n, 3) float64
    turned : (k,) int64
        Triangles that look the other way than the surface does at their corners and at their middle.
    """
    sheet = _Sheet(target)
    place = sheet.nearest(body.vertices, starts)
    known = place.faces >= 0
    vertices = np.where(known[:, None], place.pulled_back(target.vertices), body.vertices)
    state = _State(vertices, place.nearest_corner, place.pulled_back(target.vertex_normals))
    # Inside-out surfaces are compared as they are: most triangles of the body show which way is out.
    sign = 1.0 if np.nanmedian(sheet.agreements(body.faces, state)[0]) >= 0 else -1.0
    turned = sheet.turned(body.faces, state, sign)
    neighbours = _neighbours(body)
    for rings, repeats in _ATTEMPTS:
        some = np.zeros(body.n_vertices, dtype=bool)
        some[body.faces[turned]] = True
        for _ in range(rings):
            some |= np.asarray(neighbours @ some) > 0
        moved = np.flatnonzero(some & known)
        if not turned.any() or not moved.size:
            break
        trial = sheet.evened_out(state, moved, neighbours, repeats)
        # Parts that touch in no triangle are judged one by one.
        part = np.full(body.n_vertices, -1)
        part[moved] = connected_components(neighbours[moved][:, moved], directed=False)[1]
        of_face = part[body.faces].max(axis=1)
        touched = np.flatnonzero(of_face >= 0)
        after = sheet.turned(body.faces[touched], trial, sign)
        change = np.bincount(of_face[touched], after.astype(float) - turned[touched])
        state = state.where(np.isin(part, np.flatnonzero(change < 0)), trial)
        better = change[of_face[touched]] < 0
        turned[touched[better]] = after[better]
    return state.vertices, np.flatnonzero(turned)


@dataclass(frozen=True, eq=False)
class _State:
    """Places (n, 3), a vertex of the surface near each, and the surface's normals there."""

    vertices: FloatArray
    near: IndexArray
    normals: FloatArray

    def where(self, chosen: npt.NDArray[np.bool_], other: _State) -> _State:
        """The other state of some vertices, this one of the rest."""
        column = chosen[:, None]
        return _State(
            np.where(column, other.vertices, self.vertices),
            np.where(chosen, other.near, self.near),
            np.where(column, other.normals, self.normals),
        )


class _Sheet:
    """A surface along which nearest points are looked for."""

    def __init__(self, target: Surface) -> None:
        self.target, self._joined = target, welded(target.vertices, target.faces)[0]
        self._around = triangles_around(target.vertices, target.faces, self._joined, _RINGS)

    def nearest(self, points: FloatArray, starts: IndexArray, steps: int = _STEPS) -> BarycentricMap:
        """Nearest point to each, going on from the nearest vertex as long as that changes."""
        vertices, faces = self.target.vertices, self.target.faces
        for _ in range(steps):
            place = nearest_around(points, starts, vertices, faces, self._joined, _RINGS, self._around)
            before, starts = starts, place.nearest_corner
            if np.array_equal(before, starts):
                break
        return place

    def evened_out(self, state: _State, moved: IndexArray, means: sparse.csr_array, repeats: int) -> _State:
        """Some vertices moved to the means of their neighbours, and put onto the surface, so many times."""
        vertices, near, normals = state.vertices.copy(), state.near.copy(), state.normals.copy()
        for _ in range(repeats):
            vertices[moved] = means[moved] @ vertices
            there = self.nearest(vertices[moved], near[moved], steps=1)
            vertices[moved], near[moved] = there.pulled_back(self.target.vertices), there.nearest_corner
            normals[moved] = there.pulled_back(self.target.vertex_normals)
        return _State(vertices, near, normals)

    def agreements(self, faces: npt.NDArray[np.int32], state: _State) -> tuple[FloatArray, FloatArray]:
        """Products of each triangle's normal with those of the surface at its corners, and at its middle; NaN: none."""
        corners = state.vertices[faces]
        crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        middle = self.nearest(corners.mean(axis=1), state.near[faces[:, 0]], steps=2)
        there = np.where((middle.faces >= 0)[:, None], self.target.face_normals[middle.faces], np.nan)
        at_corners = np.einsum("ij,ij->i", crosses, state.normals[faces].sum(axis=1))
        return at_corners, np.einsum("ij,ij->i", crosses, there)

    def turned(self, faces: npt.NDArray[np.int32], state: _State, sign: float) -> npt.NDArray[np.bool_]:
        """Whether each triangle looks the other way, at its corners and at its middle."""
        at_corners, in_the_middle = self.agreements(faces, state)
        return (sign * at_corners < 0) & (sign * in_the_middle < 0)


def _neighbours(body: Surface) -> sparse.csr_array:
    """Matrix (n, n) that takes the mean over the neighbours of each vertex."""
    i, j = body.edges.T
    n = body.n_vertices
    matrix = sparse.csr_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), (n, n))
    count = np.asarray(matrix.sum(axis=1)).ravel()
    return sparse.csr_array(sparse.diags_array(1 / np.maximum(count, 1)) @ matrix)
