"""Pictures of a symmetry map and of the measure of eq. (3), for the reports of ``qgeo symmetry`` and ``qgeo demo``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from qgeo_filters.report.figures import plot_scalar
from qgeo_filters.report.maps import plot_sides, plot_symmetry
from qgeo_filters.report.shown import Shown, label_colors, mirror_colors
from qgeo_filters.report.view import best_view
from qgeo_filters.report.worst_places import plot_worst_places, worst_places

if TYPE_CHECKING:
    from qgeo_filters.cli.job import Job
    from qgeo_filters.matching.symmetry_result import Symmetry
    from qgeo_filters.surface import Surface


def shown_symmetry(surface: Surface, arrays: dict[str, Any], found: Symmetry | None) -> Shown:
    """Mirror images in one colour, and the asymmetry; where no map was found, the regions and the sum of eq. (3)."""
    if found is not None and found.found:
        view = best_view(surface.vertices, surface.faces)
        return Shown(mirror_colors(surface, found.nearest, view), found.asymmetry)
    regions = arrays["regions"]
    return Shown(label_colors(regions, int(regions.max(initial=-1)) + 1), arrays["symmetry_sum"])


def draw_symmetry(job: Job, surface: Surface, arrays: dict[str, Any], found: Symmetry | None) -> None:
    """Pictures of the map, its sides and asymmetry where there is one, and of the regions of eq. (3)."""
    if found is not None and found.found:
        job.picture(
            "symmetry",
            "The symmetry map from both sides (paper, Fig. 5): a point and its mirror image have one colour.",
            lambda: plot_symmetry(surface, p2p=found.nearest),
        )
        job.picture("sides", "The two sides and, red, the axis between them.", lambda: plot_sides(surface, found.side))
        job.picture(
            "asymmetry",
            "Asymmetry: how far, in the mean, the distances from a point differ from those from its mirror image.",
            lambda: plot_scalar(surface, found.asymmetry, "asymmetry (√area)"),
        )
        job.picture(
            "worst_places",
            "The places where distances differ most (their asymmetry, √area), and their mirror images below them.",
            lambda: plot_worst_places(
                surface,
                surface,
                found.nearest,
                found.asymmetry,
                worst_places(surface, found.asymmetry),
                names=("place", "mirror image"),
                colors=mirror_colors(surface, found.nearest, best_view(surface.vertices, surface.faces)),
                numbered=job.repairs[0] is None,  # else they would be those of the repaired mesh
            ),
        )
    unproven = "" if found is None or found.found else f"No symmetry map was found: {found.reason}. "
    job.picture(
        "symmetry_regions",
        f"{unproven}Regions of the measure of eq. (3) from both sides: symmetric points have one colour. So may "
        "others: the measure refutes a symmetry, it does not establish one.",
        lambda: plot_symmetry(surface, arrays["regions"]),
    )
    job.picture(
        "symmetry_sum",
        "The sum of eq. (3), whose bands the regions are: equal at symmetric points.",
        lambda: plot_scalar(surface, arrays["symmetry_sum"], "sum of eq. (3) (no unit)"),
    )
