"""``qgeo symmetry``: the paper's measure of self-symmetry, eq. (3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from qgeo_filters.cli.options import (
    DEFAULT_OUTPUT,
    Accuracy,
    Json,
    MeshFile,
    Method,
    Output,
    Pictures,
    Quiet,
    Repair,
    Scalar,
    Settings,
    Smoothing,
    Weight,
)

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.spectral.distance_spectrum import Spectrum
    from qgeo_filters.surface import Surface

_PAIRS = 2000


def symmetry(
    mesh: MeshFile,
    k0: Annotated[int, typer.Option("-k", "--k0", help="Eigenfunctions in the sum; few give clear regions.")] = 6,
    regions: Annotated[
        int | None, typer.Option("--regions", help="Number of regions, of equal area; 8 unless --epsilon is given.")
    ] = None,
    epsilon: Annotated[
        float | None, typer.Option("--epsilon", help="Width of a region instead: eq. (3) holds within each.")
    ] = None,
    reading: Annotated[
        Literal["absolute", "even", "printed"], typer.Option("--reading", help="How the sum of eq. (3) is read.")
    ] = "absolute",
    curvature_weight: Weight = 0.03,
    scalar: Scalar = "mean_curvature",
    smoothing: Smoothing = 0.0,
    method: Method = "graph",
    accuracy: Accuracy = 1e-3,
    output: Output = DEFAULT_OUTPUT,
    repair: Repair = False,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure the self-symmetry of eq. (3) and the regions that it yields.

    result.npz: symmetry_sum (n,), regions (n,), eigenvalues (k0,), eigenfunctions (n, k0), areas (n,).
    """
    from qgeo_filters.caching import cache
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters import stages

    parameters = {
        "k0": k0,
        "regions": regions,
        "epsilon": epsilon,
        "reading": reading,
        "curvature_weight": curvature_weight,
        "scalar": scalar,
        "smoothing": smoothing,
        "method": method,
        "accuracy": accuracy,
        "repair": repair,
    }
    job = Job("symmetry", Settings(output, quiet, json, repair, pictures), parameters)
    surface = job.read(mesh)
    with cache.held():
        with job.stage("spectrum"):
            metric = stages.metric_of(surface, scalar, curvature_weight, smoothing)
            spectrum = stages.spectrum_of(metric, k0, "area", None, method, accuracy, job.progress)
        matrix = stages.matrix_of(metric, method, accuracy)
    with job.stage("symmetry"):
        results, arrays = symmetry_measure(spectrum, matrix, k0, regions, epsilon, reading)
    attributes = {"qgeo_symmetry_sum": arrays["symmetry_sum"], "qgeo_symmetry_region": arrays["regions"]}
    arrays |= {
        "eigenvalues": spectrum.eigenvalues,
        "eigenfunctions": spectrum.eigenfunctions,
        "areas": spectrum.areas,
    }
    job.save(results, arrays, surface.with_attributes(attributes))
    draw_symmetry(job, surface, arrays)
    job.finish()


def symmetry_measure(
    spectrum: Spectrum,
    matrix: np.ndarray,
    k0: int,
    n_regions: int | None = None,
    epsilon: float | None = None,
    reading: Literal["absolute", "even", "printed"] = "absolute",
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers and arrays of eq. (3), its bound checked on random pairs of vertices."""
    import numpy as np

    from qgeo_filters.matching.symmetry_measure import (
        epsilon_bound,
        symmetry_epsilon,
        symmetry_regions,
        symmetry_sum,
    )

    values = symmetry_sum(spectrum, k0, reading)
    regions = symmetry_regions(spectrum, n_regions, epsilon, k0, reading)
    one, other = np.random.default_rng(0).integers(0, spectrum.n_vertices, (2, _PAIRS))
    one, other = one[one != other], other[one != other]
    bound = epsilon_bound(spectrum, matrix, one, other, k0)
    results = {
        "epsilon_of_all_pairs": symmetry_epsilon(spectrum, None, k0, reading),
        "regions": len(np.unique(regions)),
        "largest_share_of_the_bound": float((np.abs(values[one] - values[other]) / bound).max()),
    }
    return results, {"symmetry_sum": values, "regions": regions}


def draw_symmetry(job: Job, surface: Surface, arrays: dict[str, Any]) -> None:
    """Pictures of the regions and of the function that they are bands of."""
    from qgeo_filters.report.figures import plot_scalar, plot_symmetry

    job.picture(
        "symmetry",
        "Regions of equal colour from both sides (paper, Fig. 5): symmetric points have one colour. So may others: the "
        "measure of eq. (3) refutes a symmetry, it does not establish one.",
        lambda: plot_symmetry(surface, arrays["regions"]),
    )
    job.picture(
        "symmetry_sum",
        "The sum of eq. (3), whose bands the regions are: equal at symmetric points.",
        lambda: plot_scalar(surface, arrays["symmetry_sum"], "sum of eq. (3) (no unit)"),
    )
