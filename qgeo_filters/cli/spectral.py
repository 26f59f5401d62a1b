"""``qgeo spectrum``: the eigenfunctions of all distances."""

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
from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.spectral.distance_spectrum import Landmarks

Count = Annotated[int, typer.Option("-k", help="Number of eigenpairs.")]
MassName = Annotated[
    Literal["area", "uniform"],
    typer.Option(
        "--mass", "--weights", help="Eigenproblem of the integral operator, or of the plain matrix (paper, eq. 2)."
    ),
]
LandmarksText = Annotated[
    str,
    typer.Option(
        "--landmarks",
        metavar="auto|all|NUMBER",
        help="Farthest points that stand for all; auto: a proxy stands for meshes of more than 12,000 vertices.",
    ),
]


def spectrum(
    meshes: MeshFiles,
    k: Count = EIGENPAIRS,
    curvature_weight: Weight = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    smoothing: Smoothing = 0.0,
    mass: MassName = "area",
    landmarks: LandmarksText = "auto",
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
    """Compute the eigenvalues and eigenfunctions of all quasi-geodesic distances.

    result.npz: eigenvalues (k,), eigenfunctions (n, k), areas (n,).
    """
    from qgeo_filters.cli.in_turn import in_turn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.spectral import QuasiGeodesicSpectrum
    from qgeo_filters.report.figures import plot_eigenfunctions, plot_spectrum
    from qgeo_filters.report.shown import Shown

    descriptor = QuasiGeodesicSpectrum(
        k=k,
        scalar=scalar,
        curvature_weight=curvature_weight,
        mass=mass,
        landmarks=_landmarks(landmarks),
        smoothing=smoothing,
        method=method,
        accuracy=accuracy,
    )
    mend = repair_option(repair, force, wrap)

    def one(mesh: Path, settings: Settings) -> None:
        job = Job(
            "spectrum",
            settings,
            {**descriptor.get_params(), "repair": mend},
            [mesh],
            pictures=("eigenfunctions", "spectrum"),
        )
        (surface,) = job.read()
        with job.stage("spectrum"):
            described = descriptor.apply(surface)
        found = descriptor.spectrum_
        arrays = {
            "eigenvalues": found.eigenvalues,
            "eigenfunctions": job.on_given(found.eigenfunctions),
            "areas": job.on_given(found.areas),
        }
        # The second, which tells the ends of the shape apart: the first hardly varies.
        shown = Shown.of_values(found.eigenfunctions[:, min(1, k - 1)])
        job.save(spectrum_results(found), arrays, described, shown=[shown])
        job.picture(
            "eigenfunctions",
            "The first eigenfunctions of the distances on the surface, in units of 1/sqrt(area); the line is zero.",
            lambda: plot_eigenfunctions(surface, found),
        )
        job.picture("spectrum", "Eigenvalues by decreasing magnitude.", lambda: plot_spectrum(found.eigenvalues))
        job.finish([eigenvalue_table(found)])

    in_turn(meshes, Settings(output, quiet, json, mend, pictures, also), one, "spectrum")


def _landmarks(text: str) -> Landmarks:
    """What the option says, as the argument of `distance_spectrum`."""
    if text in ("auto", "all"):
        return None if text == "all" else "auto"
    try:
        return int(text)
    except ValueError:
        raise ParameterError(f"--landmarks must be auto, all or a number, got {text!r}") from None


def spectrum_results(found: Any) -> dict[str, Any]:
    """Numbers of a spectrum for result.json."""
    return {
        "from": found.approximation or ALL_DISTANCES,
        "eigenvalues": found.eigenvalues.tolist(),
        "positive_eigenvalues": int((found.eigenvalues > 0).sum()),
        # Numbered from 1, as in the table and the pictures.
        "multiplets": [[index + 1 for index in group] for group in found.multiplets if len(group) > 1],
    }


def eigenvalue_table(found: Any) -> Any:
    """Table of the eigenvalues for the report."""
    from qgeo_filters.report.html import Table

    first = abs(float(found.eigenvalues[0]))
    rows = [(index, float(value), abs(float(value)) / first) for index, value in enumerate(found.eigenvalues, start=1)]
    return Table("Eigenvalues", rows, ("k", "γ", "|γ| / |γ₁|"), "By decreasing magnitude.")
