"""Direct geodesics from a vertex: straight lines through unfolded triangles, as far as they are needed.

The triangles around a vertex v are unfolded into the plane, v at the origin, window by window (Xin and
Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", ACM TOG 28(4), 2009). A window is
what v sees through one side of a triangle. A vertex q that comes into sight is joined to v by a
straight line, an edge of the discrete geodesic graph (Wang, Fang, Xin, He, Ying et al., "Discrete geodesic
graph (DGG) for computing geodesic distances on discrete surfaces", CAGD 52, 2017).

What is seen past a vertex p needs no edge of its own where the detour over p is small. With
``hop <= |vp|`` the length of the first edge on the way to p, a point x is covered by p where

    d(v, p) + |px| <= |vx| + eps * hop.

By induction on the distance, every straight line from v that has no edge of its own is then followed by graph edges
within a factor of 1 + eps + eps^2, because each edge used pays only for its own length. The covered
points of a window are those inside a branch of a hyperbola with the foci v and p, a convex set that grows along every ray:
windows are trimmed from both ends, and end when nothing is left.
"""

from __future__ import annotations

import numpy as np
from numba import njit

# Columns of a window: the ends of its side, the ends of the part that is still seen, and on either hand
# the vertex that covers: position, d(v, p) - eps * hop, hop.
WIDTH = 16


@njit(cache=True, nogil=True)
def covered_length(x, y, dx, dy, span, px, py, near):  # type: ignore[no-untyped-def]
    """How far from (x, y) along the unit vector (dx, dy), up to span, |z| - |z - p| >= near holds."""
    rr = px * px + py * py
    if rr <= 0.0 or near == np.inf:
        return 0.0
    shift = 0.5 * (rr - near * near)
    ex, ey = x + span * dx, y + span * dy
    if near * np.sqrt(ex * ex + ey * ey) <= ex * px + ey * py - shift:
        return span
    # The border: near |z| = <z, p> - shift on z = (x, y) + t (dx, dy), a quadratic in t.
    at_start = x * px + y * py - shift
    slope = dx * px + dy * py
    c = near * near * (x * x + y * y) - at_start * at_start
    if at_start <= 0.0 or c >= 0.0:
        return 0.0
    b = near * near * (x * dx + y * dy) - at_start * slope
    a = near * near - slope * slope
    root = np.sqrt(max(b * b - a * c, 0.0))
    if b >= 0.0:
        t = -c / (b + root) if b + root > 0.0 else 0.0
    else:
        t = (root - b) / a if a > 0.0 else 0.0
    return min(max(t, 0.0), span)


@njit(cache=True, nogil=True)
def _crossing(rx, ry, x, y, dx, dy, span):  # type: ignore[no-untyped-def]
    """Where the ray (rx, ry) from the origin meets the segment, as a length along it."""
    across = rx * dy - ry * dx
    if across == 0.0:
        return 0.0
    return min(max(-(rx * y - ry * x) / across, 0.0), span)


@njit(cache=True, nogil=True)
def push_window(layout, queue, sides, tail, side, lx, ly, rx, ry, sl, sr, p, q, near, limit):  # type: ignore[no-untyped-def]
    """Put the part of a triangle's side that is seen and not covered into the queue; the new tail.

    ``side`` is the side of the triangle just unfolded, (lx, ly) its left end and (rx, ry) its right one as seen from
    the origin; ``sl``, ``sr`` point along the bounding rays; ``cover`` holds both covering vertices.
    ``near[q]`` is d(v, q) - eps * hop as far as known, infinite otherwise.
    """
    twin = layout.twin[side // 2]
    if twin < 0:
        return tail
    dx, dy = rx - lx, ry - ly
    span = layout.length[side // 2]
    if span <= 0.0:
        return tail
    dx /= span
    dy /= span
    first = _crossing(sl[0], sl[1], lx, ly, dx, dy, span)
    last = _crossing(sr[0], sr[1], lx, ly, dx, dy, span)
    if last <= first:
        return tail
    first += covered_length(lx + first * dx, ly + first * dy, dx, dy, last - first, p[0], p[1], p[2])
    if last <= first:
        return tail
    last -= covered_length(lx + last * dx, ly + last * dy, -dx, -dy, last - first, q[0], q[1], q[2])
    if last <= first:
        return tail
    fx, fy = lx + first * dx, ly + first * dy
    ex, ey = lx + last * dx, ly + last * dy
    # The ends of the side cover all of it when they cover the far end: |z| falls no faster than |z - end|.
    left_vertex, right_vertex = _ends(layout, side)
    if np.sqrt(ex * ex + ey * ey) - last >= near[left_vertex]:
        return tail
    if np.sqrt(fx * fx + fy * fy) - (span - first) >= near[right_vertex]:
        return tail
    if min(np.sqrt(fx * fx + fy * fy), np.sqrt(ex * ex + ey * ey)) > limit + span:
        return tail
    slot = tail % len(queue)
    sides[slot] = 2 * twin + (1 if layout.start[twin] == left_vertex else 0)
    row = queue[slot]
    row[0] = lx
    row[1] = ly
    row[2] = rx
    row[3] = ry
    row[4] = fx
    row[5] = fy
    row[6] = ex
    row[7] = ey
    for k in range(4):
        row[8 + k] = p[k]
        row[12 + k] = q[k]
    return tail + 1


@njit(cache=True, nogil=True)
def _ends(layout, side):  # type: ignore[no-untyped-def]
    """Left and right vertex of a side; ``side`` is 2 * side + 1 where its start is on the left."""
    h = side // 2
    following = h + 1 if h % 3 < 2 else h - 2
    if side % 2 == 1:
        return layout.start[h], layout.start[following]
    return layout.start[following], layout.start[h]


@njit(cache=True, nogil=True)
def _grown(queue, sides, head, tail):  # type: ignore[no-untyped-def]
    """Ring of twice the size with the same windows in order, first one in slot 0."""
    size = len(queue)
    more, more_sides = np.empty((2 * size, WIDTH)), np.empty(2 * size, np.int64)
    for i in range(head, tail):
        more[i - head] = queue[i % size]
        more_sides[i - head] = sides[i % size]
    return more, more_sides


@njit(cache=True, nogil=True)
def _join(q, length, epsilon, near, hop, direct, found, count):  # type: ignore[no-untyped-def]
    """Give v an edge to q, or a shorter one; the new number of edges."""
    if direct[q] == np.inf:
        found[count] = q
        count += 1
    direct[q] = min(direct[q], length)
    if (1.0 - epsilon) * length < near[q] and length > 0.0:
        near[q] = (1.0 - epsilon) * length
        hop[q] = length
    return count


@njit(cache=True, nogil=True)
def _look_around(layout, v, epsilon, limit, queue, sides, near, hop, direct, found):  # type: ignore[no-untyped-def]
    """Edges from v to its neighbours, and its first windows; number of edges and of windows."""
    count = tail = 0
    for c in layout.corners[layout.corner_start[v] : layout.corner_start[v + 1]]:
        f = c - c % 3
        opposite, last = f + (c + 1) % 3, f + (c + 2) % 3
        count = _join(layout.start[opposite], layout.length[c], epsilon, near, hop, direct, found, count)
        count = _join(layout.start[last], layout.length[last], epsilon, near, hop, direct, found, count)
    for c in layout.corners[layout.corner_start[v] : layout.corner_start[v + 1]]:
        f = c - c % 3
        opposite, last = f + (c + 1) % 3, f + (c + 2) % 3
        a, b = layout.start[opposite], layout.start[last]
        ax, bx, by = layout.length[c], layout.apex_x[c], layout.apex_y[c]
        p, q = (bx, by, near[b], hop[b]), (ax, 0.0, near[a], hop[a])
        if tail == len(queue):
            queue, sides = _grown(queue, sides, 0, tail)
        tail = push_window(
            layout, queue, sides, tail, 2 * opposite, bx, by, ax, 0.0, (bx, by), (ax, 0.0), p, q, near, limit
        )
    return count, tail, queue, sides


@njit(cache=True, nogil=True)
def look(layout, v, epsilon, limit, queue, sides, near, hop, direct, found, met):  # type: ignore[no-untyped-def]
    """Edges of the discrete geodesic graph out of v: their ends in ``found``, lengths in ``direct``.

    Returns the number of edges, of vertices met otherwise (in ``met``, so that `near` can be cleared), and the queue, which may have
    grown.
    """
    count, tail, queue, sides = _look_around(layout, v, epsilon, limit, queue, sides, near, hop, direct, found)
    head = others = 0
    while head < tail:
        slot = head % len(queue)
        side = sides[slot]
        h = side // 2
        w = queue[slot]
        lx, ly, rx, ry = w[0], w[1], w[2], w[3]
        left_ray, right_ray = (w[4], w[5]), (w[6], w[7])
        p, q = (w[8], w[9], w[10], w[11]), (w[12], w[13], w[14], w[15])
        head += 1
        # Third vertex of the triangle entered, and its other two sides.
        length = layout.length[h]
        along = layout.apex_x[h] if side % 2 == 1 else length - layout.apex_x[h]
        dx, dy = (rx - lx) / length, (ry - ly) / length
        cx, cy = lx + along * dx - layout.apex_y[h] * dy, ly + along * dy + layout.apex_y[h] * dx
        following = h + 1 if h % 3 < 2 else h - 2
        previous = h - 1 if h % 3 > 0 else h + 2
        apex = layout.start[previous]
        if side % 2 == 1:
            left_side, right_side = 2 * previous, 2 * following
        else:
            left_side, right_side = 2 * following + 1, 2 * previous + 1
        if tail + 2 - head >= len(queue):
            queue, sides = _grown(queue, sides, head, tail)
            tail -= head
            head = 0
        sees_left = left_ray[0] * cy - left_ray[1] * cx < 0.0
        sees_right = right_ray[0] * cy - right_ray[1] * cx > 0.0
        if sees_left and sees_right:
            distance = np.sqrt(cx * cx + cy * cy)
            to_p, to_q = np.sqrt((cx - p[0]) ** 2 + (cy - p[1]) ** 2), np.sqrt((cx - q[0]) ** 2 + (cy - q[1]) ** 2)
            over_p, over_q = p[2] + to_p, q[2] + to_q
            if min(over_p, over_q, near[apex]) > distance or distance < direct[apex] < np.inf:
                count = _join(apex, distance, epsilon, near, hop, direct, found, count)
            elif min(over_p, over_q) < near[apex]:
                if near[apex] == np.inf:
                    met[others] = apex
                    others += 1
                near[apex], hop[apex] = (over_p, p[3]) if over_p <= over_q else (over_q, q[3])
            c = (cx, cy, near[apex], hop[apex])
            ray = (cx, cy)
            tail = push_window(
                layout,
                queue,
                sides,
                tail,
                left_side,
                lx,
                ly,
                cx,
                cy,
                left_ray,
                ray,
                p,
                q if over_q <= distance else c,
                near,
                limit,
            )
            tail = push_window(
                layout,
                queue,
                sides,
                tail,
                right_side,
                cx,
                cy,
                rx,
                ry,
                ray,
                right_ray,
                p if over_p <= distance else c,
                q,
                near,
                limit,
            )
        elif sees_left:
            tail = push_window(
                layout, queue, sides, tail, left_side, lx, ly, cx, cy, left_ray, right_ray, p, q, near, limit
            )
        elif sees_right:
            tail = push_window(
                layout, queue, sides, tail, right_side, cx, cy, rx, ry, left_ray, right_ray, p, q, near, limit
            )
    return count, others, queue, sides


@njit(cache=True, nogil=True)
def look_from(layout, first, last, epsilon, limit):  # type: ignore[no-untyped-def]
    """Edges out of the vertices first, ..., last - 1: how many each, their ends and lengths."""
    n = len(layout.corner_start) - 1
    near, hop, direct = np.full(n, np.inf), np.full(n, np.inf), np.full(n, np.inf)
    found, met = np.empty(n, np.int32), np.empty(n, np.int32)
    queue, sides = np.empty((256, WIDTH)), np.empty(256, np.int64)
    counts = np.zeros(last - first, np.int32)
    ends, lengths = np.empty(64 * (last - first) + n, np.int32), np.empty(64 * (last - first) + n)
    total = 0
    for v in range(first, last):
        near[v] = 0.0
        count, others, queue, sides = look(layout, v, epsilon, limit, queue, sides, near, hop, direct, found, met)
        if total + count > len(ends):
            size = 2 * len(ends)
            ends, lengths = _extended(ends, size), _extended(lengths, size)
        for i in range(count):
            q = found[i]
            ends[total + i], lengths[total + i] = q, direct[q]
            near[q] = hop[q] = direct[q] = np.inf
        for i in range(others):
            near[met[i]] = hop[met[i]] = np.inf
        near[v] = np.inf
        counts[v - first] = count
        total += count
    return counts, ends[:total].copy(), lengths[:total].copy()


@njit(cache=True, nogil=True)
def _extended(array, size):  # type: ignore[no-untyped-def]
    more = np.empty(size, array.dtype)
    more[: len(array)] = array
    return more
