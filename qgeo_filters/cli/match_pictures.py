"""Pictures of a correspondence, for the reports of ``qgeo match`` and of collections."""

from __future__ import annotations

from functools import partial as applied
from typing import TYPE_CHECKING

import numpy as np

from qgeo_filters.cli.job_text import as_title
from qgeo_filters.report.curves import plot_error_curve, plot_histogram
from qgeo_filters.report.figures import plot_scalar
from qgeo_filters.report.html import Picture, Table
from qgeo_filters.report.maps import plot_correspondence, plot_region_pair, view_alike
from qgeo_filters.report.match_log import plot_match_log
from qgeo_filters.report.view import View, best_view
from qgeo_filters.report.worst_places import plot_worst_places, worst_places

if TYPE_CHECKING:
    from qgeo_filters.cli.job import Job
    from qgeo_filters.matching.match_log import MatchLog
    from qgeo_filters.matching.match_result import MatchResult
    from qgeo_filters.surface import Surface

NAMES = ("match", "regions", "distortion", "distortion_histogram", "worst_places", "match_log")
NAMES_OF_ERRORS = ("errors", "error_curve")

_UNIT = "distortion of distances (√area)"
_DISTORTION = "How far, in the mean, the distances from a point of X differ from those from its image on Y."


def map_pictures(found: MatchResult, names: tuple[str, str]) -> list[Picture]:
    """The map and its distortion, of shapes of these names."""
    titles, views = _titles(names), _views(found.x, found.y, found)
    figure = plot_correspondence(found.x, found.y, found.p2p, names=titles, views=views)
    return [
        Picture("match", figure, _map_caption(found)),
        Picture("distortion", plot_scalar(found.x, found.distortion, _UNIT), _DISTORTION),
    ]


def draw_log(job: Job, log: MatchLog) -> None:
    """Picture of the maps that were proposed."""
    job.picture(
        "match_log",
        "The maps that were proposed, the chosen one first: how much they distort distances, what deforming X along "
        "them costs, and which rule dropped them (all of them: match_log.md).",
        applied(plot_match_log, log),
    )


def draw_worst(job: Job, x: Surface, y: Surface, found: MatchResult, errors: np.ndarray | None) -> Table:
    """Picture of the places where the map is worst, by its errors where the truth is known, and their table."""
    values, what = (found.distortion, "distortion") if errors is None else (errors, "error")
    places = worst_places(x, values)
    names = (as_title(job.names[0]), as_title(job.names[1]))
    if len(places):
        job.picture(
            "worst_places",
            f"Where the map is worst: the places of X of the largest {what} (√area), and their images on Y below them.",
            applied(plot_worst_places, x, y, found.p2p, values, places, names=names),
        )
    rows = [(int(place), int(found.p2p[place]), float(values[place])) for place in places]
    return Table("Worst places", rows, ("vertex of X", "vertex of Y", f"{what} (√area)"), "No two near each other.")


def draw_match(job: Job, x: Surface, y: Surface, found: MatchResult, errors: np.ndarray | None) -> None:
    """Pictures of the map, of its regions, its distortion, and its errors where the truth is known."""
    names, views = _titles((job.names[0], job.names[1])), _views(x, y, found)
    job.picture(
        "match",
        _map_caption(found),
        applied(plot_correspondence, x, y, found.p2p, names=names, views=views),
    )
    job.picture(
        "regions",
        "Regions of equal colour on both shapes (paper, Fig. 6).",
        applied(plot_region_pair, x, y, found.regions_x, found.regions_y, names=names, views=views),
    )
    known = np.isfinite(found.distortion)  # not where there is no partner
    job.picture(
        "distortion",
        _DISTORTION,
        applied(plot_scalar, x, found.distortion, _UNIT),
    )
    job.picture(
        "distortion_histogram",
        "The same over the area of X: all at the left for shapes that only bend.",
        applied(plot_histogram, found.distortion[known], x.vertex_areas[known], _UNIT),
    )
    if errors is not None:
        job.picture(
            "errors",
            "Distance on Y between a point's image and its true image.",
            applied(plot_scalar, x, errors, "error (√area)"),
        )
        job.picture(
            "error_curve",
            "Share of the points within an error.",
            applied(plot_error_curve, errors[np.isfinite(errors)]),
        )


def _titles(names: tuple[str, str]) -> tuple[str, str]:
    return f"X: {as_title(names[0])}", f"Y: {as_title(names[1])}"


def _views(x: Surface, y: Surface, found: MatchResult) -> tuple[View, View]:
    """Both shapes from the same side."""
    view = best_view(x.vertices, x.faces)
    return view, view_alike(x, view, y, found.p2p)


def _map_caption(found: MatchResult) -> str:
    doubt = "" if found.confident else f"Not confident: {found.explanation}. "
    return f"{doubt}The colours of Y carried over to X along the map: points that belong together have one colour."
