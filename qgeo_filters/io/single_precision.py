"""What float32, in which some formats are written, does to a mesh."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.errors import MeshError

_UNSEEN = 1e-4  # of the mean edge


def single_precision_note(vertices: FloatArray, faces: IntArray) -> str | None:
    """How far float32 moves the vertices, where that is more than 1e-4 of the mean edge; else None.

    Raises
    ------
    MeshError
        Coordinates beyond float32, or vertices that it moves by a mean edge and more.
    """
    with np.errstate(over="ignore"):
        single = vertices.astype(np.float32).astype(np.float64)
    beyond = np.flatnonzero(~np.isfinite(single).all(axis=1))
    if beyond.size:
        raise MeshError(
            f"vertices[{beyond[0]}] is {vertices[beyond[0]].tolist()}, beyond what the format holds (float32, "
            f"{np.finfo(np.float32).max:.3g}; {beyond.size} such {'vertex' if beyond.size == 1 else 'vertices'}); "
            "rescale it, or write .ply"
        )
    shifts = np.linalg.norm(single - vertices, axis=1)
    corners = vertices[faces]
    edge = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
    at = int(shifts.argmax())
    if shifts[at] <= _UNSEEN * edge:
        return None
    moved = f"vertices move by up to {shifts[at]:.3g} (vertex {at}), {shifts[at] / edge:.3g} of the mean edge"
    if shifts[at] >= edge:
        raise MeshError(f"in float32, which the format holds, {moved}; move the mesh to the origin, or write .ply")
    return f"written in float32: {moved} (move the mesh to the origin, or write .ply)"
