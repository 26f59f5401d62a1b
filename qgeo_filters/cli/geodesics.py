"""``qgeo distances`` and ``qgeo path``: how far it is over the surface, and which way."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
    Accuracy,
    Also,
    Force,
    Json,
    MeshFile,
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
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    import numpy as np

LARGEST_MATRIX = 8 << 30  # bytes
# Rows of a matrix that are looked at together.
ROWS = 1024
# Sources whose distances are drawn.
_FIELDS = 6


def distances(
    meshes: MeshFiles,
    sources: Annotated[
        str, typer.Option("-s", "--sources", metavar="VERTICES", help="Measure from these only, as 0,17,42.")
    ] = "",
    matrix: Annotated[
        Path | None,
        typer.Option(
            "--matrix",
            metavar="FILE.zarr",
            help="Write all pairs there, a matrix of any size; the same command continues an interrupted one.",
            show_default=False,
        ),
    ] = None,
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
    """Measure distances over the surface, between all pairs of vertices or from chosen ones.

    result.npz: distances, (n, n) float32, or (s, n) float64 with sources (s,). With --matrix the distances are there, a
    Zarr array of float32, and result.npz has mean_distance (n,); of a mesh that was repaired the matrix has the
    repaired vertices, and vertex_of_original (n,) tells which stands for each of the file's, -1 if none.
    """
    import numpy as np

    from qgeo_filters.cli.in_turn import in_turn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters import stages
    from qgeo_filters.geodesics.matrix import distance_matrix
    from qgeo_filters.geodesics.matrix import distances as distances_from
    from qgeo_filters.report.figures import plot_distance_field, plot_distance_matrix, plot_scalar
    from qgeo_filters.report.shown import Shown

    chosen = _indices(sources)
    mend = repair_option(repair, force, wrap)
    parameters = {
        "sources": chosen or "all",
        "matrix": matrix,
        "curvature_weight": curvature_weight,
        "scalar": scalar,
        "smoothing": smoothing,
        "method": method,
        "accuracy": accuracy,
        "repair": mend,
    }
    if matrix is not None and (len(meshes) > 1 or meshes[0].is_dir()):
        raise ParameterError("--matrix is the file of one mesh: name no more, and no folder")
    if chosen and matrix is not None:
        raise ParameterError("--matrix holds the distances between all pairs: leave out --sources, or --matrix")
    drawn = [f"distance_{vertex}" for vertex in chosen[:_FIELDS]] or ["distance_matrix", "mean_distance"]

    def one(mesh: Path, settings: Settings) -> None:
        job = Job(
            "distances",
            settings,
            parameters,
            [mesh],
            inputs=[] if matrix is None else [matrix],
            pictures=drawn,
        )
        (surface,) = job.read("all")
        n = surface.n_vertices
        if chosen:
            with job.about():
                there = job.vertices(chosen, "sources")
        elif matrix is None and 4 * n * n > LARGEST_MATRIX:
            raise ParameterError(
                f"all pairs of {n} vertices would take {4e-9 * n * n:.0f} GB of memory; choose vertices with "
                "--sources, or write the matrix to disk with --matrix FILE.zarr"
            )
        with job.stage("metric"):
            metric = stages.metric_of(surface, scalar, curvature_weight, smoothing)
        field: Any  # an array, or one on disk
        with job.stage("distances"):
            if chosen:
                field = distances_from(surface, there, metric, method, accuracy=accuracy)
            elif matrix is None:
                field = stages.matrix_of(metric, method, accuracy)
            else:
                field = distance_matrix(surface, metric, method, accuracy=accuracy, out=matrix)
        results, centrality = _measured(field)
        if matrix is None:
            given = job.on_given(field, axis=1)
            arrays = {"distances": given if chosen else job.on_given(given)}
            results["shape"] = list(arrays["distances"].shape)  # of what is saved, not of what was measured
        else:
            arrays = {"mean_distance": job.on_given(centrality)}
            if job.repairs[0] is not None:  # rows and columns of the matrix are the repaired mesh's
                arrays["vertex_of_original"] = job.repairs[0].vertex_of_original
        if chosen:
            attributes = {"qgeo_distance": field[0] if len(chosen) == 1 else field.T}
            arrays["sources"] = np.array(chosen)
        else:
            attributes = {"qgeo_mean_distance": centrality}
        shown = Shown.of_values(field.min(axis=0) if chosen else centrality)
        job.save(results, arrays, surface.with_attributes(attributes), shown=[shown])
        for index, vertex in enumerate(chosen[:_FIELDS]):
            job.picture(
                f"distance_{vertex}",
                f"Distance from vertex {vertex} (red), with lines of equal distance.",
                partial(plot_distance_field, surface, field[index], there[index]),
            )
        if not chosen and matrix is None:
            job.picture(
                "distance_matrix",
                "The matrix of all distances (paper, Fig. 1), its rows in an order in which neighbours on the surface "
                "stay together; the strip's colours say where on the surface a row is.",
                lambda: plot_distance_matrix(field, surface),
            )
        if not chosen:
            job.picture(
                "mean_distance",
                "Mean distance of each vertex to all others: small in the middle of the shape, large at its ends.",
                lambda: plot_scalar(surface, centrality, "mean distance (mesh units)"),
            )
        job.finish()

    in_turn(meshes, Settings(output, quiet, json, mend, pictures, also), one, "distances")


def _measured(field: Any) -> tuple[dict[str, Any], np.ndarray]:
    """Numbers for result.json, and the mean distance in each row, over what can be reached."""
    import numpy as np

    count = field.shape[0]  # an array on disk has no len
    total, reached = np.empty(count), np.empty(count, dtype=np.int64)
    largest = 0.0
    for first in range(0, count, ROWS):
        rows = np.asarray(field[first : first + ROWS])
        finite = np.isfinite(rows)
        part = slice(first, first + len(rows))
        total[part] = rows.sum(axis=1, dtype=np.float64, where=finite)
        reached[part] = finite.sum(axis=1)
        largest = max(largest, float(rows.max(initial=0.0, where=finite)))
    results = {
        "shape": list(field.shape),
        "mean": float(total.sum() / reached.sum()),
        "max": largest,
        "unreachable_pairs": int(np.prod(field.shape) - reached.sum()),
    }
    return results, total / np.maximum(reached, 1)


def _indices(text: str) -> list[int]:
    """Vertices of a list like "0,17,42"."""
    try:
        return [int(part) for part in text.split(",")] if text else []
    except ValueError:
        raise ParameterError(
            f"--sources must be vertex numbers with commas between, as 0,17,42, got {text!r}"
        ) from None


def path(
    mesh: MeshFile,
    i: Annotated[int, typer.Argument(metavar="I", help="Vertex at the start, from 0.", show_default=False)],
    j: Annotated[int, typer.Argument(metavar="J", help="Vertex at the end.", show_default=False)],
    curvature_weight: Weight = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    smoothing: Smoothing = 0.0,
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
    """Find the straightest way over the surface between two vertices, with its geodesic curvature.

    result.npz: points (p, 3), length, kappa_g (p - 2,) and both angles in radians, faces (p,), barycentric (p, 3).
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters import stages
    from qgeo_filters.geodesics.path.paths import quasi_geodesic
    from qgeo_filters.report.colors import MISSING
    from qgeo_filters.report.figures import MARK, plot_path, plot_path_curvature
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.validation import checked_index

    mend = repair_option(repair, force, wrap)
    parameters = {
        "i": i,
        "j": j,
        "curvature_weight": curvature_weight,
        "scalar": scalar,
        "smoothing": smoothing,
        "repair": mend,
    }
    settings = Settings(output, quiet, json, mend, pictures, also)
    about = [mesh.stem, str(i), str(j)]
    job = Job("path", settings, parameters, [mesh], pictures=("path", "path_curvature"), about=about)
    (surface,) = job.read("all")
    with job.about():
        for vertex, name in ((i, "I"), (j, "J")):
            checked_index(vertex, job.given_vertices(), name)
        (start,), (end,) = job.vertices([i], "I"), job.vertices([j], "J")
    with job.stage("metric"):
        metric = stages.metric_of(surface, scalar, curvature_weight, smoothing)
    with job.stage("path"):
        found = quasi_geodesic(surface, start, end, metric)
    kappa = np.asarray(found.kappa_g)
    results = {
        "length": float(found.length),
        "points": len(found.points),
        "largest_kappa_g": float(np.nanmax(np.abs(kappa), initial=0.0)),
        "converged": bool(found.converged),
    }
    faces: np.ndarray = found.faces
    weights, mended = found.barycentric, job.repairs[0]
    if mended is not None:
        there = mended.places_on_given(BarycentricMap(faces, surface.faces[faces].astype(np.int64), weights))
        faces, weights = there.faces, there.coordinates
    beside = np.zeros(surface.n_vertices, dtype=np.int32)
    beside[surface.faces[found.faces]] = 1
    arrays = {
        "points": found.points,
        "length": np.float64(found.length),
        "kappa_g": kappa,
        "left_angle": found.left_angle,
        "right_angle": found.right_angle,
        "faces": faces,
        "barycentric": weights,
    }
    shown = Shown(np.where(beside[:, None] == 1, MARK, MISSING), beside.astype(np.float64))
    job.save(results, arrays, surface.with_attributes({"qgeo_path": beside}), shown=[shown])
    job.picture("path", f"The path from vertex {i} (yellow) to vertex {j} (red).", lambda: plot_path(surface, found))
    job.picture(
        "path_curvature",
        "Discrete geodesic curvature (paper, eq. 1) at every edge and vertex that the path crosses: zero where it is "
        "straight, not zero only where it bends around a vertex that no shorter way avoids.",
        lambda: plot_path_curvature(found),
    )
    job.finish()
