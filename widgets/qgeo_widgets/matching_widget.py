"""What a widget of two shapes has besides views: the map between them, its twin, and landmarks to seek it again."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import MirrorOption, PartialOption
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import ParameterError, QgeoError
from qgeo_filters.filters import stages
from qgeo_filters.io.hint_files import read_hints
from qgeo_filters.matching.hints import vertex_pairs
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.validation import checked_index
from qgeo_widgets import controls
from qgeo_widgets.base import ShapeWidget
from qgeo_widgets.landmark_list import LandmarkList, landmark_color, landmark_table
from qgeo_widgets.shape import Shape
from qgeo_widgets.shown_match import checked_match
from qgeo_widgets.vertex_map import VertexMap

Pick = tuple[str, int]
SIDES = ("x", "y")


class MatchingWidget(ShapeWidget):
    """Two shapes and the map between them.

    Attributes
    ----------
    picked, second : (str, int) or None
        The points that were clicked, as ``("x", vertex)`` or ``("y", vertex)``. A third click starts anew.
    flip : bool
        Show the mirrored twin of the map: the map followed by the self-symmetry of Y.
    landmarks : list of (int, int)
        Vertices of X and of Y that are said to belong together: what `match_again` goes by. As everywhere, those of the
        meshes that were given, whatever is matched in their place.
    """

    picked = traitlets.Tuple(traitlets.Enum(SIDES), traitlets.Int(), default_value=None, allow_none=True)
    second = traitlets.Tuple(traitlets.Enum(SIDES), traitlets.Int(), default_value=None, allow_none=True)
    flip = traitlets.Bool(False)
    landmarks: traitlets.List[tuple[int, int]] = traitlets.List(traitlets.Tuple(traitlets.Int(), traitlets.Int()))

    def _set_up(self, shapes: tuple[Shape, Shape], p2p: npt.ArrayLike | MatchResult | None, progress: bool) -> None:
        """Take the shapes, and the map or match, or find one."""
        self._shapes = shapes
        self._correspondence: MatchResult | None = None
        self._normalize = True
        self._partial: PartialOption = "auto"
        self._mirror_option: MirrorOption = "auto"
        if p2p is None:
            p2p = self._found(progress)
        if isinstance(p2p, MatchResult):
            self._correspondence = checked_match(p2p, *(shape.surface for shape in shapes))
            self._normalize, self._partial, self._mirror_option = p2p.normalize, p2p.partial, p2p.mirror
            if min(p2p.overlap_x, p2p.overlap_y) < 1:
                self._partial = True
        self._map = self._given = self._map_of(p2p)

    def _map_of(self, p2p: npt.ArrayLike | MatchResult, name: str = "p2p") -> VertexMap:
        """A map between the meshes that were given; backwards as a match says."""
        x, y = self._shapes
        images, inverse = (p2p.p2p, p2p.inverse) if isinstance(p2p, MatchResult) else (p2p, None)
        return VertexMap(x.surface, y.surface, images, name, inverse=inverse, repairs=(x.repair, y.repair))

    def _map_controls(self) -> tuple[Sequence[ipywidgets.Widget], Sequence[ipywidgets.Widget]]:
        """Controls of the map, for beside the list of modes, and lines for below the shapes."""
        flip = controls.tick("mirrored", False, "the map followed by the self-symmetry of Y")
        flip.observe(lambda change: self._ticked(change["new"]), "value")
        self.observe(lambda _: flip.set_trait("value", self.flip), "flip")
        self._orientation = ipywidgets.HTML()
        self._list = LandmarkList(self.use_as_landmark, self._match_in_background, self._load_uploaded)
        traitlets.link((self, "landmarks"), (self._list, "landmarks"))
        self.observe(lambda _: self._flip(), "flip")
        self.observe(self._show_landmarks, "landmarks")
        return [flip], [self._orientation, self._list]

    def _map_changed(self) -> None:
        """Show what is shown of a map that is another one now."""
        raise NotImplementedError

    # -- for users ----------------------------------------------------------------------------------

    @property
    def p2p(self) -> npt.NDArray[np.int64]:
        """The map that is shown, (n_x,): vertex of Y for each vertex of X; -1: no partner."""
        return self._map.forward

    def use_as_landmark(self) -> None:
        """Say that the point picked on X belongs where the one picked on Y is; or that a single one is mapped right.

        A landmark of the same vertex of X, or of Y, gives way.
        """
        with self._guarded():
            picks = [pick for pick in (self.picked, self.second) if pick is not None]
            if not picks:
                raise ParameterError("Click a point on X, and then on Y where it belongs; the two become a landmark.")
            vertices = dict(picks)
            if len(picks) > 1 and len(vertices) < 2:
                raise ParameterError("Both points were picked on one shape: click one on X, and on Y where it belongs.")
            pair = (vertices["x"], vertices["y"]) if len(vertices) > 1 else self._pair(picks[0])
            if min(pair) < 0:
                raise ParameterError(
                    f"Vertex {picks[0][1]} of {picks[0][0].upper()} has no partner: click where it belongs, too."
                )
            others = [(i, j) for i, j in self.landmarks if i != pair[0] and j != pair[1]]
            self.landmarks = [*others, pair]

    def match_again(self) -> None:
        """Seek the map with the landmarks, and show it; with the options of the match that the widget was given."""
        with self._guarded():
            self._take(self._found(False))

    def save_landmarks(self, path: str | PathLike[str]) -> None:
        """Write the landmarks as CSV, a vertex of X and one of Y a line: what `load_landmarks` and commands read."""
        with atomic_write(path) as file:
            file.write(landmark_table(self.landmarks).encode())

    def load_landmarks(self, *paths: str | PathLike[str]) -> None:
        """Take landmarks from files, in place of those that are there.

        Parameters
        ----------
        paths : path
            One file of pairs of vertices (CSV), or two of landmarks, on X and on Y (``.mrk.json``, ``.fcsv`` and
            whatever `qgeo_filters.read_landmarks` knows), of which those of equal names belong together.

        Raises
        ------
        ParameterError, MeshError
            What is wrong with the files, or a landmark on what a repair removed, as `match` says; the landmarks are
            those from before.
        """
        found = read_hints([Path(path) for path in paths])
        pairs = vertex_pairs(found, *(shape.surface for shape in self._shapes))
        for shape, column in zip(self._shapes, pairs.T, strict=True):
            shape.check_landmarks(column)
        self.landmarks = [(int(i), int(j)) for i, j in pairs]

    # -- inside -------------------------------------------------------------------------------------

    def _found(self, progress: bool) -> MatchResult:
        (one, repair_one), (other, repair_other) = (shape.to_match for shape in self._shapes)
        landmarks = list(self.landmarks) or None
        with self._long.during("Seeking the map", at_once=True):
            return stages.correspondence_of(
                one,
                other,
                self._normalize,
                progress,
                repair_x=repair_one,
                repair_y=repair_other,
                partial=self._partial,
                mirror=self._mirror_option,
                landmarks=landmarks,
            )

    def _take(self, found: MatchResult) -> None:
        """Show the map that was found."""
        if self._viewer is None:  # closed meanwhile
            return
        self._correspondence = found
        self._given = self._map_of(found)
        if self.flip:
            self.flip = False  # which shows the map
        else:
            self._map = self._given
            self._map_changed()
        self._list.report(found.landmark_errors.tolist())

    def _match_in_background(self) -> None:
        """Seek the map without keeping the kernel from what else is clicked."""
        self._long.in_background("Seeking the map", self._run)

    def _run(self) -> None:
        self._list.busy = True
        try:
            self.match_again()
        finally:
            self._list.busy = False

    def _load_uploaded(self, folder: Path, names: Sequence[str]) -> None:
        """Take the landmarks of files that were chosen in the browser, and put into a folder."""
        with self._guarded():
            self.load_landmarks(*(folder / name for name in names))

    def _ticked(self, mirrored: bool) -> None:
        """Show the twin, or the map; in the background where the symmetry is still to be found."""
        if mirrored == self.flip or not self._mirror_takes_long:
            self.flip = mirrored
            return
        self._long.in_background("Finding the symmetry of Y", lambda: self.set_trait("flip", mirrored))

    @property
    def _mirror_takes_long(self) -> bool:
        return "_mirror" not in self.__dict__ and self._shapes[1].spectrum_takes_long

    def _flip(self) -> None:
        with self._guarded():
            try:
                with self._long.during("Finding the symmetry of Y"):
                    mirror = self._mirror if self.flip else None
            except QgeoError:
                self.flip = False  # the map that is shown is the one that was given
                raise
            if self.flip and mirror is None:
                self.flip = False  # the map that is shown is the one that was given
                self.message = "No symmetry was found on Y, so that the map has no mirrored twin."
                return
            self._map = self._given if mirror is None else self._given.then(mirror)
            self._map_changed()

    @cached_property
    def _mirror(self) -> npt.NDArray[np.integer] | None:
        """Mirror vertex of each vertex of Y, -1: none; None where no symmetry is found."""
        shape, repair = self._shapes[1].to_match
        symmetry = stages.symmetry_of(shape, repair=repair)
        return symmetry.p2p if symmetry.found else None

    def _show_orientation(self) -> None:
        found = self._correspondence
        value = self._map.orientation if found is None or self._map is not self._given else found.orientation
        verdict = (
            "keeps the orientation" if value > 0.1 else "is mirrored" if value < -0.1 else "has no clear orientation"
        )
        rows = [["map", f"{verdict} (mean cosine of carried and own normals {value:+.2f})"]]
        if found is not None:
            sure = "confident" if found.confident else "not confident"
            rows.append(
                ["score", f"{found.score:.4f} √area, mean distortion of distances; {sure}: {found.explanation}"]
            )
        if any(self._map.unmatched):
            rows.append(["grey", self._alone])
        rows += [[f"in place of {shape.name}", shape.report] for shape in self._shapes if shape.report]
        self._orientation.value = controls.table(rows)

    @property
    def _alone(self) -> str:
        """How many vertices of either shape have no partner."""
        counts = zip(self._map.unmatched, self._shapes, strict=True)
        said = (f"{count} of {shape.surface.n_vertices} of {shape.name}" for count, shape in counts)
        return f"vertices without a partner, {' and '.join(said)}"

    def _show_landmarks(self, change: Any) -> None:
        """A ball of one colour on both shapes for each landmark."""
        for number in range(max(len(change["old"] or ()), len(change["new"]))):
            pair = change["new"][number] if number < len(change["new"]) else (None, None)
            for pane, vertex in zip(self._open_viewer.panes, pair, strict=True):
                place = None if vertex is None else pane.surface.vertices[vertex]
                pane.set_mark(f"landmark {number}", place, landmark_color(number))

    @traitlets.validate("picked", "second")
    def _valid_pick(self, proposal: Any) -> Pick | None:
        pick: Pick | None = proposal["value"]
        if pick is not None and self._viewer is not None:
            checked_index(pick[1], self._shapes[SIDES.index(pick[0])].surface.n_vertices, proposal["trait"].name)
        return pick

    @traitlets.validate("landmarks")
    def _valid_landmarks(self, proposal: Any) -> list[tuple[int, int]]:
        pairs: list[tuple[int, int]] = proposal["value"]
        for number, pair in enumerate(pairs if self._viewer is not None else ()):
            for vertex, shape, side in zip(pair, self._shapes, "XY", strict=True):
                checked_index(vertex, shape.surface.n_vertices, f"landmark {number} on {side}")
        return pairs

    def _pair(self, pick: Pick) -> tuple[int, int]:
        """Vertex of X and of Y: the one that was picked, and its partner, -1: none."""
        side, vertex = pick
        if side == "x":
            return vertex, int(self._map.forward[vertex])
        return int(self._map.backward[vertex]), vertex
