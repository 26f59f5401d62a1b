"""``qgeo demo``: the main job on a real mesh that comes with PyMeshLab, checked against exact geodesics."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import Json, Output, Quiet, Settings, Workers
from qgeo_filters.cli.symmetry import SYMMETRY_PICTURES
from qgeo_filters.defaults import EIGENPAIRS, SYMMETRY_K0
from qgeo_filters.errors import MissingPackageError

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters.surface import Surface

_SOURCES = 5
_PICTURES = ("eigenfunctions", "distance_matrix", *SYMMETRY_PICTURES, "distance_field", "scalar", "spectrum")


def demo(
    workers: Workers = None, cache: Cache = True, output: Output = None, json: Json = False, quiet: Quiet = False
) -> None:
    """Run everything on PyMeshLab's cow and compare distances with libigl's exact ones; needs no network.

    result.npz: distances (n, n), eigenvalues (k,), eigenfunctions (n, k), symmetry (n,), side (n,), asymmetry (n,),
    nearest (n,), symmetry_sum (n,), regions (n,).
    """
    import numpy as np

    import qgeo_filters as qg
    from qgeo_filters.caching import cache as stage_cache
    from qgeo_filters.cli.job import Job
    from qgeo_filters.cli.spectral import eigenvalue_table, spectrum_results
    from qgeo_filters.cli.symmetry_pictures import draw_symmetry, shown_symmetry
    from qgeo_filters.cli.symmetry_results import (
        symmetry_arrays,
        symmetry_attributes,
        symmetry_measure,
        symmetry_results,
    )
    from qgeo_filters.evaluation.errors import geodesic_error
    from qgeo_filters.filters import stages
    from qgeo_filters.geodesics.metric import cartesian_metric
    from qgeo_filters.report import figures
    from qgeo_filters.report.html import Table
    from qgeo_filters.report.view import best_view

    descriptor = qg.QuasiGeodesicSpectrum(k=EIGENPAIRS)
    pipeline = qg.DifferentialCoordinates() | qg.CorrectedNormals() | qg.SurfaceScalar() | descriptor
    parameters = {type(step).__name__: step.get_params() for step in pipeline.steps}
    job = Job("demo", Settings(output, quiet, json), parameters, [cow()], pictures=_PICTURES, about=())
    (surface,) = job.read()
    with stage_cache.held():  # the stages of the pipeline are asked for again below
        with job.stage("pipeline"):
            described = pipeline(surface)
        matrix = stages.matrix_of(descriptor.metric_, descriptor.method, descriptor.accuracy)
        with job.stage("distances of weight 0"):
            plain = stages.matrix_of(cartesian_metric(surface), "graph", 1e-3)
        with job.stage("symmetry"):
            found = stages.symmetry_of(surface)
    with job.stage("exact distances (libigl)"):
        errors = errors_against_exact(surface, plain)
    spectrum = descriptor.spectrum_
    with job.stage("symmetry measure"):
        measure, symmetric = symmetry_measure(spectrum, matrix, SYMMETRY_K0)
        measure = {**symmetry_results(found, spectrum, SYMMETRY_K0), **measure}
        symmetric |= symmetry_arrays(found)
        # The cow is modelled symmetric, which the search is not told: its map has a truth to be held against.
        measure["map_error_against_the_plane"] = float(
            geodesic_error(found.nearest, mirror_images(surface), surface).mean()
        )
    results = {
        **spectrum_results(spectrum),
        **measure,
        "matrix_is_symmetric": bool((matrix == matrix.T).all()),
        "mean_error_percent": float(np.mean([mean for _, mean, _ in errors])),
        "max_error_percent": max(largest for _, _, largest in errors),
    }
    arrays = {
        "distances": matrix,
        "eigenvalues": spectrum.eigenvalues,
        "eigenfunctions": spectrum.eigenfunctions,
        **symmetric,
    }
    shown = shown_symmetry(surface, symmetric, found)
    job.save(results, arrays, described.with_attributes(symmetry_attributes(symmetric, found)), shown=[shown])
    view = best_view(surface.vertices, surface.faces)
    job.picture(
        "eigenfunctions",
        "The first eigenfunctions of the quasi-geodesic distances, in units of 1/sqrt(area); the line is zero.",
        lambda: figures.plot_eigenfunctions(surface, spectrum, view=view),
    )
    job.picture(
        "distance_matrix",
        "The matrix of all quasi-geodesic distances (paper, Fig. 1), its rows in an order in which neighbours on the "
        "surface stay together; the strip's colours say where on the surface a row is.",
        lambda: figures.plot_distance_matrix(matrix, surface, view=view),
    )
    draw_symmetry(job, surface, symmetric, found)
    job.picture(
        "distance_field",
        "Quasi-geodesic distance from one vertex (red), with lines of equal distance.",
        lambda: figures.plot_distance_field(surface, matrix[errors[1][0]], errors[1][0]),
    )
    job.picture(
        "scalar",
        "The scalar that bends the metric: mean curvature without unit, clipped, of unit standard deviation.",
        lambda: figures.plot_scalar(surface, described.attributes["qgeo_scalar"], "f (no unit)", view=view),
    )
    job.picture("spectrum", "Eigenvalues by decreasing magnitude.", lambda: figures.plot_spectrum(spectrum.eigenvalues))
    comparison = Table(
        "Error of the matrix of weight 0 against libigl's exact geodesics",
        errors,
        ("source vertex", "mean error, %", "largest error, %"),
        "Relative, over all other vertices; the sources are spread over the surface.",
    )
    job.finish([comparison, eigenvalue_table(spectrum)])


def cow() -> Path:
    """File of the cow in PyMeshLab's wheel: 2904 vertices, closed, left/right symmetric.

    Raises
    ------
    MissingPackageError
        Without PyMeshLab, or with one that leaves its sample meshes out.
    """
    package = importlib.util.find_spec("pymeshlab")
    if package is None or package.origin is None:
        raise MissingPackageError(
            "qgeo demo needs pymeshlab, whose wheel brings the mesh: pip install 'qgeo-filters[meshlab]'"
        )
    path = Path(package.origin).parent / "tests" / "sample_meshes" / "cow.obj"
    if not path.is_file():
        raise MissingPackageError(
            f"qgeo demo needs {path}, which this build of pymeshlab lacks: pip install --force-reinstall pymeshlab"
        )
    return path


def mirror_images(surface: Surface) -> np.ndarray:
    """Vertex nearest to the mirror image of each vertex in the plane x = 0, which halves the cow, shape (n,)."""
    import numpy as np
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(surface.vertices).query(surface.vertices * [-1.0, 1.0, 1.0])[1])


def errors_against_exact(surface: Surface, matrix: np.ndarray) -> list[tuple[int, float, float]]:
    """Source vertex, mean and largest relative error in per cent, for a few rows of a matrix of weight 0."""
    import igl
    import numpy as np

    from qgeo_filters.sampling import farthest_by_distances

    vertices, faces = np.array(surface.vertices), surface.faces.astype(np.int64)
    nothing, everything = np.empty(0, np.int64), np.arange(surface.n_vertices)
    errors = []
    for source in farthest_by_distances(matrix, _SOURCES, int(matrix[0].argmax())).tolist():
        exact = igl.exact_geodesic(vertices, faces, np.array([source]), nothing, everything, nothing)
        others = everything != source
        relative = 100.0 * np.abs(matrix[source, others] - exact[others]) / exact[others]
        errors.append((source, float(relative.mean()), float(relative.max())))
    return errors
