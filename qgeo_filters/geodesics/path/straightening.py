"""From any path to one that is locally shortest, after Martinez, Velho and Carvalho (Numba).

"Computing geodesics on triangular meshes", Computers & Graphics 29(5), 2005: points inside edges are moved
until the path is straight there, and at a vertex the path moves to the side whose angle is below pi. Here all
points inside edges are corrected at once, by the taut path of the sleeve; then the path is led past every
vertex that has an angle below pi on the other side, and pulled tight again. Each round makes it shorter.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.path.funnel import FlatSleeve, new_flat_sleeve, side_angles, tighten
from qgeo_filters.geodesics.path.one_ring import (
    append_crossing,
    face_with,
    other_side,
    side_between,
    trimmed,
    walk_fan,
)
from qgeo_filters.geodesics.unfolding import UnfoldedMesh
from qgeo_filters.jit import NONE, ZERO, inner, kernel

POINT = np.dtype(
    [
        ("left", "i8"),  # ends of the edge crossed, equal at a vertex
        ("right", "i8"),
        ("t", "f8"),  # from 0 at the left to 1 at the right end
        ("vertex", "i8"),  # -1 on an edge
        ("face", "i8"),  # triangle in which the path goes on; the last point has that of the one before
        ("left_angle", "f8"),
        ("right_angle", "f8"),
    ]
)

# A round that shortens the path by less than this, relatively, is the last.
GAIN = 1e-14


@kernel
def _led_past(
    sleeve: IndexArray, flat: FlatSleeve, tolerance: float, mesh: UnfoldedMesh, out: IndexArray
) -> tuple[int, int]:
    """Length of the sleeve that leads past all vertices where that is shorter, and how many there are.

    Fans that share a portal with one already led past wait for the next round.
    """
    m, n_nodes = flat.size[0], flat.size[1]
    count, done, changes = ZERO, 0, 0
    for k in range(1, n_nodes - 1):
        node = flat.nodes[k]
        v, first, last = node["vertex"], node["first"], node["last"]
        if v < 0 or first < done:
            continue
        left, right = side_angles(flat, k, mesh)
        at_left = flat.portals[first]["lx"] == node["x"] and flat.portals[first]["ly"] == node["y"]
        if (left if at_left else right) >= np.pi - tolerance:
            continue
        while done < first:
            count = append_crossing(out, count, sleeve[done], mesh)
            done += 1
        way_in = mesh.sides[sleeve[first]]["twin"]
        before = count
        if way_in // 3 != sleeve[last] // 3:
            count, angle = walk_fan(v, other_side(way_in, v, mesh), sleeve[last] // 3, NONE, out, count, mesh)
            if angle == np.inf:  # the boundary is in the way: the path stays
                count = before
                continue
        done = last + 1
        changes += 1
    while done < m:
        count = append_crossing(out, count, sleeve[done], mesh)
        done += 1
    return count, changes


@kernel
def _edge_length(v: int, w: int, mesh: UnfoldedMesh) -> float:
    face = face_with(v, w, mesh)
    return mesh.sides[side_between(face, v, w, mesh)]["length"]


@inner
def straighten(
    sleeve: IndexArray, start: int, end: int, tolerance: float, max_rounds: int, mesh: UnfoldedMesh
) -> tuple[IndexArray, FlatSleeve, FloatArray]:
    """Locally shortest path from a trimmed sleeve.

    Returns
    -------
    sleeve : (m,) int64
        Half-edges through which the path enters one triangle after the other; empty where the path is an edge.
    flat : FlatSleeve
        The same laid flat, with the nodes of the path.
    lengths : (rounds,) float64
        After each round, decreasing.
    """
    lengths = np.empty(max_rounds + 1)
    flat = new_flat_sleeve(len(sleeve))
    lengths[0] = tighten(sleeve, start, flat, mesh) if len(sleeve) else _edge_length(start, end, mesh)
    rounds = 1
    room = np.empty(len(sleeve) + 2 * len(mesh.corners), dtype=np.int64)
    while rounds <= max_rounds and len(sleeve):
        m, changes = _led_past(sleeve, flat, tolerance, mesh, room)
        if changes == 0:
            break
        led = room[: trimmed(room, m, start, end, mesh)].copy()
        laid = new_flat_sleeve(len(led))
        length = tighten(led, start, laid, mesh) if len(led) else _edge_length(start, end, mesh)
        if length >= lengths[rounds - 1] * (1.0 - GAIN):
            break
        lengths[rounds] = length
        sleeve, flat = led, laid
        rounds += 1
    return sleeve, flat, lengths[:rounds].copy()


@inner
def vertex_nodes(vertices: IndexArray) -> npt.NDArray[np.void]:
    """Nodes of a path along edges, of dtype POINT; without faces and angles."""
    out = np.zeros(len(vertices), dtype=POINT)
    for k in range(len(vertices)):
        out[k]["left"], out[k]["right"], out[k]["vertex"] = vertices[k], vertices[k], vertices[k]
    return out


@inner
def describe(sleeve: IndexArray, flat: FlatSleeve, start: int, end: int, mesh: UnfoldedMesh) -> npt.NDArray[np.void]:
    """Nodes of a path, shape (p,), of dtype POINT."""
    if len(sleeve) == 0:
        out = vertex_nodes(np.array([start, end], dtype=np.int64))
        out[0]["face"] = out[1]["face"] = face_with(start, end, mesh)
        return out
    count = flat.size[1]
    out = np.zeros(count, dtype=POINT)
    face = mesh.sides[sleeve[0]]["twin"] // 3
    for k in range(count):
        node, point = flat.nodes[k], out[k]
        v = node["vertex"]
        point["vertex"], point["t"] = v, node["t"]
        if v >= 0:
            point["left"], point["right"] = v, v
        else:
            portal = flat.portals[node["first"]]
            point["left"], point["right"] = portal["left"], portal["right"]
        if 0 < k < count - 1:
            point["left_angle"], point["right_angle"] = side_angles(flat, k, mesh)
            face = sleeve[node["last"]] // 3
        point["face"] = face
    return out
