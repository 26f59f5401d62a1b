"""``qgeo symmetry``: the map of a shape to itself that swaps left and right, beside the paper's measure, eq. (3)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
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
    from qgeo_filters.cli.symmetry_pictures import draw_symmetry, shown_symmetry
    from qgeo_filters.cli.symmetry_results import (
        curve_arrays,
        symmetry_arrays,
        symmetry_attributes,
        symmetry_measure,
        symmetry_results,
    )
    from qgeo_filters.filters import stages
    from qgeo_filters.matching.matchable import check_matchable
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
