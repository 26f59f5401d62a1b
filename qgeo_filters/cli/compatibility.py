"""``qgeo compatibility``: whether the poses of a shape share one eigenspectrum, D(S) of eq. (5)."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
    Also,
    Force,
    Json,
    Output,
    Pictures,
    Quiet,
    Repair,
    Settings,
    Weight,
    Workers,
    Wrap,
    repair_option,
)
from qgeo_filters.cli.spectral import Count
from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS

_MOST_POSES = 12


def compatibility(
    meshes: Annotated[list[Path], typer.Argument(metavar="MESH...", help="Two poses or more.", show_default=False)],
    baselines: Annotated[
        tuple[int, int],
        typer.Option("--baselines", metavar="I J", help="The poses, from 0, that are optimised against each other."),
    ] = (0, 1),
    k: Count = EIGENPAIRS,
    curvature_weight: Weight = CURVATURE_WEIGHT,
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
    """Measure how far poses are from sharing one eigenspectrum: D(S), and C_XY of every two.

    Vertex i is the same point of all poses if they have the same faces; if not, the maps are found as by qgeo match.
    A pose that cannot be read or matched, and is no baseline, is named and left out.

    result.npz: d_s, c_xy (p, p), eigenvalues (p, k), index (p, k), signs (p, k), maps (p, n).
    """
    import numpy as np

    from qgeo_filters.cli.compatible_poses import compared
    from qgeo_filters.cli.in_turn import Batch
    from qgeo_filters.cli.job import Job
    from qgeo_filters.cli.job_text import as_title
    from qgeo_filters.matching.compatibility import compatibility_of_spectra
    from qgeo_filters.report.curves import plot_pairwise
    from qgeo_filters.report.html import Table
    from qgeo_filters.report.maps import plot_poses
    from qgeo_filters.report.shown import Shown, pose_colors
    from qgeo_filters.report.view import best_view

    mend = repair_option(repair, force, wrap)
    parameters = {"baselines": list(baselines), "k": k, "curvature_weight": curvature_weight, "repair": mend}
    settings = Settings(output, quiet, json, mend, pictures, also)
    called = [f"surfaces[{index}]" for index in range(len(meshes))]
    job = Job("compatibility", settings, parameters, meshes, names=called, pictures=("poses", "c_xy"))
    batch = Batch()
    good = compared(job, batch, baselines, k, curvature_weight, workers)
    poses, places = [pose.surface for pose in good], [pose.place for pose in good]
    kept = places.index(baselines[0]), places.index(baselines[1])
    with job.stage("compatibility"):
        found = compatibility_of_spectra([pose.spectrum for pose in good], [pose.image for pose in good], kept, k=k)
    first = found.baselines[0]
    arrays = {
        "d_s": np.float64(found.d_s),
        "c_xy": found.c_xy,
        "eigenvalues": found.eigenvalues,
        "index": found.index,
        "signs": found.signs,
        # For each vertex of the first baseline its vertex of each pose.
        "maps": np.stack([job.images_on_given(m, first, p) for p, m in enumerate(found.maps)]),
    }
    one_mesh = all(np.array_equal(image, np.arange(len(image))) for image in found.maps)
    pairs = found.c_xy[np.triu_indices(len(poses), 1)]
    results = {
        "d_s": found.d_s,
        "smallest_c_xy": float(pairs.min()),
        "largest_c_xy": float(pairs.max()),
        "c_xy_of_the_baselines": float(found.c_xy[found.baselines]),
        "maps": "equal vertex numbers" if one_mesh else "found by match",
        **batch.for_results(),
    }
    view = best_view(poses[first].vertices, poses[first].faces)
    colors = pose_colors([poses[first], *poses], [found.maps[first], *found.maps], view)[1:]
    job.save(results, arrays, *poses, shown=[Shown(of_pose) for of_pose in colors])
    names = [as_title(name) for name in job.names]
    shown = list(dict.fromkeys([found.baselines[0], *range(len(poses))]))[:_MOST_POSES]
    titles = [f"{names[p]} (baseline)" if p in found.baselines else names[p] for p in shown]
    job.picture(
        "poses",
        f"The set of poses, D(S) = {found.d_s:.3g} (paper, Fig. 7); colours are carried over from the first baseline "
        "along the maps on which the eigenfunctions are compared.",
        partial(plot_poses, [poses[p] for p in shown], [found.maps[p] for p in shown], names=titles),
    )
    job.picture(
        "c_xy",
        "C_XY of every two poses: 0 where they have the same eigenfunctions.",
        partial(plot_pairwise, found.c_xy, names, "C_XY (no unit)"),
    )
    rows = [(name, *map(float, row)) for name, row in zip(job.names, found.c_xy, strict=True)]
    job.finish([Table("C_XY", rows, ("", *job.names))] if len(poses) <= _MOST_POSES else [])
    batch.finish(len(meshes), "poses were left out")
