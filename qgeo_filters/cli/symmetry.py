"""``qgeo symmetry``: the map of a shape to itself that swaps left and right, beside the paper's measure, eq. (3)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
    ALL_DISTANCES,
    Accuracy,
    Also,
    Force,
    Json,
    MeshFiles,
    Method,
    Output,
    Pictures,
    Quiet,
    Repair,
    Scalar,
    Settings,
    Smoothing,
    Weight,
    Workers,
    Wrap,
    repair_option,
)
from qgeo_filters.defaults import CURVATURE_WEIGHT, SYMMETRY_K0

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.matching.symmetry_measure import Reading
    from qgeo_filters.matching.symmetry_result import Symmetry
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.spectral.spectrum import Spectrum
    from qgeo_filters.surface import Surface

_PAIRS = 2000
_PICTURES_OF_THE_MEASURE = ("symmetry_regions", "symmetry_sum")
SYMMETRY_PICTURES = ("symmetry", "sides", "asymmetry", "worst_places", *_PICTURES_OF_THE_MEASURE)


def symmetry(
    meshes: MeshFiles,
    explicit: Annotated[
        bool, typer.Option("--map/--no-map", help="Search for the map itself, or stop at the measure of eq. (3).")
    ] = True,
    k0: Annotated[
        int, typer.Option("-k", "--k0", help="Eigenfunctions in the sum of eq. (3); few give clear regions.")
    ] = SYMMETRY_K0,
    regions: Annotated[
        int | None, typer.Option("--regions", help="Number of regions, of equal area; 8 unless --epsilon is given.")
    ] = None,
    epsilon: Annotated[
        float | None, typer.Option("--epsilon", help="Width of a region instead: eq. (3) holds within each.")
    ] = None,
    reading: Annotated[
        Literal["absolute", "even", "printed"], typer.Option("--reading", help="How the sum of eq. (3) is read.")
    ] = "absolute",
    curvature_weight: Weight = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    smoothing: Smoothing = 0.0,
    method: Method = "graph",
    accuracy: Accuracy = 1e-3,
    workers: Workers = None,
    cache: Cache = True,
    output: Output = None,
    repair: Repair = None,
    force: Force = False,
    wrap: Wrap = False,
    pictures: Pictures = True,
    also: Also = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Find the map that swaps left and right, with sides and axis, and measure the self-symmetry of eq. (3).

    The options on the metric are those of eq. (3); the map is searched in the package's own metrics.

    result.npz: found, symmetry (n,), side (n,), asymmetry (n,), nearest (n,), symmetry_sum (n,), regions (n,),
    eigenvalues (k0,), eigenfunctions (n, k0), areas (n,), curve (k, 3) and curve_lengths: the points of the axis, line
    after line, and how many each has. plane in result.json: that of a shape that is its own mirror image in space.
    Where no symmetry was found, found is False, symmetry the identity, side 0 and asymmetry NaN.
    """
    from qgeo_filters.cli.in_turn import in_turn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters import stages
    from qgeo_filters.matching.prepared_shape import check_matchable
    from qgeo_filters.spectral.distance_spectrum import is_represented

    mend = repair_option(repair, force, wrap)
    parameters = {
        "map": explicit,
        "k0": k0,
        "regions": regions,
        "epsilon": epsilon,
        "reading": reading,
        "curvature_weight": curvature_weight,
        "scalar": scalar,
        "smoothing": smoothing,
        "method": method,
        "accuracy": accuracy,
        "repair": mend,
    }
    drawn = SYMMETRY_PICTURES if explicit else _PICTURES_OF_THE_MEASURE

    def one(mesh: Path, settings: Settings) -> None:
        job = Job("symmetry", settings, parameters, [mesh], pictures=drawn)
        (surface,) = job.read()
        found = None
        with job.about():
            if explicit:
                check_matchable(surface, repaired=job.repairs[0] is not None)
            stages.check_spectrum(surface, k0)
        # The matrix is held here: the stages after it find it, whatever the bound of the cache.
        with job.stage("distances"):
            metric = stages.metric_of(surface, scalar, curvature_weight, smoothing)
            small = not is_represented(surface, "auto")
            matrix = stages.matrix_of(metric, method, accuracy) if small else None
        with job.stage("spectrum"):
            spectrum = stages.spectrum_of(metric, k0, "area", "auto", method, accuracy)
        if explicit:
            with job.stage("map"):
                found = stages.symmetry_of(surface)
        with job.stage("measure"):
            results, arrays = symmetry_measure(spectrum, matrix, k0, regions, epsilon, reading)
        if found is not None:
            results = {**symmetry_results(found, spectrum, k0, reading), **results}
            arrays |= symmetry_arrays(found)
        described = surface.with_attributes(symmetry_attributes(arrays, found))
        per_vertex = {**arrays, "eigenfunctions": spectrum.eigenfunctions, "areas": spectrum.areas}
        saved = {
            name: job.on_given(values, vertices=name in ("symmetry", "nearest")) if name != "found" else values
            for name, values in per_vertex.items()
        }
        curve = {} if found is None else curve_arrays(found)
        job.save(
            results,
            {**saved, **curve, "eigenvalues": spectrum.eigenvalues},
            described,
            shown=[shown_symmetry(surface, arrays, found)],
            vertices=("qgeo_symmetry",),
        )
        draw_symmetry(job, surface, arrays, found)
        job.finish()

    in_turn(meshes, Settings(output, quiet, json, mend, pictures, also), one, "symmetry")


def symmetry_results(found: Symmetry, spectrum: Spectrum, k0: int, reading: Reading = "absolute") -> dict[str, Any]:
    """Numbers of a symmetry map for result.json; None where they have no meaning because none was found."""
    from qgeo_filters.matching.symmetry_measure import symmetry_epsilon

    return {
        "found": found.found,
        "reason": found.reason,
        "score": found.score if found.found else None,
        "orientation": found.orientation if found.found else None,
        "vertices_on_the_axis": int(found.fixed.sum()) if found.found else None,
        "plane": None
        if found.plane is None
        else {
            "normal": found.plane.normal.tolist(),
            "origin": found.plane.origin.tolist(),
            "deviation": found.plane.deviation,
        },
        # Not the involution: vertices that it pairs with themselves would flatter the measure.
        "epsilon_of_mirror_images": symmetry_epsilon(spectrum, found.nearest, k0, reading) if found.found else None,
    }


def curve_arrays(found: Symmetry) -> dict[str, Any]:
    """The axis of a symmetry for result.npz."""
    import numpy as np

    return {
        "curve": np.concatenate([np.zeros((0, 3)), *found.curve]),
        "curve_lengths": np.array([len(line) for line in found.curve], dtype=np.int64),
    }


def symmetry_arrays(found: Symmetry) -> dict[str, Any]:
    """Arrays of a symmetry map for result.npz."""
    import numpy as np

    return {
        "found": np.bool_(found.found),
        "symmetry": found.p2p,
        "nearest": found.nearest,
        "side": found.side.astype(np.int64),
        "asymmetry": found.asymmetry,
    }


def symmetry_attributes(arrays: dict[str, Any], found: Symmetry | None) -> dict[str, Any]:
    """Attributes for the mesh: those of eq. (3), and those of the map where one was found."""
    import numpy as np

    attributes = {"qgeo_symmetry_sum": arrays["symmetry_sum"], "qgeo_symmetry_region": arrays["regions"]}
    if found is not None and found.found:
        attributes |= {
            "qgeo_symmetry": found.p2p.astype(np.int32),
            "qgeo_side": found.side.astype(np.int32),
            "qgeo_asymmetry": found.asymmetry,
        }
    return attributes


def shown_symmetry(surface: Surface, arrays: dict[str, Any], found: Symmetry | None) -> Shown:
    """Mirror images in one colour, and the asymmetry; where no map was found, the regions and the sum of eq. (3)."""
    from qgeo_filters.report.shown import Shown, label_colors, mirror_colors
    from qgeo_filters.report.view import best_view

    if found is not None and found.found:
        view = best_view(surface.vertices, surface.faces)
        return Shown(mirror_colors(surface, found.nearest, view), found.asymmetry)
    regions = arrays["regions"]
    return Shown(label_colors(regions, int(regions.max(initial=-1)) + 1), arrays["symmetry_sum"])


def symmetry_measure(
    spectrum: Spectrum,
    matrix: np.ndarray | None,
    k0: int,
    n_regions: int | None = None,
    epsilon: float | None = None,
    reading: Reading = "absolute",
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers and arrays of eq. (3), its bound checked on random pairs of vertices where the matrix is at hand."""
    import numpy as np

    from qgeo_filters.matching.symmetry_measure import (
        epsilon_bound,
        symmetry_epsilon,
        symmetry_regions,
        symmetry_sum,
    )

    values = symmetry_sum(spectrum, k0, reading)
    regions = symmetry_regions(spectrum, n_regions, epsilon, k0, reading)
    share = None
    if matrix is not None:
        one, other = np.random.default_rng(0).integers(0, spectrum.n_vertices, (2, _PAIRS))
        one, other = one[one != other], other[one != other]
        bound = epsilon_bound(spectrum, matrix, one, other, k0)
        share = float((np.abs(values[one] - values[other]) / bound).max())
    results = {
        "k0": k0,
        "spectrum_from": spectrum.approximation or ALL_DISTANCES,
        "epsilon_of_all_pairs": symmetry_epsilon(spectrum, None, k0, reading),
        "regions": len(np.unique(regions)),
        "largest_share_of_the_bound": share,
    }
    return results, {"symmetry_sum": values, "regions": regions}


def draw_symmetry(job: Job, surface: Surface, arrays: dict[str, Any], found: Symmetry | None) -> None:
    """Pictures of the map, its sides and asymmetry where there is one, and of the regions of eq. (3)."""
    from qgeo_filters.report.colors import mirror_colors
    from qgeo_filters.report.figures import plot_scalar, plot_symmetry
    from qgeo_filters.report.maps import plot_sides
    from qgeo_filters.report.view import best_view
    from qgeo_filters.report.worst_places import plot_worst_places, worst_places

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
                colors=mirror_colors(surface.vertices, found.nearest, best_view(surface.vertices, surface.faces).axes),
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
