"""Good, odd and broken meshes, each with what is expected of it.

Expected at construction, by geodesics, and of ``repair=True``: None where it goes through, else what
the message says. The files of ``malformed/`` come with the MIT-licensed geometry-central tests and are
used where present.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapes import bow_tie, fan, grid, icosphere, moebius

Arrays = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Animal:
    """One mesh of the zoo.

    Attributes
    ----------
    make : callable
        Arrays, or the path of a file.
    construction, geodesics, repair : str or None
        Pattern of the error's message; None if it goes through. What fails at construction has no geodesics.
    loss : str or None
        Pattern of what repair says where it removes so much that it must be forced.
    repaired : (vertices, faces) or None
        Sizes after repair; None where nothing is to be changed.
    report : str
        Pattern that some sentence of the repair's report matches.
    """

    name: str
    make: Callable[[], Arrays | Path]
    construction: str | None = None
    geodesics: str | None = None
    repair: str | None = None
    loss: str | None = None
    repaired: tuple[int, int] | None = None
    report: str = ""


V, F = icosphere(1)  # 42 vertices, 80 faces, closed
N, M = len(V), len(F)


def with_vertex(index: int, value: object) -> Arrays:
    """The sphere with one vertex elsewhere."""
    vertices = V.copy()
    vertices[index] = value
    return vertices, F


def with_faces(*faces: list[int]) -> Arrays:
    """The sphere with more faces."""
    return V, np.vstack([F, *np.atleast_2d(np.array(faces))])


def read_only() -> Arrays:
    """The sphere in arrays that cannot be written to."""
    vertices, faces = V.copy(), F.copy()
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces


def needles(width: float) -> Arrays:
    """A strip of triangles as long as 1 and as wide as this."""
    vertices, faces = grid(4)
    return vertices * [1, width, 1], faces


def pinched(gap: float) -> Arrays:
    """A grid with two neighbours this close to each other."""
    vertices, faces = grid(4)
    vertices = vertices.copy()
    vertices[7] = vertices[12] + [gap, 0, 0]
    return vertices, faces


def turned() -> Arrays:
    """The sphere with every fourth face turned over."""
    faces = F.copy()
    faces[::4] = faces[::4, ::-1]
    return V, faces


def strip_of_quads() -> Arrays:
    """Ten quadrilaterals in a row."""
    x = np.arange(11.0)
    vertices = np.column_stack([np.tile(x, 2), np.repeat([0.0, 1.0], 11), np.zeros(22)])
    a = np.arange(10)
    return vertices, np.column_stack([a, a + 1, a + 12, a + 11])


def cubes_on_an_edge() -> Arrays:
    """Two cubes that share one edge: four faces there, of which two and two belong together."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices, index = np.unique(np.vstack([corners, np.add(corners, [1, 1, 0])]), axis=0, return_inverse=True)
    return vertices, index.ravel()[np.vstack([faces, faces + 8])]


GENERATED = [
    Animal("sphere", lambda: (V, F)),
    Animal("one triangle", lambda: (np.eye(3), np.array([[0, 1, 2]]))),
    Animal("no vertices", lambda: (np.empty((0, 3)), np.empty((0, 3), int)), "no vertices", repair="no vertices"),
    Animal("no faces", lambda: (V, np.empty((0, 3), int)), "no faces", repair="nothing is left .* it has no faces"),
    Animal(
        "NaN", lambda: with_vertex(5, np.nan), r"vertices\[5\] is .*\(1 such vertex\)",
        repaired=(N - 1, M - 5), report=r"1 vertex with coordinates that are not finite \(5\) removed, with 5 faces",
    ),
    Animal(
        "infinite", lambda: with_vertex(40, [0, np.inf, 0]), r"vertices\[40\] is",
        repaired=(N - 1, M - 6), report=r"not finite \(40\) removed, with 6 faces",
    ),
    Animal(
        "all NaN", lambda: (np.full((3, 3), np.nan), np.array([[0, 1, 2]])), r"\(3 such vertices\)",
        repair="nothing is left of the mesh after repair: 3 vertices",
    ),
    Animal(
        "index out of range", lambda: with_faces([0, 1, N]), rf"faces\[{M}\] refers to vertex {N}",
        repaired=(N, M), report="1 face with missing vertices removed",
    ),
    Animal(
        "negative index", lambda: with_faces([0, 1, -1], [-5, 1, 2]), r"refers to vertex -1.*\(2 such faces\)",
        repaired=(N, M), report="2 faces with missing vertices removed",
    ),
    Animal(
        "index beyond int32", lambda: with_faces([0, 1, 2**33]), "refers to vertex 8589934592",
        repaired=(N, M), report="1 face with missing vertices removed",
    ),
    Animal(
        "vertex named twice", lambda: with_faces([3, 3, 7]), r"names a vertex twice \(1 such face\)",
        repaired=(N, M), report="1 face with a repeated vertex removed",
    ),
    Animal(
        "duplicate faces", lambda: (V, np.vstack([F, F[:2], F[5:6, ::-1]])), geodesics="has 3 faces",
        repaired=(N, M), report="3 duplicate faces removed",
    ),
    Animal(
        "three faces on an edge", fan, geodesics=r"edge \(0, 1\) has 3 faces \(1 such edge\)",
        loss=r"would remove 3\d\.?\d* % of the area .*there are 2 pieces, of 2, 1 faces",
        repaired=(4, 2), report="1 edge of three or more faces cut open",
    ),
    Animal(
        "fin on a sphere", lambda: (np.vstack([V, [[3, 3, 3]]]), np.vstack([F, [[*F[0, :2], N]]])),
        geodesics="has 3 faces", loss=r"would remove 1\d\.?\d* % of the area .*2 pieces, of 80, 1 faces",
        repaired=(N, M), report="1 smaller piece with 1 face removed",
    ),
    Animal(
        "bow-tie", bow_tie, geodesics="vertex 0 form more than one fan", loss="would remove 50 % of the area",
        repaired=(3, 1), report="1 vertex added where faces met in more than one fan",
    ),
    Animal(
        "two cubes on an edge", cubes_on_an_edge, geodesics="has 4 faces", loss="2 pieces, of 12, 12 faces",
        repaired=(8, 12), report="1 edge of three or more faces cut open",
    ),
    Animal("Moebius band", moebius, report="not orientable"),
    Animal("turned faces", turned, repaired=(N, M), report="faces turned over"),
    Animal("needles of 1e-12", lambda: needles(1e-12)),
    Animal("gap of 1e-12", lambda: pinched(1e-12)),
    Animal("edge of length zero", lambda: pinched(0.0), repaired=(24, 30), report="1 vertex joined with a neighbour"),
    Animal("triangle without area", lambda: (np.array([[0, 0, 0], [1, 0, 0], [2.5, 0, 0]]), np.array([[0, 1, 2]]))),
    Animal(
        "unreferenced vertices", lambda: (np.vstack([[[7, 7, 7]], V, [[9, 9, 9]]]), F + 1),
        repaired=(N, M), report=rf"of {N + 2} vertices 2 are gone \(0, {N + 1}\)",
    ),
    Animal(
        "several pieces", lambda: (np.vstack([V / 2, V + 5]), np.vstack([F, F + N])),
        loss=r"would remove 20 % of the area .*there are 2 pieces, of 80, 80 faces; .*repair='force'",
        repaired=(N, M), report="1 smaller piece with 80 faces removed; the largest, kept, has 80 % of the area",
    ),
    Animal("scale 1e-9", lambda: (1e-9 * V, F)),
    Animal("scale 1e9", lambda: (1e9 * V, F)),
    Animal("scale 1e200", lambda: (1e200 * V, F), "units wide", repair="units wide"),
    Animal("far from the origin", lambda: (V + 1e6, F)),
    Animal("int64 faces", lambda: (V, F.astype(np.int64))),
    Animal("unsigned faces", lambda: (V, F.astype(np.uint64))),
    Animal("float faces", lambda: (V, F.astype(float))),
    Animal("half faces", lambda: (V, F + 0.5), "whole numbers", repair="whole numbers"),
    Animal("float32 vertices", lambda: (V.astype(np.float32), F)),
    Animal("read-only", read_only),
    Animal("Fortran order", lambda: (np.asfortranarray(V), np.asfortranarray(F))),
    Animal("lists", lambda: (V.tolist(), F.tolist())),  # type: ignore[return-value, arg-type]
    Animal("quads", strip_of_quads, "quadrilaterals", repaired=(22, 20), report="10 polygons split into 20 triangles"),
    Animal("pairs for faces", lambda: (V, F[:, :2]), r"shape \(m, 3\)", repair=r"shape \(m, 3\)"),
    Animal("flat vertices", lambda: (V[:, :2], F), r"shape \(n, 3\)", repair=r"shape \(n, 3\)"),
]  # fmt: skip


def files(data: Path) -> list[Animal]:
    """The malformed files."""
    folder = data / "malformed"

    def animal(name: str, *args: object, **kwargs: object) -> Animal:
        return Animal(name, lambda: folder / name, *args, **kwargs)  # type: ignore[arg-type]

    polygons = r"face 0 has \d corners .* triangulate the mesh first, or pass repair=True"
    return [
        animal("cat_head.obj"),
        animal("tet.obj"),
        animal("dodecahedron_poly.obj", polygons, repaired=(20, 36), report="12 polygons split into 36 triangles"),
        animal("moebius.obj", polygons, repaired=(280, 448), report="224 polygons split into 448 triangles"),
        animal(
            "platonic_shelf.obj",
            polygons,
            loss="there are 5 pieces, of 36, ",
            repaired=(20, 36),
            report="4 smaller pieces",
        ),
        animal(
            "fan3.obj",
            geodesics="has 3 faces",
            loss="2 pieces, of 2, 1 faces",
            repaired=(4, 2),
            report="1 edge of three or more",
        ),
        animal(
            "hourglass_ico.obj",
            geodesics="more than one fan",
            loss="2 pieces, of 20, ",
            repaired=(12, 20),
            report="1 vertex added",
        ),
        animal(
            "triple_vierbein.obj",
            geodesics="has 3 faces",
            loss="3 pieces, of 54, 36, 18 faces",
            repaired=(43, 54),
            report="20 edges of three or more",
        ),
    ]
