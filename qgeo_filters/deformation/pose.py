"""A surface in the pose of another one, with its own shape."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.deformation.arap import ArapSolver, Pull
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import PoissonSolver, area_shares
from qgeo_filters.surface import Surface

# How often rotations are averaged over neighbours in each of the first passes (targets fold where the map does), and
# how many passes there are after these.
_SMOOTHING, _PASSES = (8, 8, 4, 4, 2, 2, 1, 1), 40

# Length below which targets are not followed where they only are to be kept.
_EXACTLY = 1e-3


def posed(surface: Surface, targets: FloatArray, turning: float, placing: float) -> FloatArray:
    """Positions (n, 3) of a surface in the pose that targets are in, its own shape kept.

    First it is deformed towards the targets as rigidly as possible, which says how each triangle is turned; then
    it is put together of its triangles so turned.

    Parameters
    ----------
    surface : Surface
    targets : (n, 3) float64
        Place of each vertex on the other shape, in the surface's size; NaN where there is none. A piece without any
        is carried along by the nearest triangle of the others.
    turning, placing : float
        Lengths in sqrt(area) below which targets are not followed, by the rotations and by the result: short where both
        are one body, long where they are two of different proportions.
    """
    unit = np.sqrt(surface.area)
    known = np.asarray(np.isfinite(targets).all(axis=1))
    vertices = surface.vertices / unit
    _, piece = surface.components
    lone = ~np.isin(piece, piece[known])
    share = area_shares(surface) * (known | lone)
    goal = np.where(lone[:, None], vertices, np.where(known[:, None], targets, 0.0) / unit)
    arap = ArapSolver(vertices, surface.faces)
    pull = Pull("pose", share / turning**2)
    solve = arap.prefactor(pull)
    positions = goal if (known | lone).all() else _harmonic_extension(vertices, surface.faces, share, goal)
    for smoothing in (*_SMOOTHING, *(0,) * _PASSES):
        positions = arap.iterate(solve, pull, positions, goal, smoothing)
    arap.release()
    turned = fit_rotations(TriangleFrames(vertices, surface.faces).gradients(positions))
    placed = PoissonSolver(vertices, surface.faces, share / placing**2)(turned, goal)
    if lone.any():
        placed[lone] = _carried(vertices, placed, turned, surface.faces, lone, piece[lone])
    return unit * placed


def _carried(
    rest: FloatArray,
    placed: FloatArray,
    turned: FloatArray,
    faces: IntArray,
    lone: npt.NDArray[np.bool_],
    piece: IntArray,
) -> FloatArray:
    """Positions of lone vertices, each piece moved as the triangle nearest to it of those that are not lone."""
    triangles = np.flatnonzero(~lone[faces[:, 0]])
    centres = rest[faces[triangles]].mean(axis=1)
    gaps, nearest = map(np.asarray, cKDTree(centres).query(rest[lone]))
    order = np.lexsort((gaps, piece))
    _, first, label = np.unique(piece[order], return_index=True, return_inverse=True)
    near = np.empty_like(nearest)
    near[order] = nearest[order][first][label]
    carried = np.einsum("nij,nj->ni", turned[triangles[near]], rest[lone] - centres[near])
    return carried + placed[faces[triangles[near]]].mean(axis=1)


def _harmonic_extension(vertices: FloatArray, faces: IntArray, share: FloatArray, goal: FloatArray) -> FloatArray:
    """The goal where a vertex has one, and harmonic in between, so that it is spread evenly."""
    flat = np.zeros((len(faces), 3, 3))
    return PoissonSolver(vertices, faces, share / _EXACTLY**2)(flat, goal)
