"""A match as a widget takes it: of the meshes that are shown, with the closed surfaces that were matched for them."""

from __future__ import annotations

from typing import Any

from qgeo_filters._typing import RepairOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import as_given
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.hosts.wrap import Wrap
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface
from qgeo_widgets.shown_mesh import wrap_around


def checked_match(found: MatchResult, x: Surface, y: Surface) -> MatchResult:
    """The match, where it is one of these shapes."""
    matched, shown = (found.x.n_vertices, found.y.n_vertices), (x.n_vertices, y.n_vertices)
    if matched != shown:
        raise ParameterError(
            f"p2p is a match of shapes of {matched[0]} and {matched[1]} vertices, but these have {shown[0]} and "
            f"{shown[1]}: show the shapes that were matched, X first"
        )
    return found


def wraps_of_match(x: Any, y: Any, repair: RepairOption, p2p: Any) -> tuple[Any, Any]:
    """The meshes, each with the wrap around it where one was matched that no option says otherwise of."""
    if not isinstance(p2p, MatchResult) or repair not in ("auto", "wrap"):
        return x, y
    return _with_wrap(x, p2p.around_x), _with_wrap(y, p2p.around_y)


def _with_wrap(mesh: Any, wrap: Wrap | None) -> Any:
    """The wrap as one of this mesh, whose own attributes are shown; the mesh where it is another one."""
    if wrap is None or isinstance(mesh, Repair):
        return mesh
    given = as_given(mesh, "wrap")[0]
    return wrap_around(given, wrap) if given.n_vertices == wrap.given.n_vertices else mesh
