"""Every kind of mess becomes the clean mesh again: the same triangles at the same places, looking outwards.

So that what is computed of it, a map for instance, is what the clean mesh gives.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from shapes import blob, moebius

import qgeo_filters as qg
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.hosts.repair import needs_repair
from qgeo_filters.surface import Surface

Arrays = tuple[np.ndarray, np.ndarray]
Random = np.random.Generator

V, F = blob(3)
N, M = len(V), len(F)


def soup(random: Random) -> Arrays:
    return V[F.ravel()], np.arange(3 * M).reshape(-1, 3)


def rounded_soup(random: Random) -> Arrays:
    """Each corner rounded by itself, by a step of single precision, far from the origin."""
    points = V[F.ravel()] + 30
    points = points + random.integers(-1, 2, points.shape) * np.spacing(np.float32(32))
    return points.astype(np.float32).astype(np.float64), np.arange(3 * M).reshape(-1, 3)


def seams(random: Random) -> Arrays:
    chart = (V[F].mean(axis=1) > 0) @ [1, 2, 4]
    pairs, corner = np.unique(np.column_stack([np.repeat(chart, 3), F.ravel()]), axis=0, return_inverse=True)
    return V[pairs[:, 1]], corner.reshape(-1, 3)


def duplicate_faces(random: Random) -> Arrays:
    again = F[random.choice(M, 200, replace=False)]
    again[::2] = again[::2, ::-1]
    return V, np.concatenate([F, again])


def copied(random: Random) -> Arrays:
    return np.concatenate([V, V]), np.concatenate([F, F[::-1] + N])


def repeated_vertices(random: Random) -> Arrays:
    """Faces that name a vertex twice, and a vertex doubled along an edge of length zero."""
    fan = np.flatnonzero((F == 7).any(axis=1))
    middle = F[fan[0]][F[fan[0]] != 7][0]
    own = fan[(F[fan] == middle).any(axis=1)]  # the two faces at one edge
    others, times = np.unique(F[own], return_counts=True)
    faces = np.array(F)
    faces[own] = np.where(faces[own] == 7, N, faces[own])
    flat = [[7, N, p] for p in others[times == 1]]
    return np.concatenate([V, V[7:8]]), np.concatenate([faces, flat, [[7, 7, 3]]])


def fins(random: Random) -> Arrays:
    """Triangles that stand on edges."""
    chosen = F[random.choice(M, 15, replace=False)]
    a, b, c = (V[chosen[:, k]] for k in range(3))
    tips = (a + b) / 2 + 0.05 * np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a), axis=1, keepdims=True)
    return np.concatenate([V, tips]), np.concatenate([F, np.column_stack([chosen[:, :2], N + np.arange(15)])])


def turned(random: Random) -> Arrays:
    return V, np.where((random.random(M) < 0.4)[:, None], F[:, ::-1], F)


def loose(random: Random) -> Arrays:
    return np.concatenate([V, [[9.0, 9, 9], [np.nan, 0, 0], [np.inf, 1, 1]]]), F


def missing_vertices(random: Random) -> Arrays:
    return V, np.concatenate([F, [[0, 1, N + 5], [-1, 2, 3]]])


def crumbs(random: Random) -> Arrays:
    """Sixty triangles of two hundredths of the area together."""
    side = np.sqrt(0.02 * Surface(V, F).area / 60 * 4 / np.sqrt(3))
    triangle = side * np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]])
    points = random.uniform(2, 4, (60, 1, 3)) + triangle
    return np.concatenate([V, points.reshape(-1, 3)]), np.concatenate([F, N + np.arange(180).reshape(-1, 3)])


# What is said of each; None: nothing, as matching deals with it.
MESSES: dict[Callable[[Random], Arrays], str] = {
    soup: "boundary vertices joined with others at the same place",
    rounded_soup: "boundary vertices joined with others at the same place, up to",
    seams: "boundary vertices joined with others",
    duplicate_faces: "200 duplicate faces removed",
    copied: f"1 piece removed that lay on others face by face, with {M} faces",
    repeated_vertices: "1 vertex joined with a neighbour at the same position",
    fins: "15 edges of three or more faces cut open",
    turned: "faces turned over",
    loose: "of 645 vertices 3 are gone (642, 643, 644)",
    missing_vertices: "2 faces with missing vertices removed",
    crumbs: "60 smaller pieces with 60 faces removed; the largest, kept, has 98.04 % of the area",
}


@pytest.mark.parametrize("mess", MESSES, ids=lambda mess: mess.__name__)
def test_the_clean_mesh_comes_back(mess: Callable[[Random], Arrays]) -> None:
    vertices, faces = mess(np.random.default_rng(3))
    given, repair = surface_and_repair((vertices, faces), "auto")
    assert repair is not None
    assert any(MESSES[mess] in sentence for sentence in repair.report), repair.report
    assert given.n_vertices == len(vertices)
    mended = repair.surface
    assert not needs_repair(mended)
    assert mended.winding == "outward"
    places = mended.vertices - (30 if mess is rounded_soup else 0)
    gap = np.linalg.norm(places[:, None] - V, axis=2)
    of_clean = gap.argmin(axis=1)
    assert gap.min(axis=1).max() <= (2e-5 if mess is rounded_soup else 0)
    np.testing.assert_array_equal(np.sort(of_clean), np.arange(N))
    assert oriented(of_clean[mended.faces]) == oriented(F)
    # The way back: each given vertex that is left is at the place of the one that stands for it.
    left = repair.vertex_of_original >= 0
    there = mended.vertices[repair.vertex_of_original[left]]
    np.testing.assert_allclose(vertices[left], there, atol=2e-5 if mess is rounded_soup else 0)


def oriented(faces: np.ndarray) -> set[tuple[int, ...]]:
    """Faces as cycles that begin with the smallest vertex."""
    shift = faces.argmin(axis=1)[:, None]
    return set(map(tuple, np.take_along_axis(faces, (np.arange(3) + shift) % 3, axis=1).tolist()))


def test_a_bow_tie_is_split_and_its_vertex_stands_for_the_larger_side() -> None:
    """Two vertices far from each other that are one: the surface comes apart there again, closed as before."""
    far = int(np.linalg.norm(V - V[0], axis=1).argmax())
    faces = np.where(far == F, 0, F)
    given, repair = surface_and_repair((V, faces), "auto")
    assert repair is not None
    assert repair.surface.n_vertices == N  # the vertex is there twice, and the one that no face names is gone
    assert repair.vertex_of_original[far] == -1
    assert (repair.origin == 0).sum() == 2
    assert repair.surface.is_closed
    assert repair.surface.genus == 0
    assert given.n_vertices == N


def test_what_is_tidy_or_only_inside_out_is_left_alone() -> None:
    surface = Surface(V, F)
    for one in (surface, surface.turned_over(), Surface(V, F[: M // 2]).largest_component()[0]):
        given, repair = surface_and_repair(one, "auto")
        assert given is one
        assert repair is None


def test_two_large_pieces_are_refused_and_the_larger_is_taken_by_force() -> None:
    two = np.concatenate([V, 0.5 * V + 5]), np.concatenate([F, F + N])
    with pytest.raises(
        qg.DisconnectedError, match=r"would remove 20 % of the area .*one piece is needed, and there are 2"
    ):
        surface_and_repair(two, "auto")
    _, repair = surface_and_repair(two, "force")
    assert repair is not None
    np.testing.assert_array_equal(repair.vertex_of_original, np.concatenate([np.arange(N), np.full(N, -1)]))
    assert surface_and_repair(two, "auto", "all")[1] is None


def test_a_one_sided_surface_is_refused_in_words() -> None:
    vertices, faces = moebius()
    doubled = vertices, np.concatenate([faces, faces[:3]])
    with pytest.raises(
        qg.MeshError,
        match=r"it is one-sided .*Euler characteristic 0\), .* repair='wrap' takes a closed surface around it",
    ):
        qg.PreparedShape(doubled)
