"""Direct geodesics from a vertex: straight lines through unfolded triangles, as far as they are needed.

The triangles around a vertex v are unfolded into the plane, v at the origin, window by window (Xin and
Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", ACM TOG 28(4), 2009). A window
is what v sees through one side of a triangle. A vertex that comes into sight is joined to v by a straight
line, an edge of the discrete geodesic graph (Wang, Fang, Xin, He, Ying et al., "Discrete geodesic graph
(DGG) for computing geodesic distances on discrete surfaces", CAGD 52, 2017).

What is seen past a vertex p needs no edge of its own where the detour over p is small. With ``hop`` the
length of the first edge on the way to p, a point x is covered by p where

    d(v, p) + |px| <= |vx| + eps * hop.

By induction on the distance, every straight line from v is then followed by edges of the graph within a
factor of 1 + eps + eps^2, because each edge pays only for its own length. In the plane the covered points
are the inside of a branch of a hyperbola with the foci v and p: a convex set that grows along every ray
from v. So windows are trimmed from both hands, and end when nothing is left.
"""

from __future__ import annotations

import numpy as np

from qgeo_filters.geodesics.flat_corners import split_at
from qgeo_filters.jit import njit

# Columns of a window: left and right end of the side, left and right end of the part still seen, and on
# either hand the vertex p that covers: its position, and d(v, p) - eps * hop, its covering bound.
WIDTH = 14


@njit(error_model="numpy")
def covered_length(x, y, dx, dy, span, px, py, bound):  # type: ignore[no-untyped-def]
    """How far from (x, y) along the unit vector (dx, dy), up to span, |z| - |z - p| >= bound holds."""
    rr = px * px + py * py
    if rr <= 0.0 or bound == np.inf:
        return 0.0
    shift = 0.5 * (rr - bound * bound)
    ex, ey = x + span * dx, y + span * dy
    if bound * np.sqrt(ex * ex + ey * ey) <= ex * px + ey * py - shift:
        return span
    # The border: bound |z| = <z, p> - shift on z = (x, y) + t (dx, dy), a quadratic in t.
    at_start = x * px + y * py - shift
    c = bound * bound * (x * x + y * y) - at_start * at_start
    if at_start <= 0.0 or c >= 0.0:
        return 0.0
    slope = dx * px + dy * py
    b = bound * bound * (x * dx + y * dy) - at_start * slope
    a = bound * bound - slope * slope
    root = np.sqrt(max(b * b - a * c, 0.0))
    # c < 0: the numerically stable form of the first root after the start.
    t = -c / (b + root) if b >= 0.0 else (root - b) / a
    return min(max(t, 0.0), span)


@njit(error_model="numpy")
def seen_part(lx, ly, dx, dy, span, left_ray, right_ray, p, q):  # type: ignore[no-untyped-def]
    """Interval of a side, as lengths from its left end, that lies between two rays and that p and q do not cover."""
    first = (left_ray[1] * lx - left_ray[0] * ly) / (left_ray[0] * dy - left_ray[1] * dx)
    last = (right_ray[1] * lx - right_ray[0] * ly) / (right_ray[0] * dy - right_ray[1] * dx)
    first, last = min(max(first, 0.0), span), min(max(last, 0.0), span)
    if not last > first:  # also where a ray runs along the side
        return 0.0, 0.0
    first += covered_length(lx + first * dx, ly + first * dy, dx, dy, last - first, p[0], p[1], p[2])
    if last <= first:
        return 0.0, 0.0
    last -= covered_length(lx + last * dx, ly + last * dy, -dx, -dy, last - first, q[0], q[1], q[2])
    return first, last


@njit(error_model="numpy")
def seed_one_ring(start, length, apex_x, apex_y, twin, corners, views, epsilon, queue, sides, bound, direct, found):  # type: ignore[no-untyped-def]  # fmt: skip
    """Edges to the neighbours of the vertex of these corners, and its first windows; how many of either."""
    count = tail = 0
    for i in range(2 * len(corners)):
        c = corners[i // 2]
        f = c - c % 3
        h = c if i % 2 == 0 else f + (c + 2) % 3
        neighbour = start[f + (c + 1) % 3] if i % 2 == 0 else start[h]
        if direct[neighbour] == np.inf:
            found[count] = neighbour
            count += 1
        if length[h] < direct[neighbour]:
            direct[neighbour] = length[h]
            if length[h] > 0.0:  # a vertex in the same place covers nothing: each would leave it to the other
                bound[neighbour] = (1.0 - epsilon) * length[h]
    for c in corners:
        f = c - c % 3
        opposite, last = f + (c + 1) % 3, f + (c + 2) % 3
        a, b = start[opposite], start[last]
        if twin[opposite] >= 0 and tail < len(sides):
            sides[tail] = 2 * twin[opposite] + (start[twin[opposite]] == b)
            queue[tail, 0] = queue[tail, 4] = queue[tail, 8] = apex_x[c]
            queue[tail, 1] = queue[tail, 5] = queue[tail, 9] = apex_y[c]
            queue[tail, 2] = queue[tail, 6] = queue[tail, 11] = length[c]
            queue[tail, 3] = queue[tail, 7] = queue[tail, 12] = 0.0
            queue[tail, 10], queue[tail, 13] = bound[b], bound[a]
            tail += 1
    for view in views:
        h = view["half"]
        sx, sy, c = view["sx"], view["sy"], start[h - h % 3 + (h + 2) % 3]
        if view["lo"] <= split_at(sx, sy, apex_x[h], apex_y[h]) <= view["hi"]:
            distance = np.hypot(apex_x[h] - sx, apex_y[h] + sy)
            if direct[c] == np.inf:
                found[count] = c
                count += 1
            if distance < direct[c]:
                direct[c], bound[c] = distance, (1.0 - epsilon) * distance if distance > 0.0 else np.inf
        if tail < len(sides):  # the vertex lies below the side, the start of that on its left
            left, right = -sx, length[h] - sx
            sides[tail] = 2 * h + 1
            queue[tail, 0] = queue[tail, 8] = left
            queue[tail, 2] = queue[tail, 11] = right
            queue[tail, 4], queue[tail, 6] = view["lo"] - sx, view["hi"] - sx
            queue[tail, 1] = queue[tail, 3] = queue[tail, 5] = queue[tail, 7] = queue[tail, 9] = queue[tail, 12] = sy
            queue[tail, 10], queue[tail, 13] = bound[start[h]], bound[start[h - h % 3 + (h + 1) % 3]]
            tail += 1
    return count, tail


@njit(error_model="numpy")
def direct_geodesics(start, length, apex_x, apex_y, twin, corners, views, epsilon, limit, queue, sides, bound, direct, found, bounded):  # type: ignore[no-untyped-def]  # noqa: E501  # fmt: skip
    """Edges of the discrete geodesic graph out of the vertex of these corners.

    Returns
    -------
    number of edges
        Their ends are in ``found``, their lengths in ``direct``.
    number of vertices bounded otherwise
        In ``bounded``; with those of ``found`` they are the ones whose ``bound`` was set.
    whether the queue was long enough
    """
    count, tail = seed_one_ring(
        start, length, apex_x, apex_y, twin, corners, views, epsilon, queue, sides, bound, direct, found
    )
    head = others = 0
    mask = len(sides) - 1  # the queue is a ring, its size a power of two
    while head < tail and tail - head < mask:
        slot = head & mask
        side = sides[slot]
        h = side >> 1
        lx, ly, rx, ry = queue[slot, 0], queue[slot, 1], queue[slot, 2], queue[slot, 3]
        left_ray, right_ray = (queue[slot, 4], queue[slot, 5]), (queue[slot, 6], queue[slot, 7])
        p = (queue[slot, 8], queue[slot, 9], queue[slot, 10])
        q = (queue[slot, 11], queue[slot, 12], queue[slot, 13])
        head += 1
        # Third vertex of the triangle entered, and its other two sides. Neighbours may disagree on
        # orientation: on which hand a side starts is kept with the side.
        start_on_left = side & 1
        following = h + 1 if h % 3 < 2 else h - 2
        previous = h - 1 if h % 3 > 0 else h + 2
        apex = start[previous]
        along = apex_x[h] if start_on_left else length[h] - apex_x[h]
        dx, dy = (rx - lx) / length[h], (ry - ly) / length[h]
        cx, cy = lx + along * dx - apex_y[h] * dy, ly + along * dy + apex_y[h] * dx
        sees_left = left_ray[0] * cy - left_ray[1] * cx < 0.0
        sees_right = right_ray[0] * cy - right_ray[1] * cx > 0.0
        left_q, right_p = q, p
        left_end, right_end = right_ray, left_ray
        if sees_left and sees_right:
            distance = np.sqrt(cx * cx + cy * cy)
            over_p = p[2] + np.sqrt((cx - p[0]) * (cx - p[0]) + (cy - p[1]) * (cy - p[1]))
            over_q = q[2] + np.sqrt((cx - q[0]) * (cx - q[0]) + (cy - q[1]) * (cy - q[1]))
            new = direct[apex] == np.inf and bound[apex] == np.inf
            if distance < direct[apex] and (direct[apex] < np.inf or min(over_p, over_q, bound[apex]) > distance):
                if direct[apex] == np.inf:
                    found[count] = apex
                    count += 1
                direct[apex] = distance
                bound[apex] = min(bound[apex], (1.0 - epsilon) * distance)
            else:
                bound[apex] = min(bound[apex], over_p, over_q)
            if new and direct[apex] == np.inf:
                bounded[others] = apex
                others += 1
            c = (cx, cy, bound[apex])
            left_end = right_end = (cx, cy)
            left_q = q if over_q <= distance < direct[apex] else c
            right_p = p if over_p <= distance < direct[apex] else c
        for hand in range(2):
            if hand == 0:
                if not sees_left:
                    continue
                child = previous if start_on_left else following
                left_vertex, right_vertex = start[h] if start_on_left else start[following], apex
                ax, ay, bx, by = lx, ly, cx, cy
                near_ray, far_ray, near_p, far_q = left_ray, left_end, p, left_q
            else:
                if not sees_right:
                    continue
                child = following if start_on_left else previous
                left_vertex, right_vertex = apex, start[following] if start_on_left else start[h]
                ax, ay, bx, by = cx, cy, rx, ry
                near_ray, far_ray, near_p, far_q = right_end, right_ray, right_p, q
            span = length[child]
            if twin[child] < 0 or span <= 0.0:
                continue
            dx, dy = (bx - ax) / span, (by - ay) / span
            first, last = seen_part(ax, ay, dx, dy, span, near_ray, far_ray, near_p, far_q)
            if last <= first:
                continue
            fx, fy, ex, ey = ax + first * dx, ay + first * dy, ax + last * dx, ay + last * dy
            to_first, to_last = np.sqrt(fx * fx + fy * fy), np.sqrt(ex * ex + ey * ey)
            # An end of the side covers all of it if it covers the far end: |z| falls no faster than |z - end|.
            if (
                to_last - last >= bound[left_vertex]
                or to_first - (span - first) >= bound[right_vertex]
                or min(to_first, to_last) > limit + span
            ):
                continue
            slot = tail & mask
            sides[slot] = 2 * twin[child] + (start[twin[child]] == left_vertex)
            queue[slot, 0], queue[slot, 1], queue[slot, 2], queue[slot, 3] = ax, ay, bx, by
            queue[slot, 4], queue[slot, 5], queue[slot, 6], queue[slot, 7] = fx, fy, ex, ey
            queue[slot, 8], queue[slot, 9], queue[slot, 10] = near_p
            queue[slot, 11], queue[slot, 12], queue[slot, 13] = far_q
            tail += 1
    return count, others, head == tail


@njit()
def direct_geodesics_from(start, length, apex_x, apex_y, twin, corner_start, corners, view_start, views, vertices, epsilon, limit):  # type: ignore[no-untyped-def]  # noqa: E501  # fmt: skip
    """Edges of the graph out of some vertices: how many each, their ends and lengths."""
    n = len(corner_start) - 1
    bound, direct = np.full(n, np.inf), np.full(n, np.inf)
    found, bounded = np.empty(n, np.int32), np.empty(n, np.int32)
    queue, sides = np.empty((512, WIDTH)), np.empty(512, np.int64)
    counts = np.zeros(len(vertices), np.int64)
    ends, lengths = np.empty(64 * len(vertices), np.int32), np.empty(64 * len(vertices))
    total = i = 0
    while i < len(vertices):
        v = vertices[i]
        bound[v] = direct[v] = 0.0
        count, others, complete = direct_geodesics(
            start, length, apex_x, apex_y, twin, corners[corner_start[v] : corner_start[v + 1]],
            views[view_start[v] : view_start[v + 1]], epsilon, limit, queue, sides, bound, direct, found, bounded,
        )  # fmt: skip
        if total + count > len(ends):
            more, longer = np.empty(2 * (total + count), np.int32), np.empty(2 * (total + count))
            more[:total], longer[:total] = ends[:total], lengths[:total]
            ends, lengths = more, longer
        for k in range(count):
            q = found[k]
            ends[total + k], lengths[total + k] = q, direct[q]
            bound[q] = direct[q] = np.inf
        for k in range(others):
            bound[bounded[k]] = np.inf
        bound[v] = direct[v] = np.inf
        if complete:
            counts[i] = count
            total += count
            i += 1
        else:  # once more with room for more windows
            queue, sides = np.empty((2 * len(sides), WIDTH)), np.empty(2 * len(sides), np.int64)
    return counts, ends[:total].copy(), lengths[:total].copy()
