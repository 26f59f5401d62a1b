"""Triangle lists cut into manifolds: which faces stay together at an edge, and vertices split into fans."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from qgeo_filters import connectivity
from qgeo_filters._typing import IndexArray, IntArray
from qgeo_filters.io.raw_mesh import counted
from qgeo_filters.triangle_geometry import face_crosses, unit_normals


def split_into_fans(
    vertices: np.ndarray, faces: IntArray, report: list[str]
) -> tuple[IndexArray, IntArray, IndexArray]:
    """The old index of each vertex of manifold faces, these faces, and the old index of each of them.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int32
        Valid and without repeated faces.
    report : list of str
        Sentences on what was changed are appended.

    Notes
    -----
    A cut may be undone by indices: where both sides of it keep both of their vertices, the edge still has all of its
    faces. So cuts are repeated; once splitting gains no vertex, all faces are cut at the edges that
    remain, and if that gains nothing either, the surplus faces go. Each round adds a vertex or removes a
    face, so that this ends.
    """
    origin, kept = np.arange(len(vertices)), np.arange(len(faces))
    n_edges, n_removed, keep_pairs = 0, 0, True
    while True:
        edges, face_edges, counts = connectivity.unique_edges(faces)
        twins = connectivity.halfedge_twins(faces, face_edges, len(edges))
        bad = np.flatnonzero(counts > 2)
        n_edges = n_edges or len(bad)
        if keep_pairs:
            _join_flattest(vertices[origin], faces, face_edges, bad, twins)
        split, new_origin = _fans(faces, twins, len(origin))
        if len(new_origin) > len(origin):
            faces, origin = split, origin[new_origin]
            continue
        if not len(bad):
            break
        if keep_pairs:
            keep_pairs = False
            continue
        surplus = _surplus_faces(vertices[origin], faces, face_edges, bad)
        n_removed += len(surplus)
        faces, kept = np.delete(faces, surplus, axis=0), np.delete(kept, surplus)
        keep_pairs = True
    if n_edges:
        removed = f", {counted(n_removed, 'face')} removed there" if n_removed else ""
        report.append(f"{counted(n_edges, 'edge')} of three or more faces cut open{removed}")
    n_split = len(origin) - len(vertices)
    if n_split:
        report.append(f"{counted(n_split, 'vertex', 'vertices')} added where faces met in more than one fan")
    return origin, faces, kept


def consistent_flips(faces: IntArray) -> tuple[IndexArray, bool]:
    """Faces to turn over so that neighbours agree, the fewest of each piece, and whether all pieces can be oriented.

    One that cannot (Moebius band) is left as it is.
    """
    edges, face_edges, _ = connectivity.unique_edges(faces)
    twins = connectivity.halfedge_twins(faces, face_edges, len(edges))
    m = len(faces)
    half = np.flatnonzero(twins.ravel() >= 0)
    other = twins.ravel()[half]
    same_way = faces.ravel()[half] == faces.ravel()[other]
    f, g = half // 3, other // 3
    # Every face appears twice, as it is (f) and turned over (f + m); agreeing states are connected.
    rows = np.concatenate([f, f + m])
    columns = np.concatenate([np.where(same_way, g + m, g), np.where(same_way, g, g + m)])
    graph = sparse.coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * m, 2 * m))
    _, label = connected_components(graph, directed=False)
    as_is, turned = label[:m], label[m:]
    orientable = as_is != turned
    # The state to take is that which most faces of the piece have already; ties go to the first face.
    votes = np.bincount(as_is, minlength=label.max() + 1)
    flips = np.flatnonzero(
        orientable & ((votes[turned] > votes[as_is]) | ((votes[turned] == votes[as_is]) & (turned < as_is)))
    )
    return flips, bool(orientable.all())


def _pairs_by_flatness(halves: IndexArray, faces: IntArray, normals: np.ndarray) -> list[tuple[bool, float, int, int]]:
    """All pairs of half-edges of one edge, best first: of one orientation, then flat."""
    tails = faces.ravel()[halves]
    pairs = []
    for i in range(len(halves)):
        for j in range(i + 1, len(halves)):
            disagree = bool(tails[i] == tails[j])
            cosine = float(normals[halves[i] // 3] @ normals[halves[j] // 3])
            pairs.append((disagree, cosine if disagree else -cosine, int(halves[i]), int(halves[j])))
    return sorted(pairs)


def _join_flattest(
    positions: np.ndarray, faces: IntArray, face_edges: np.ndarray, bad: IndexArray, twins: IntArray
) -> None:
    """Fill in twins, in place, at edges of three and more faces; the faces left over stay on a boundary.

    Pairs that disagree on the orientation are joined only where an edge has no other pair.
    """
    if not len(bad):
        return
    normals = unit_normals(face_crosses(positions, faces))
    flat = twins.reshape(-1)
    for halves in _halfedges_of(face_edges, bad):
        pairs = _pairs_by_flatness(halves, faces, normals)
        allowed = [pair for pair in pairs if not pair[0]] or pairs[:1]
        taken: set[int] = set()
        for _, _, half, other in allowed:
            if half not in taken and other not in taken:
                flat[half], flat[other] = other, half
                taken |= {half, other}


def _surplus_faces(positions: np.ndarray, faces: IntArray, face_edges: np.ndarray, bad: IndexArray) -> IndexArray:
    """Faces at these edges that are not in the best pair of theirs."""
    normals = unit_normals(face_crosses(positions, faces))
    surplus: set[int] = set()
    for halves in _halfedges_of(face_edges, bad):
        present = np.array([half for half in halves.tolist() if half // 3 not in surplus])
        if len(present) > 2:
            _, _, half, other = _pairs_by_flatness(present, faces, normals)[0]
            surplus.update(int(h) // 3 for h in present if h not in (half, other))
    return np.array(sorted(surplus), dtype=np.int64)


def _halfedges_of(face_edges: np.ndarray, edges: IndexArray) -> list[IndexArray]:
    flat = face_edges.ravel()
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], edges)
    ends = np.searchsorted(flat[order], edges, side="right")
    return [order[start:end] for start, end in zip(starts, ends, strict=True)]


def _fans(faces: IntArray, twins: IntArray, n_vertices: int) -> tuple[IntArray, IndexArray]:
    """Faces with one vertex for each fan, and the vertex that each was; the largest fan keeps its index."""
    fan = connectivity.corner_fans(faces, twins)
    corner_vertex = faces.ravel()
    n_fans = int(fan.max()) + 1
    vertex_of_fan = np.empty(n_fans, dtype=np.int64)
    vertex_of_fan[fan] = corner_vertex
    size = np.bincount(fan, minlength=n_fans)
    order = np.lexsort((np.arange(n_fans), -size, vertex_of_fan))
    first = np.ones(n_fans, dtype=bool)
    first[1:] = vertex_of_fan[order][1:] != vertex_of_fan[order][:-1]
    index_of_fan = np.empty(n_fans, dtype=np.int32)
    index_of_fan[order[first]] = vertex_of_fan[order[first]]
    added = order[~first]
    index_of_fan[added] = n_vertices + np.arange(len(added))
    origin = np.concatenate([np.arange(n_vertices), vertex_of_fan[added]])
    return index_of_fan[fan].reshape(-1, 3), origin
