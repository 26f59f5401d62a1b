"""Changes of a mesh after which it is still known which vertex is which: noise, cuts, other triangulations, handles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

import qgeo_filters as qg

Random = np.random.Generator

#: Vertices that decimation leaves.
FEW = 500
#: Shares of the area that a hole and a lost limb take.
HOLE, LIMB = 0.03, 0.10
#: Places this far apart along the surface, in sqrt(area), make a short circuit when welded.
APART = 0.5


@dataclass(frozen=True, eq=False)
class Changed:
    """A mesh made from another.

    Attributes
    ----------
    surface : Surface
    origin : (n,) int
        For each of its vertices the vertex of the original at that place, or nearest to it.
    there : (n_original,) bool
        Vertices of the original whose place is still part of the surface.
    note : str
    """

    surface: qg.Surface
    origin: np.ndarray
    there: np.ndarray
    note: str = ""


Change = Callable[[qg.Surface, Random], Changed]


def unchanged(y: qg.Surface, random: Random) -> Changed:
    """The mesh itself."""
    return _whole(y, y, np.arange(y.n_vertices))


def noise(share: float) -> Change:
    """Each vertex moved along a random direction, by a normal deviate of this share of the bounding box' diagonal."""

    def moved(y: qg.Surface, random: Random) -> Changed:
        direction = random.normal(size=y.vertices.shape)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        deviation = share * np.linalg.norm(np.ptp(y.vertices, axis=0))
        vertices = y.vertices + deviation * random.normal(size=(y.n_vertices, 1)) * direction
        noisy = y.with_vertices(vertices)
        edges = deviation / y.edge_lengths.mean()
        note = f"deviation {edges:.2f} mean edges, area {noisy.area / y.area:.2f} times as large"
        return _whole(y, noisy, np.arange(y.n_vertices), note)

    return moved


def decimated(y: qg.Surface, random: Random) -> Changed:
    """Quadric edge collapse to about `FEW` vertices; a vertex's origin is the one that it was born from."""
    vertices, faces, _, birth = igl.qslim(
        np.asfortranarray(y.vertices), np.asfortranarray(y.faces), 2 * FEW - 4 + len(y.boundary_loops)
    )
    small = qg.Surface(vertices, faces)
    return _whole(y, small, np.asarray(birth), f"{small.n_vertices} of {y.n_vertices} vertices")


def subdivided(y: qg.Surface, random: Random) -> Changed:
    """Each triangle cut into four, old vertices first; a midpoint's origin is the first end of its edge."""
    vertices, faces = igl.upsample(y.vertices, y.faces.astype(np.int64))
    origin = np.arange(len(vertices))
    new = origin[y.n_vertices :]
    _, near = cKDTree(y.vertices).query(vertices[new], k=1)
    origin[new] = near
    return _whole(y, qg.Surface(vertices, faces), origin, f"{len(vertices)} of {y.n_vertices} vertices")


def scaled(y: qg.Surface, random: Random) -> Changed:
    """A hundred times as large."""
    return _whole(y, y.with_vertices(100 * y.vertices), np.arange(y.n_vertices))


def rotated(y: qg.Surface, random: Random) -> Changed:
    """Turned at random about its centre, and moved away."""
    turn = Rotation.random(random_state=random).as_matrix()
    return _whole(y, y.with_vertices(y.vertices @ turn.T + 10 * random.normal(size=3)), np.arange(y.n_vertices))


def shuffled(y: qg.Surface, random: Random) -> Changed:
    """Vertices, faces and the first corner of each face in another order."""
    origin = random.permutation(y.n_vertices)
    place = np.argsort(origin)
    faces = place[random.permutation(y.faces)]
    first = random.integers(3, size=len(faces))
    faces = faces[np.arange(len(faces))[:, None], (first[:, None] + np.arange(3)) % 3]
    return _whole(y, qg.Surface(y.vertices[origin], faces), origin)


def pierced(y: qg.Surface, random: Random) -> Changed:
    """A geodesic disc of `HOLE` of the area cut out round a random vertex, apart from holes that are there."""
    centres = np.arange(y.n_vertices)
    if len(y.boundary_vertices):
        away = qg.distances(y, y.boundary_vertices).min(axis=0)
        # A geodesic disc is at most as large as a flat one where the surface is curved positively, as limbs are.
        centres = np.flatnonzero(away > 1.5 * np.sqrt(HOLE * y.area / np.pi))
    return _without_disc(y, int(random.choice(centres)), HOLE)


def amputated(y: qg.Surface, random: Random) -> Changed:
    """`LIMB` of the area cut off round the vertex of largest mean distance: a tail, a hand or a foot."""
    mean = qg.distance_matrix(y) @ y.vertex_areas
    return _without_disc(y, int(mean.argmax()), LIMB)


def short_circuited(y: qg.Surface, random: Random) -> Changed:
    """A handle between the two nearest places that are `APART` on the surface: a triangle removed at each, a tube."""
    size = np.sqrt(y.area)
    along = qg.distance_matrix(y)
    gaps = np.where(along >= APART * size, cdist(y.vertices, y.vertices), np.inf)
    near = np.unravel_index(gaps.argmin(), gaps.shape)
    fans = [np.flatnonzero((y.faces == vertex).any(axis=1)) for vertex in near]
    centres = [y.vertices[y.faces[fan]].mean(axis=1) for fan in fans]
    nearest = np.unravel_index(cdist(*centres).argmin(), (len(fans[0]), len(fans[1])))
    removed = [fan[i] for fan, i in zip(fans, nearest, strict=True)]
    one, other = y.faces[removed].astype(np.int64)
    # Round the tube the second triangle runs backwards, so that orientations agree; the least twisted of three ways.
    ways = [other[(turn - np.arange(3)) % 3] for turn in range(3)]
    back = min(ways, key=lambda way: float(np.linalg.norm(y.vertices[one] - y.vertices[way], axis=1).sum()))
    tube = []
    for i in range(3):
        a, b, c, d = one[i], one[(i + 1) % 3], back[(i + 1) % 3], back[i]
        tube += [[a, b, c], [a, c, d]]
    welded = qg.Surface(y.vertices, np.concatenate([np.delete(y.faces, removed, axis=0), tube]))
    note = (
        f"places {along[near] / size:.2f} sqrt(area) apart joined over a gap of {gaps[near] / size:.3f}, "
        f"genus {welded.genus}"
    )
    return _whole(y, welded, np.arange(y.n_vertices), note)


#: Every change by the name that the table gives it.
CHANGES: dict[str, Change] = {
    "unchanged": unchanged,
    "scale x 100": scaled,
    "rotated and moved": rotated,
    "shuffled": shuffled,
    "subdivided": subdivided,
    "decimated to 500": decimated,
    "noise .3 %": noise(0.003),
    "noise 1 %": noise(0.01),
    "noise 3 %": noise(0.03),
    "hole of 3 %": pierced,
    "limb of 10 % lost": amputated,
    "short circuit": short_circuited,
}

#: Those that should not change the map at all.
INVARIANT = ("scale x 100", "rotated and moved", "shuffled")


def _whole(y: qg.Surface, surface: qg.Surface, origin: np.ndarray, note: str = "") -> Changed:
    return Changed(surface, origin, np.ones(y.n_vertices, dtype=bool), note)


def _without_disc(y: qg.Surface, centre: int, share: float) -> Changed:
    distance = qg.distances(y, [centre])[0]
    order = np.argsort(distance, kind="stable")
    lost = order[np.cumsum(y.vertex_areas[order]) <= share * y.area]
    there = np.ones(y.n_vertices, dtype=bool)
    there[lost] = False
    # What the cut leaves hanging by a vertex goes with it.
    while True:
        rest, origin = y.submesh(there)
        rest, kept = rest.largest_component()
        origin = origin[kept]
        bad = origin[rest.nonmanifold_vertices]
        there = np.zeros(y.n_vertices, dtype=bool)
        there[origin] = True
        if not bad.size:
            break
        there[bad] = False
    note = f"area {rest.area / y.area:.3f}, {len(rest.boundary_loops)} boundary loops, before {len(y.boundary_loops)}"
    return Changed(rest, origin, there, note)
