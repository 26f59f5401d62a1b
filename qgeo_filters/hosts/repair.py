"""A manifold surface in one piece from a mesh of any host, with what was changed and the way back."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.arrays import is_path, raw_mesh
from qgeo_filters.hosts.holes import checked_holes, filled
from qgeo_filters.html_repr import card
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.repair.sound import sound_mesh
from qgeo_filters.repair.triangle_soup import Pieces, most_lost, repaired_mesh
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Repair:
    """A repaired surface and how its vertices correspond to the original ones.

    Attributes
    ----------
    given : Surface
        The mesh as it was, with all of its vertices. Where no `Surface` can hold it: without the faces that name a
        missing, not finite or repeated vertex, vertices that are not finite in the middle of the others.
    surface : Surface
        Manifold and in one piece, with the attributes of the original vertices.
    origin : (n_new,) int64
        Original index of each vertex; one original vertex may appear several times, where it was split.
    vertex_of_original : (n_old,) int64
        Vertex that stands for each original one, -1 where it is gone. Several may share one, where they were joined: it
        has the position and the attributes of the first.
    face_origin : (m_new,) int64
        Face of ``given`` that each face was; -1 for one that fills a hole.
    turned : (m_new,) bool
        Whether it was turned over: its corners are those of that face from last to first.
    report : tuple of str
        What was changed, one sentence each with its count; empty if nothing was.

    Examples
    --------
    >>> soup = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> repair = qg.repair_surface((soup, [[0, 1, 2], [3, 4, 5]]))
    >>> repair.origin, repair.vertex_of_original
    (array([0, 1, 2, 5]), array([0, 1, 2, 0, 2, 3]))
    >>> repair.report
    ('2 boundary vertices joined with others at the same place',)
    """

    given: Surface
    surface: Surface
    origin: IndexArray
    vertex_of_original: IndexArray
    face_origin: IndexArray
    turned: npt.NDArray[np.bool_]
    report: tuple[str, ...]

    def __repr__(self) -> str:
        done = "; ".join(self.report) or "nothing had to be changed"
        return f"{type(self).__name__}({self.given.n_vertices} vertices to {self.surface.n_vertices}: {done})"

    def _repr_html_(self) -> str:
        facts = {"given": repr(self.given), "repaired": repr(self.surface)}
        table = [(str(number), line) for number, line in enumerate(self.report, start=1)]
        done = "" if self.report else "nothing had to be changed"
        return card(
            type(self).__name__, facts, subtitle=done, table=table, columns=("", "what was changed") if table else ()
        )

    @property
    def changed(self) -> bool:
        """Whether anything had to be changed."""
        return bool(self.report)

    @property
    def keeps_vertices(self) -> bool:
        """Whether each vertex is one of the original ones: then maps come back by `origin`, else by places."""
        return True

    @property
    def wrap_alpha(self) -> float:
        """The ``alpha`` of `wrap_surface`, 0 where nothing was wrapped."""
        return 0.0

    @property
    def place_arrays(self) -> dict[str, np.ndarray]:
        """What brings values back besides vertices that stand for others: nothing."""
        return {}

    def map_back(self, values: npt.ArrayLike) -> np.ndarray:
        """Values at the original vertices, shape (n_old, ...), from values at the repaired ones.

        Where a vertex is gone: NaN for floating-point values, -1 for integers (unsigned ones become
        int64), False for booleans.
        """
        array = self._of_repaired(values)
        missing: Any = {"b": False, "i": -1}.get(array.dtype.kind, np.nan)
        back = array[np.maximum(self.vertex_of_original, 0)]
        back[self.vertex_of_original < 0] = missing
        return back

    def _of_repaired(self, values: npt.ArrayLike) -> np.ndarray:
        """Values at the repaired vertices, of a kind that has something to say that there is none."""
        array = as_array(values)
        if len(array) != len(self.origin):
            raise MeshError(f"values of shape {array.shape} do not fit the {len(self.origin)} repaired vertices")
        return array.astype(np.int64) if array.dtype.kind == "u" else array

    def places_on_given(self, places: BarycentricMap) -> BarycentricMap:
        """Points of triangles of ``given``, for points of triangles of ``surface``."""
        chosen = np.maximum(places.faces, 0)
        faces = np.where(places.faces >= 0, self.face_origin[chosen], -1)
        there = (faces >= 0)[:, None]
        corners = np.where(there, self.given.faces[np.maximum(faces, 0)].astype(np.int64), -1)
        turned = np.where(self.turned[chosen][:, None], places.coordinates[:, ::-1], places.coordinates)
        return BarycentricMap(frozen(faces), frozen(corners), frozen(np.where(there, turned, np.nan)))

    def areas_on_given(self, areas: FloatArray) -> FloatArray:
        """Area of each original vertex, from those of the repaired: joined ones share it, 0 where one is gone."""
        place = self.vertex_of_original
        there = place >= 0
        sharing = np.bincount(place[there], minlength=len(self.origin))
        found = np.zeros(len(place))
        found[there] = (areas / np.maximum(sharing, 1))[place[there]]
        return found


def repair_surface(
    obj: Any, *, force: bool = False, pieces: Pieces = "largest", fill_holes: bool | int = False
) -> Repair:
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
    pieces : {"largest", "all"}
        Whether only the piece of largest area stays, or all of them, each manifold.
    fill_holes : bool or int
        Whether holes are filled with triangles in the end, and of how many edges at most; no vertex is added. Distances
        across a hole become short ones: fill what the scanner left, not where a neck was cut off.

    Returns
    -------
    Repair
        Faces that fill holes come last, with -1 for their ``face_origin``.

    Raises
    ------
    ParameterError
        A number of edges below 3.
    MeshError
        No faces are left, so much would be removed that it must be forced (the message says what and how many pieces
        there are), or the arrays are no triangle list at all.

    Examples
    --------
    >>> vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]
    >>> faces = [[0, 1, 2], [0, 1, 2], [0, 3, 2]]  # one twice, one turned over
    >>> repair = qg.repair_surface((vertices, faces))
    >>> repair.surface, repair.vertex_of_original
    (Surface(4 vertices, 2 faces), array([ 0,  1,  2,  3, -1]))
    >>> repair.report
    ('1 duplicate face removed', '1 face turned over to the orientation of the others', 'of 5 vertices 1 is gone (4)')
    """
    most_edges = checked_holes(fill_holes)
    repaired = repaired_within(obj, most_lost("force" if force else True), pieces)
    surface, said = filled(repaired.surface, most_edges)
    if not said:
        return repaired
    _log.info("repair: %s", said)
    added = surface.n_faces - repaired.surface.n_faces
    return replace(
        repaired,
        surface=surface,
        face_origin=frozen(np.append(repaired.face_origin, np.full(added, -1))),
        turned=frozen(np.append(repaired.turned, np.zeros(added, dtype=bool))),
        report=(*repaired.report, said),
    )


def repaired_within(obj: Any, most: float, pieces: Pieces = "largest") -> Repair:
    """The same where this share of the area may be removed."""
    raw = raw_mesh(obj, repair=True)
    with path_in_errors(obj if is_path(obj) else None):
        sound = sound_mesh(raw)
        repaired = repaired_mesh(sound, most_lost=most, pieces=pieces)
        given = obj if isinstance(obj, Surface) else Surface.from_raw(sound.raw)
        unchanged = isinstance(obj, Surface) and not repaired.report
        surface = obj if unchanged else Surface.from_raw(repaired.mesh)  # itself: with all that it has computed already
    for change in repaired.report:
        _log.info("repair: %s", change)
    return Repair(
        given,
        surface,
        repaired.origin,
        repaired.vertex_of_original,
        # Of the faces that `given` has: a Surface has none that are not sound.
        frozen(np.searchsorted(sound.face_origin, repaired.face_origin)),
        repaired.turned,
        repaired.report,
    )


def needs_repair(surface: Surface, pieces: Pieces = "largest") -> bool:
    """Whether something is wrong that `repair_surface` may mend; a closed surface that is inside out is not."""
    return (
        not surface.is_manifold
        or (pieces == "largest" and surface.components[0] > 1)
        or not surface.is_oriented
        or bool((surface.edge_lengths == 0).any())
        or surface.unwelded_vertices.size > 0
    )
