"""Analytic, animal-like and deliberately bad meshes, as (vertices, faces).

The one home of shapes that several tests take. Each is built once in a process and is read-only: who wants to change
one copies it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec

import igl
import numpy as np
from scipy.spatial import Delaunay

Mesh = tuple[np.ndarray, np.ndarray]
P = ParamSpec("P")


def built_once(function: Callable[P, Mesh]) -> Callable[P, Mesh]:
    """The function with its results kept and their arrays read-only."""

    @functools.cache
    def kept(*args: P.args, **kwargs: P.kwargs) -> Mesh:
        mesh = function(*args, **kwargs)
        for array in mesh:
            array.flags.writeable = False
        return mesh

    return functools.wraps(function)(kept)


@built_once
def grid(n: int = 10, jitter: float = 0.0, seed: int = 0) -> Mesh:
    """Unit square in the plane z = 0 with n x n cells; interior vertices moved by up to ``jitter`` cells."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    if jitter:
        inside = ((vertices[:, :2] > 1e-9) & (vertices[:, :2] < 1 - 1e-9)).all(axis=1)
        noise = np.random.default_rng(seed).uniform(-jitter, jitter, (inside.sum(), 2)) / n
        vertices[inside, :2] += noise
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a = (i * (n + 1) + j).ravel()
    b, c, d = a + n + 1, a + n + 2, a + 1
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return vertices, faces.astype(np.int32)


@built_once
def icosphere(level: int = 3, radius: float = 1.0) -> Mesh:
    """Icosahedron refined ``level`` times, vertices on the sphere."""
    t = (1 + 5**0.5) / 2
    vertices = np.array(
        [[-1, t, 0], [1, t, 0], [-1, -t, 0], [1, -t, 0], [0, -1, t], [0, 1, t],
         [0, -1, -t], [0, 1, -t], [t, 0, -1], [t, 0, 1], [-t, 0, -1], [-t, 0, 1]], dtype=float,
    )  # fmt: skip
    faces = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
         [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5],
         [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]], dtype=np.int64,
    )  # fmt: skip
    for _ in range(level):
        vertices, faces = igl.upsample(vertices, faces)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return radius * vertices, faces.astype(np.int32)


@built_once
def cylinder(n_around: int = 40, n_along: int = 20, radius: float = 1.0, height: float = 2.0) -> Mesh:
    """Open cylinder about the z axis."""
    angle = np.linspace(0, 2 * np.pi, n_around, endpoint=False)
    z = np.linspace(0, height, n_along + 1)
    vertices = np.array([[radius * np.cos(t), radius * np.sin(t), h] for h in z for t in angle])
    faces = []
    for i in range(n_along):
        for j in range(n_around):
            a, b = i * n_around + j, i * n_around + (j + 1) % n_around
            c, d = a + n_around, b + n_around
            faces += [[a, b, d], [a, d, c]]
    return vertices, np.array(faces, dtype=np.int32)


@built_once
def cone(n_around: int = 40, n_along: int = 20, slope: float = 1.0) -> Mesh:
    """Open cone with apex (vertex 0) at the origin, z = slope * r, r up to 1."""
    angle = np.linspace(0, 2 * np.pi, n_around, endpoint=False)
    rings = [[r * np.cos(t), r * np.sin(t), slope * r] for r in np.arange(1, n_along + 1) / n_along for t in angle]
    vertices = np.array([[0.0, 0.0, 0.0], *rings])
    faces = [[0, 1 + j, 1 + (j + 1) % n_around] for j in range(n_around)]
    for i in range(n_along - 1):
        for j in range(n_around):
            a, b = 1 + i * n_around + j, 1 + i * n_around + (j + 1) % n_around
            c, d = a + n_around, b + n_around
            faces += [[a, d, b], [a, c, d]]
    return vertices, np.array(faces, dtype=np.int32)


@built_once
def torus(n_around: int = 40, n_tube: int = 20, radius: float = 1.0, tube: float = 0.4) -> Mesh:
    """Closed torus about the z axis."""
    u, v = np.meshgrid(np.arange(n_around), np.arange(n_tube), indexing="ij")
    s, t = 2 * np.pi * u.ravel() / n_around, 2 * np.pi * v.ravel() / n_tube
    ring = radius + tube * np.cos(t)
    vertices = np.column_stack([ring * np.cos(s), ring * np.sin(s), tube * np.sin(t)])
    a = (u * n_tube + v).ravel()
    b = (((u + 1) % n_around) * n_tube + v).ravel()
    c = (((u + 1) % n_around) * n_tube + (v + 1) % n_tube).ravel()
    d = (u * n_tube + (v + 1) % n_tube).ravel()
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]).astype(np.int32)


@built_once
def blob(level: int = 3, seed: int = 0, strength: float = 0.35) -> Mesh:
    """Closed smooth shape without any symmetry: a sphere displaced by a few random harmonics."""
    vertices, faces = icosphere(level)
    rng = np.random.default_rng(seed)
    radius = np.ones(len(vertices))
    for degree in (1, 2, 3):
        for _ in range(3):
            axis = rng.normal(size=3)
            axis /= np.linalg.norm(axis)
            radius += strength / 3 * rng.normal() * np.cos(degree * np.arccos(np.clip(vertices @ axis, -1, 1)))
    return vertices * np.maximum(radius, 0.3)[:, None], faces


@built_once
def limbed(directions: tuple[tuple[float, ...], ...], lengths: tuple[float, ...], level: int = 3) -> Mesh:
    """A round body with a limb of a given length in each direction."""
    vertices, faces = icosphere(level)
    radius = np.full(len(vertices), 0.6)
    for direction, length in zip(directions, lengths, strict=True):
        radius += length * np.exp(12 * (vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return vertices * radius[:, None], faces


def crooked(seed: int, level: int = 3) -> Mesh:
    """A body with five unequal limbs in random directions: no left and right."""
    directions = np.random.default_rng(seed).normal(size=(5, 3))
    return limbed(tuple(map(tuple, directions.tolist())), (1.3, 1.0, 0.8, 0.6, 0.5), level)


def reflected(mesh: Mesh) -> Mesh:
    """The mirror image of a mesh, faces turned over so that they look outwards again."""
    return mesh[0] * [-1, 1, 1], mesh[1][:, ::-1]


def creature(left: float = 1.2, level: int = 3) -> Mesh:
    """A body with head, tail and two pairs of limbs, mirrored in x = 0 unless ``left``, a length, is not 1.2."""
    directions = ((0.6, 0.7, -0.6), (-0.6, 0.7, -0.6), (0.6, -0.7, -0.6), (-0.6, -0.7, -0.6), (0, 1, 0.4), (0, -1, 0.2))
    return limbed(directions, (1.2, left, 0.9, 0.9, 0.8, 0.5), level)


def bent(vertices: np.ndarray, amount: float) -> np.ndarray:
    """Positions bent about the x axis, nearly without stretching."""
    x, y, z = vertices.T
    angle = amount * y
    return np.column_stack([x, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)])


def arched(vertices: np.ndarray, curvature: float) -> np.ndarray:
    """Positions bent about the x axis so that the y axis becomes a circle of the same length."""
    x, y, z = vertices.T
    radius = 1 / curvature
    return np.column_stack([x, (radius + z) * np.sin(y / radius), (radius + z) * np.cos(y / radius) - radius])


@built_once
def terrain(n: int, seed: int, roughness: float = 0.0, stretch: float = 1.0) -> Mesh:
    """Delaunay triangles over random points of a rectangle, needles at its border included, at random heights.

    Where it is rough nearly every vertex is a saddle or a peak; with ``roughness`` 0 it is a plane.
    """
    rng = np.random.default_rng(seed)
    points = rng.uniform(size=(n, 2)) * [1.0, stretch]
    faces = Delaunay(points).simplices.astype(np.int32)
    return np.column_stack([points, roughness * rng.normal(size=n)]), faces


@built_once
def moebius(n: int = 40, width: int = 4) -> Mesh:
    """Moebius band: manifold, not orientable."""
    s = np.linspace(-0.3, 0.3, width + 1)
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    vertices = np.array(
        [[(1 + w * np.cos(t / 2)) * np.cos(t), (1 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)]
         for t in angle for w in s]
    )  # fmt: skip
    faces = []
    for i in range(n):
        for j in range(width):
            a, b = i * (width + 1) + j, i * (width + 1) + j + 1
            if i + 1 < n:
                c, d = a + width + 1, b + width + 1
            else:
                c, d = width - j, width - j - 1
            faces += [[a, c, b], [b, c, d]]
    return vertices, np.array(faces, dtype=np.int32)


@built_once
def bow_tie() -> Mesh:
    """Two triangles that share one vertex only."""
    vertices = np.array([[0, 0, 0], [1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float)
    return vertices, np.array([[0, 2, 1], [0, 3, 4]], dtype=np.int32)


@built_once
def fan() -> Mesh:
    """Three triangles on one edge."""
    vertices = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float)
    return vertices, np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]], dtype=np.int32)
