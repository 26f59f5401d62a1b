"""Shortest path inside a sleeve of triangles: unfold them one beside the other and pull the string tight (Numba).

A sleeve is the sequence of half-edges through which a path enters one triangle after the other. Laid flat,
its shortest path is found by the funnel of Lee and Preparata ("Euclidean shortest paths in the presence of
rectilinear barriers", Networks 14, 1984): inside every edge it is straight, which is the fixed point of the
correction of edge points of Martinez, Velho and Carvalho (2005), and it bends only about vertices of the
sleeve's border.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.geodesics.unfolding import UnfoldedMesh
from qgeo_filters.jit import inner, kernel

# A path that passes a vertex at this fraction of the crossed edge passes through it: its length is then
# off by the square.
SNAP = 1e-8
# Nodes nearer to each other than this, relative to where they lie, are in one place: edges cross there, as those
# of triangles without area do, and the way from one to the next has no direction.
TOGETHER = 1e-9

PORTAL = np.dtype(
    [("lx", "f8"), ("ly", "f8"), ("rx", "f8"), ("ry", "f8"), ("left", "i8"), ("right", "i8")]
)  # fmt: skip
NODE = np.dtype(
    [
        ("x", "f8"),  # unfolded position
        ("y", "f8"),
        ("t", "f8"),  # on an edge: where, from 0 at its left to 1 at its right end
        ("vertex", "i8"),  # -1 on an edge
        ("first", "i8"),  # portals that the path passes here: one at an edge, a fan of them at a vertex
        ("last", "i8"),
    ]
)


class FlatSleeve(NamedTuple):
    """A sleeve laid flat and the taut path in it; ``size`` holds the numbers of portals and of nodes."""

    portals: npt.NDArray[np.void]  # PORTAL: the ends of the edges crossed, left and right of the path
    nodes: npt.NDArray[np.void]  # NODE: start, crossings and vertices, end
    turns: npt.NDArray[np.int64]  # portals at which the taut path touches the border, +1, right ones negative
    size: npt.NDArray[np.int64]  # (2,)


@inner
def new_flat_sleeve(n_portals: int) -> FlatSleeve:
    """Room for a sleeve of so many portals."""
    return FlatSleeve(
        np.empty(n_portals, dtype=PORTAL),
        np.empty(2 * n_portals + 2, dtype=NODE),  # at most one for each portal and each turn
        np.empty(n_portals + 1, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
    )


@kernel
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@kernel
def _lay_flat(sleeve: IndexArray, flat: FlatSleeve, mesh: UnfoldedMesh) -> None:
    """Unfold the portals; the first and the last node are the apexes of the first and the last triangle."""
    portals, sides = flat.portals, mesh.sides
    m = len(sleeve)
    way_in = sides[sides[sleeve[0]]["twin"]]
    # The path comes down from the apex of the first triangle, so that its left is the positive x-axis.
    start = flat.nodes[0]
    start["x"], start["y"] = way_in["cx"], way_in["cy"]
    lx, ly, rx, ry = way_in["length"], 0.0, 0.0, 0.0
    right = way_in["tail"]
    h = sleeve[0]
    left = sides[h]["tail"]
    if left == right:
        left = sides[3 * (h // 3) + (h + 1) % 3]["tail"]
    for k in range(m):
        h = sleeve[k]
        side, base = sides[h], 3 * (h // 3)
        ahead, back = base + (h - base + 1) % 3, base + (h - base + 2) % 3
        portal = portals[k]
        portal["lx"], portal["ly"], portal["rx"], portal["ry"], portal["left"], portal["right"] = (
            lx,
            ly,
            rx,
            ry,
            left,
            right,
        )
        length = np.sqrt((rx - lx) * (rx - lx) + (ry - ly) * (ry - ly))
        ex, ey = ((rx - lx) / length, (ry - ly) / length) if length > 0.0 else (1.0, 0.0)
        # Measured from the end that is nearer in the triangle's own frame.
        tail_is_left = side["tail"] == left
        from_left = side["cx"] if tail_is_left else side["from_head"]
        x, y = lx + from_left * ex - side["cy"] * ey, ly + from_left * ey + side["cy"] * ex
        apex = sides[back]["tail"]
        if k + 1 == m:
            end = flat.nodes[1]
            end["x"], end["y"], end["vertex"] = x, y, apex
        elif (sides[sleeve[k + 1]]["twin"] == ahead) == tail_is_left:
            lx, ly, left = x, y, apex  # on between the apex and the right end
        else:
            rx, ry, right = x, y, apex
    flat.size[0] = m


@kernel
def _pull_tight(flat: FlatSleeve) -> int:
    """Number of turns of the taut path, written to ``flat.turns``."""
    portals, turns, m = flat.portals, flat.turns, flat.size[0]
    ax, ay = flat.nodes[0]["x"], flat.nodes[0]["y"]
    zx, zy = flat.nodes[1]["x"], flat.nodes[1]["y"]
    # The legs of the funnel, relative to its apex; zero while the portals have an end at the apex.
    lx = ly = rx = ry = 0.0
    left_portal = right_portal = -1
    count = k = 0
    while k <= m:
        # Facing ahead, left is counterclockwise: legs may only come nearer to each other.
        turn = 0
        if k == m:
            x, y = zx - ax, zy - ay
            if (lx != 0.0 or ly != 0.0) and _cross(lx, ly, x, y) >= 0.0:
                turn = 1
            elif (rx != 0.0 or ry != 0.0) and _cross(rx, ry, x, y) <= 0.0:
                turn = -1
        else:
            x, y = portals[k]["rx"] - ax, portals[k]["ry"] - ay
            if rx == 0.0 and ry == 0.0:
                rx, ry, right_portal = x, y, k
            elif _cross(rx, ry, x, y) >= 0.0:
                if (lx != 0.0 or ly != 0.0) and _cross(lx, ly, x, y) >= 0.0:
                    turn = 1
                else:
                    rx, ry, right_portal = x, y, k
            x, y = portals[k]["lx"] - ax, portals[k]["ly"] - ay
            if turn == 0:
                if lx == 0.0 and ly == 0.0:
                    lx, ly, left_portal = x, y, k
                elif _cross(lx, ly, x, y) <= 0.0:
                    if (rx != 0.0 or ry != 0.0) and _cross(rx, ry, x, y) <= 0.0:
                        turn = -1
                    else:
                        lx, ly, left_portal = x, y, k
        if turn == 0:
            k += 1
            continue
        k = left_portal if turn > 0 else right_portal
        ax, ay = (portals[k]["lx"], portals[k]["ly"]) if turn > 0 else (portals[k]["rx"], portals[k]["ry"])
        lx = ly = rx = ry = 0.0
        turns[count] = turn * (k + 1)
        count += 1
        left_portal = right_portal = k
        k += 1
    return count


@kernel
def _touches(portal: np.void, x: float, y: float) -> bool:
    return (portal["lx"] == x and portal["ly"] == y) or (portal["rx"] == x and portal["ry"] == y)


@kernel
def _add_vertex(flat: FlatSleeve, count: int, k: int, left: bool) -> int:
    """Portal after the fan of portals that meet in the left or right end of portal k, noted as a node there."""
    portals, node = flat.portals, flat.nodes[count]
    portal = portals[k]
    node["x"], node["y"] = (portal["lx"], portal["ly"]) if left else (portal["rx"], portal["ry"])
    node["vertex"] = portal["left"] if left else portal["right"]
    first = last = k
    while first > 0 and _touches(portals[first - 1], node["x"], node["y"]):
        first -= 1
    while last + 1 < flat.size[0] and _touches(portals[last + 1], node["x"], node["y"]):
        last += 1
    node["first"], node["last"], node["t"] = first, last, 0.0 if left else 1.0
    return last + 1


@kernel
def _list_nodes(flat: FlatSleeve, n_turns: int) -> int:
    """Number of nodes of the taut path: start, all crossings, all vertices that it passes through, end."""
    portals, nodes, turns, m = flat.portals, flat.nodes, flat.turns, flat.size[0]
    zx, zy, end = nodes[1]["x"], nodes[1]["y"], nodes[1]["vertex"]
    count, k = 1, 0
    for turn in range(n_turns + 1):
        ax, ay = nodes[count - 1]["x"], nodes[count - 1]["y"]
        stop = m if turn == n_turns else abs(turns[turn]) - 1
        left = turn < n_turns and turns[turn] > 0
        bx, by = zx, zy
        if turn < n_turns:
            bx, by = (portals[stop]["lx"], portals[stop]["ly"]) if left else (portals[stop]["rx"], portals[stop]["ry"])
        while k < stop and not (turn < n_turns and _touches(portals[k], bx, by)):
            portal = portals[k]
            px, py = portal["lx"], portal["ly"]
            across = _cross(bx - ax, by - ay, portal["rx"] - px, portal["ry"] - py)
            t = _cross(bx - ax, by - ay, ax - px, ay - py) / across if across != 0.0 else 0.0
            if t <= SNAP or t >= 1.0 - SNAP:
                k = _add_vertex(flat, count, k, t <= SNAP)
            else:
                node = nodes[count]
                node["x"], node["y"], node["t"] = px + t * (portal["rx"] - px), py + t * (portal["ry"] - py), t
                node["vertex"], node["first"], node["last"] = -1, k, k
                k += 1
            count += 1
        if turn < n_turns:
            k = max(k, _add_vertex(flat, count, stop, left))
            count += 1
    node = nodes[count]
    node["x"], node["y"], node["t"], node["vertex"], node["first"], node["last"] = zx, zy, 0.0, end, m, m
    return count + 1


@kernel
def tighten(sleeve: IndexArray, start: int, flat: FlatSleeve, mesh: UnfoldedMesh) -> float:
    """Length of the taut path from vertex ``start`` through a sleeve, laid out in ``flat``.

    The start must be the apex of the triangle before the first half-edge; the path ends in the apex of the
    last triangle.
    """
    _lay_flat(sleeve, flat, mesh)
    node = flat.nodes[0]
    node["vertex"], node["first"], node["last"], node["t"] = start, -1, -1, 0.0
    count = _list_nodes(flat, _pull_tight(flat))
    flat.size[1] = count
    length = 0.0
    for k in range(1, count):
        dx, dy = flat.nodes[k]["x"] - flat.nodes[k - 1]["x"], flat.nodes[k]["y"] - flat.nodes[k - 1]["y"]
        length += np.sqrt(dx * dx + dy * dy)
    return length


@kernel
def _angle(ax: float, ay: float, bx: float, by: float) -> float:
    return np.arctan2(abs(_cross(ax, ay, bx, by)), ax * bx + ay * by)


@kernel
def _way(flat: FlatSleeve, k: int, step: int) -> tuple[float, float, bool]:
    """From node k to the next one before (step -1) or behind it (+1) in another place; False where that is the end."""
    node = flat.nodes[k]
    x, y = node["x"], node["y"]
    portal = flat.portals[node["first"]]
    near = TOGETHER * (abs(x) + abs(y) + abs(portal["lx"] - portal["rx"]) + abs(portal["ly"] - portal["ry"]))
    j = k + step
    while 0 < j < flat.size[1] - 1 and abs(flat.nodes[j]["x"] - x) + abs(flat.nodes[j]["y"] - y) <= near:
        j += step
    dx, dy = flat.nodes[j]["x"] - x, flat.nodes[j]["y"] - y
    return dx, dy, abs(dx) + abs(dy) > near


@kernel
def side_angles(flat: FlatSleeve, k: int, mesh: UnfoldedMesh) -> tuple[float, float]:
    """Angles to the left and to the right of the path at its interior node k, in the triangles that meet there."""
    node = flat.nodes[k]
    x, y = node["x"], node["y"]
    ux, uy, comes = _way(flat, k, -1)
    wx, wy, goes = _way(flat, k, 1)
    if node["vertex"] < 0 and comes != goes:  # the path starts or ends on the edge: straight on
        ux, uy, wx, wy = (-wx, -wy, wx, wy) if goes else (ux, uy, -ux, -uy)
    portal = flat.portals[node["first"]]
    if node["vertex"] < 0:
        lx, ly, rx, ry = portal["lx"] - x, portal["ly"] - y, portal["rx"] - x, portal["ry"] - y
        left = _angle(ux, uy, lx, ly) + _angle(lx, ly, wx, wy)
        return left, _angle(ux, uy, rx, ry) + _angle(rx, ry, wx, wy)
    # The sleeve goes about the vertex on one side: add up its fan, and take the rest from the total.
    at_left = portal["lx"] == x and portal["ly"] == y
    inner = 0.0
    for g in range(node["first"], node["last"] + 1):
        portal = flat.portals[g]
        vx, vy = (portal["rx"] - x, portal["ry"] - y) if at_left else (portal["lx"] - x, portal["ly"] - y)
        inner += _angle(ux, uy, vx, vy)
        ux, uy = vx, vy
    inner += _angle(ux, uy, wx, wy)
    outer = mesh.angles[node["vertex"]] - inner
    return (outer, inner) if at_left else (inner, outer)
