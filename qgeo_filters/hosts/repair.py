"""A manifold surface in one piece from a mesh of any host, with what was changed and the way back."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.arrays import is_path, raw_mesh
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.repair.triangle_soup import repaired_mesh
from qgeo_filters.surface import Surface

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Repair:
    """A repaired surface and how its vertices correspond to the original ones.

    Attributes
    ----------
    surface : Surface
        Manifold and in one piece, with the attributes of the original vertices.
    origin : (n_new,) int64
        Original index of each vertex; one original vertex may appear several times, where it was split.
    vertex_of_original : (n_old,) int64
        Vertex that stands for each original one, -1 where it is gone. Several may share one, where they were joined: it
        has the position and the attributes of the first.
    report : tuple of str
        What was changed, one sentence each with its count; empty if nothing was.
    """

    surface: Surface
    origin: IndexArray
    vertex_of_original: IndexArray
    report: tuple[str, ...]

    @property
    def changed(self) -> bool:
        """Whether anything had to be changed."""
        return bool(self.report)

    def map_back(self, values: npt.ArrayLike) -> np.ndarray:
        """Values at the original vertices, shape (n_old, ...), from values at the repaired ones.

        Where a vertex is gone: NaN for floating-point values, -1 for integers (unsigned ones become
        int64), False for booleans.
        """
        array = np.asarray(values)
        if len(array) != len(self.origin):
            raise MeshError(f"values of shape {array.shape} do not fit the {len(self.origin)} repaired vertices")
        if array.dtype.kind == "u":
            array = array.astype(np.int64)
        missing: Any = {"b": False, "i": -1}.get(array.dtype.kind, np.nan)
        back = array[np.maximum(self.vertex_of_original, 0)]
        back[self.vertex_of_original < 0] = missing
        return back


def repair_surface(obj: Any, *, force: bool = False) -> Repair:
    """Manifold mesh in one piece, made from anything that `as_surface` takes.

    In this order: polygons are triangulated; faces that name a missing, not finite or repeated vertex are
    removed; edges of length zero are collapsed; of equal faces the first stays, and so it is with
    pieces that lie face by face on others; boundary edges that lie on each
    other are joined (see `repair.welding.welded`: triangle soups and seams close, and so does a slit); at an edge of
    three and more faces, pairs of faces that agree on the orientation stay together, the flattest first,
    and the others are cut off; vertices are split into one for each fan of faces; the piece of largest
    area stays; faces are turned to one orientation, if there is one, which is outwards where that can be told (see
    `Surface.winding`).

    Parameters
    ----------
    obj : Surface, (V, F), mesh object or path
        Need not be valid: indices out of range, NaN and repeated indices are repaired too.
    force : bool
        Go through with a repair that removes more than a hundredth of the area, or more than half of the faces because
        their vertices are missing or not finite: what ``repair="force"`` does elsewhere.

    Returns
    -------
    Repair

    Raises
    ------
    MeshError
        No faces are left, so much would be removed that it must be forced (the message says what and how many pieces
        there are), or the arrays are no triangle list at all.
    """
    raw = raw_mesh(obj, repair=True)
    with path_in_errors(obj if is_path(obj) else None):
        repaired = repaired_mesh(raw, force=force)
        unchanged = isinstance(obj, Surface) and not repaired.report
        surface = obj if unchanged else Surface.from_raw(repaired.mesh)  # itself: with all that it has computed already
    for change in repaired.report:
        _log.info("repair: %s", change)
    return Repair(surface, repaired.origin, repaired.vertex_of_original, repaired.report)
