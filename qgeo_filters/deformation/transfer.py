"""A deformation of one surface on another, along a map between the two."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import PoissonSolver, area_shares
from qgeo_filters.surface import Surface

# Points of a triangle at which gradients are read: near its corners, the middles of its sides, and its centre.
_SAMPLES = 0.2 / 3 + 0.8 * np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [1 / 3, 1 / 3, 1 / 3]]
)
# The image of a triangle is torn where it is so many times longer than the triangle, or those of the image.
_TORN = 4.0


class GradientTransfer:
    r"""Poses of Y that deform it as those of X deform X: one factorisation for any number of them.

    Each triangle of Y is given the deformation gradient that X has at the triangle's image, and each vertex is drawn
    to :math:`P(x_i) + R_i (v_i - x_i)`: the pose at its image, and what separated the two at rest, turned as X is
    turned there. So what Y has of its own (details, thicker limbs, and errors of the map too) is carried along, and
    ends of limbs stay where those of X stay.

    Parameters
    ----------
    x : Surface
        At rest, in the frame and size of Y.
    y : Surface
        At rest, in the same pose as X.
    place : BarycentricMap
        Point of X for each vertex of Y. Where there is none, the gradient is that of the nearest triangle that has one,
        and a piece without any goes where its nearest vertex with one goes.
    length : float
        Above which positions count rather than gradients, in sqrt(area).

    References
    ----------
    Sumner and Popovic, "Deformation transfer for triangle meshes", SIGGRAPH 2004.
    """

    def __init__(self, x: Surface, y: Surface, place: BarycentricMap, length: float) -> None:
        known = place.faces >= 0
        self._frames = TriangleFrames(x.vertices, x.faces)
        self._sampling = _sampling(x, y, place, self._frames.flat)
        self._at_corners = _corner_means(x, self._frames.flat)
        nearest = np.flatnonzero(known)[cKDTree(y.vertices[known]).query(y.vertices)[1]]
        self._images = _interpolation(x, place, np.where(known, np.arange(y.n_vertices), nearest))
        self._offsets = y.vertices - self._images @ x.vertices
        _, piece = y.components
        placed = known | ~np.isin(piece, piece[known])
        self._solver = PoissonSolver(y.vertices, y.faces, area_shares(y) * placed / length**2)

    def __call__(self, pose: FloatArray) -> FloatArray:
        """Positions (n_y, 3) of Y in a pose (n_x, 3) of X."""
        flat = self._frames.gradients(pose).reshape(-1, 9)
        gradients = (self._sampling @ flat).reshape(-1, 3, 3)
        turned = fit_rotations((self._images @ (self._at_corners @ flat)).reshape(-1, 3, 3))
        targets = self._images @ pose + np.einsum("nij,nj->ni", turned, self._offsets)
        return self._solver(gradients, targets)


def _interpolation(x: Surface, place: BarycentricMap, of: IndexArray) -> sparse.csr_array:
    """Matrix (n_y, n_x): values of X at the points of these vertices of Y."""
    row = np.repeat(np.arange(len(of)), 3)
    entries = place.coordinates[of].ravel(), (row, place.corners[of].ravel())
    return sparse.csr_array(entries, (len(of), x.n_vertices))


def _sampling(x: Surface, y: Surface, place: BarycentricMap, flat: np.ndarray) -> sparse.csr_array:
    """Matrix (m_y, m_x): the mean over the triangles of X on which points spread over a triangle of Y lie."""
    known = (place.faces >= 0)[y.faces].all(axis=1)
    images = place.pulled_back(x.vertices)
    torn = _longest(images, y.faces) > _TORN * np.maximum(_longest(y.vertices, y.faces), np.sqrt(x.area / x.n_faces))
    inside, apart = np.flatnonzero(known & ~torn), np.flatnonzero(known & torn)
    points = np.einsum("sk,tkc->tsc", _SAMPLES, images[y.faces[inside]])
    found = closest_points(points.reshape(-1, 3), x).faces
    # Between the images of the corners of a torn triangle may lie anything.
    row = np.concatenate([np.repeat(inside, len(_SAMPLES)), np.repeat(apart, 3)])
    column = np.concatenate([found, place.faces[y.faces[apart]].ravel()])
    row, column = row[~flat[column]], column[~flat[column]]
    shares = sparse.csr_array((np.ones(len(row)), (row, column)), (y.n_faces, x.n_faces))
    total = np.asarray(shares.sum(axis=1)).ravel()
    return _with_nearest_rows(sparse.csr_array(sparse.diags_array(1 / np.maximum(total, 1)) @ shares), total > 0, y)


def _longest(points: FloatArray, faces: np.ndarray) -> FloatArray:
    corners = points[faces]
    sides: FloatArray = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return sides


def _with_nearest_rows(rows: sparse.csr_array, known: np.ndarray, y: Surface) -> sparse.csr_array:
    """The same, rows of triangles that are not known being those of the nearest known ones."""
    if known.all():
        return rows
    centres = y.vertices[y.faces].mean(axis=1)
    _, nearest = cKDTree(centres[known]).query(centres)
    return sparse.csr_array(rows[np.where(known, np.arange(len(known)), np.flatnonzero(known)[nearest])])


def _corner_means(x: Surface, flat: np.ndarray) -> sparse.csr_array:
    """Matrix (n_x, m_x): the mean by area over the triangles around a vertex."""
    areas = np.repeat(np.where(flat, 0.0, x.face_areas), 3)
    column = np.repeat(np.arange(x.n_faces), 3)
    sums = sparse.csr_array((areas, (x.faces.ravel(), column)), (x.n_vertices, x.n_faces))
    total = np.asarray(sums.sum(axis=1)).ravel()
    return sparse.csr_array(sparse.diags_array(np.divide(1.0, total, out=np.zeros_like(total), where=total > 0)) @ sums)
