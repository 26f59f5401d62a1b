"""What scanners, converters and hands do to a mesh, made of a tidy one: it stays known which vertex is which."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

Random = np.random.Generator


@dataclass(frozen=True, eq=False)
class Messy:
    """A mesh with something wrong.

    Attributes
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int
    origin : (n,) int
        Vertex of the tidy mesh that each was, -1 for what was added.
    """

    vertices: np.ndarray
    faces: np.ndarray
    origin: np.ndarray


Mess = Callable[[np.ndarray, np.ndarray, Random], Messy]


def tidy(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """The mesh itself."""
    return Messy(vertices, faces, np.arange(len(vertices)))


def unwelded(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Each triangle with corners of its own, as STL has them."""
    return Messy(vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3), faces.ravel())


def rounded(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """The same, far from the origin in single precision, each corner rounded by itself."""
    soup = unwelded(vertices, faces, random)
    size = np.ptp(vertices, axis=0).max()
    step = np.spacing(np.float32(20 * size))
    moved = soup.vertices - vertices.min(axis=0) + 10 * size
    moved = moved + random.integers(-1, 2, moved.shape) * step
    return Messy(moved.astype(np.float32).astype(np.float64), soup.faces, soup.origin)


def seams(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Cut into charts along three planes, as texture coordinates cut it, with vertices of their own on both sides."""
    centre = vertices[faces].mean(axis=1)
    chart = (centre > np.median(centre, axis=0)) @ [1, 2, 4]
    pairs, corner = np.unique(np.column_stack([np.repeat(chart, 3), faces.ravel()]), axis=0, return_inverse=True)
    return Messy(vertices[pairs[:, 1]], corner.reshape(-1, 3), pairs[:, 1])


def duplicates(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """A fifth of the faces twice, in any orientation, and a copy of the whole mesh on it."""
    again = faces[random.choice(len(faces), len(faces) // 5, replace=False)]
    again[::2] = again[::2, ::-1]
    n = len(vertices)
    return Messy(
        np.concatenate([vertices, vertices]),
        np.concatenate([faces, again, faces + n]),
        np.concatenate([np.arange(n), np.arange(n)]),
    )


def degenerate(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Faces that name a vertex twice, edges of length zero, and vertices in the middle of edges with flat faces."""
    n, k = len(vertices), 50
    split = random.choice(len(faces), k, replace=False)
    a, b, c = faces[split].T
    # A face (a, b, c) becomes (a, m, c), (m, b, c) and the flat (a, b, m).
    middle, twin = n + np.arange(k), n + k + np.arange(k)
    points = np.concatenate([vertices, (vertices[a] + vertices[b]) / 2, vertices[c]])
    new = [np.column_stack(rows) for rows in ((a, middle, c), (middle, b, twin), (middle, twin, c), (a, b, middle))]
    new += [np.column_stack([b, c, twin]), np.column_stack([a, a, b])]
    added = np.concatenate([np.full(k, -1), c])
    return Messy(points, np.concatenate([np.delete(faces, split, axis=0), *new]), np.concatenate([np.arange(n), added]))


def nonmanifold(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Twenty fins on edges, and ten pairs of vertices far from each other that are one: bow-ties."""
    n = len(vertices)
    chosen = random.choice(len(faces), 20, replace=False)
    a, b, c = faces[chosen].T
    normal = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
    length = np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True))
    tips = (vertices[a] + vertices[b]) / 2 + normal / length
    fins = np.column_stack([a, b, n + np.arange(20)])
    one, other = random.choice(n, (2, 10), replace=False)
    joined = np.arange(n)
    joined[other] = one
    points = vertices.copy()
    points[one] = (vertices[one] + 9 * vertices[one]) / 10
    every = np.concatenate([joined[faces], fins])
    kept = (every != np.roll(every, 1, axis=1)).all(axis=1)
    origin = np.concatenate([np.arange(n), np.full(20, -1)])
    origin[other] = -1
    return Messy(np.concatenate([points, tips]), every[kept], origin)


def wound(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Every third face turned over."""
    turned = random.random(len(faces)) < 1 / 3
    return Messy(vertices, np.where(turned[:, None], faces[:, ::-1], faces), np.arange(len(vertices)))


def inside_out(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """All faces turned over."""
    return Messy(vertices, faces[:, ::-1], np.arange(len(vertices)))


def strays(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Vertices without faces, five that are NaN, with their faces, and a face of a vertex that is not there."""
    n = len(vertices)
    loose = random.normal(size=(30, 3)) * np.ptp(vertices, axis=0)
    points = np.concatenate([vertices, loose])
    lost = random.choice(n, 5, replace=False)
    points[lost] = np.nan
    origin = np.concatenate([np.arange(n), np.full(30, -1)])
    return Messy(points, np.concatenate([faces, [[0, 1, n + 1000]]]), origin)


def crumbs(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Two hundred small pieces around it: of five hundredths of its area."""
    n, k = len(vertices), 200
    edges = vertices[faces] - vertices[np.roll(faces, 1, axis=1)]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    side = np.sqrt(0.05 * area / k * 4 / (4 * np.sqrt(3)))
    tetrahedron = side / np.sqrt(8) * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    places = random.uniform(low - (high - low) / 4, high + (high - low) / 4, (k, 3))
    turned = Rotation.random(k, random_state=0).as_matrix() @ tetrahedron.T
    points = places[:, None] + turned.transpose(0, 2, 1)
    corners = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    small = (n + 4 * np.arange(k)[:, None, None] + corners).reshape(-1, 3)
    return Messy(
        np.concatenate([vertices, points.reshape(-1, 3)]),
        np.concatenate([faces, small]),
        np.concatenate([np.arange(n), np.full(4 * k, -1)]),
    )


def everything(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """One after the other: crumbs, strays, turned faces, duplicates, no welding, and another order."""
    messy = tidy(vertices, faces, random)
    for step in (crumbs, wound, strays):
        after = step(messy.vertices, messy.faces, random)
        known = np.where(after.origin >= 0, messy.origin[np.maximum(after.origin, 0)], -1)
        messy = Messy(after.vertices, after.faces, known)
    soup = np.concatenate([messy.faces[:-1], messy.faces[:100]])
    order = random.permutation(len(soup))
    after = unwelded(messy.vertices, soup[order], random)
    return Messy(after.vertices, after.faces, messy.origin[after.origin])


def cut_off(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """A tenth of the faces missing at the end that is farthest from the middle: a leg that the scanner did not see."""
    centre = vertices[faces].mean(axis=1)
    end = centre[np.linalg.norm(centre - vertices.mean(axis=0), axis=1).argmax()]
    left = np.argsort(np.linalg.norm(centre - end, axis=1))[len(faces) // 10 :]
    used, corner = np.unique(faces[np.sort(left)], return_inverse=True)
    return Messy(vertices[used], corner.reshape(-1, 3), used)


def pieces(vertices: np.ndarray, faces: np.ndarray, random: Random) -> Messy:
    """Thirty pieces with borders of their own, each a little off, half of them turned over: no repair mends it."""
    centre = vertices[faces].mean(axis=1)
    seeds = centre[random.choice(len(faces), 30, replace=False)]
    piece = np.linalg.norm(centre[:, None] - seeds, axis=2).argmin(axis=1)
    pairs, corner = np.unique(np.column_stack([np.repeat(piece, 3), faces.ravel()]), axis=0, return_inverse=True)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    points = vertices[pairs[:, 1]] + 2e-3 * size * random.normal(size=(30, 3))[pairs[:, 0]]
    turned = np.where((piece % 2 == 0)[:, None], corner.reshape(-1, 3)[:, ::-1], corner.reshape(-1, 3))
    return Messy(points, turned, pairs[:, 1])


#: By the name that stands in the table.
MESSES: dict[str, Mess] = {
    "tidy": tidy,
    "triangles with corners of their own (STL)": unwelded,
    "the same in single precision, far from the origin": rounded,
    "cut along seams": seams,
    "faces twice, and the whole mesh twice": duplicates,
    "flat faces, edges of length zero": degenerate,
    "fins on edges, bow-ties": nonmanifold,
    "every third face turned over": wound,
    "inside out": inside_out,
    "loose vertices, NaN, missing vertices": strays,
    "200 crumbs, 5 % of the area": crumbs,
    "crumbs, NaN, turned and doubled faces, not welded": everything,
    "an end with a tenth of the faces cut off": cut_off,
    "30 pieces a little apart, half of them turned over": pieces,
}
