"""``qgeo interpolate``: the way from one pose of a shape to another, and through several."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from qgeo_filters.cli.animations import Animate, Seconds, Unsure
from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
    Also,
    Force,
    Hints,
    HintsFrame,
    Json,
    Output,
    Pictures,
    Quiet,
    Repair,
    Settings,
    Workers,
    Wrap,
    repair_option,
)
from qgeo_filters.errors import ParameterError


def interpolate(
    x: Annotated[Path, typer.Argument(metavar="X", help="Where the way begins.", show_default=False)],
    poses: Annotated[
        list[Path], typer.Argument(metavar="Y...", help="Where it goes, files or folders.", show_default=False)
    ],
    frames: Annotated[int, typer.Option("--frames", min=2, help="Number of frames, both ends included.")] = 25,
    hints: Hints = None,
    frame: HintsFrame = None,
    unsure: Unsure = False,
    animate: Animate = None,
    seconds: Seconds = None,
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
    """Go from X to Y, or on through several poses, as rigid as possible at every moment.

    A pose with the triangles of X corresponds vertex by vertex; any other is matched, with no initial map. Where that
    is not sure, give a few landmarks with --hints, or go on with --accept-unsure.

    result.npz: positions (k, n_X, 3), times (k,): 0 is X, 1 the first Y. animation.glb: the shape, playing.
    """
    import numpy as np

    from qgeo_filters.animation.interpolate import interpolate as interpolated
    from qgeo_filters.animation.poses import same_triangles
    from qgeo_filters.cli import animations
    from qgeo_filters.cli.job import Job
    from qgeo_filters.cli.job_text import as_title
    from qgeo_filters.filters import stages
    from qgeo_filters.io.folders import mesh_files
    from qgeo_filters.io.hint_files import read_hints
    from qgeo_filters.matching import hints as known
    from qgeo_filters.report.colors import position_colors
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.report.view import best_view

    mend = repair_option(repair, force, wrap)
    files = [file for path in poses for file in mesh_files(path)]
    names = animations.animation_names(animate)
    parameters: dict[str, Any] = {
        "frames": frames,
        "hints": hints and [str(file) for file in hints],
        "frame": frame,
        "accept_unsure": unsure,
        "seconds": seconds,
        "repair": mend,
    }
    if hints and len(files) > 1:
        raise ParameterError(f"--hints are those of one pose, and there are {len(files)}")
    called = ("X", *(f"pose {number}" for number in range(len(files))))
    settings = Settings(output, quiet, json, mend, pictures, also)
    job = Job(
        "interpolate",
        settings,
        parameters,
        [x, *files],
        names=called,
        inputs=hints or (),
        pictures=("film_strip",),
        texts=tuple(names),
    )
    start, *ends = job.read_given()
    landmarks = known.Hints.of(start, ends[0], read_hints(hints, frame)).landmarks if hints else None
    if hints and same_triangles(start, ends[0]):
        raise ParameterError("--hints are not needed: Y has the triangles of X, and corresponds vertex by vertex")
    maps = []
    for end in ends:
        with job.stage("correspondence"):
            found = None
            if not same_triangles(start, end):
                found = stages.correspondence_of(start, end, True, repair_x=mend, repair_y=mend, landmarks=landmarks)
            maps.append(found)
    with job.stage("frames"):
        times = np.linspace(0, len(ends), frames)
        given = maps if len(maps) > 1 else maps[0]
        result = interpolated(start, ends, times, given, accept_unsure=unsure)
    colors = position_colors(start.vertices, best_view(start.vertices, start.faces).axes)
    # A pose with the triangles of X has its colours; on another they are carried over.
    of_ends = [colors if found is None else found.transfer(colors) for found in maps]
    arrays = {"positions": result.positions, "times": result.times}
    job.save(animations.numbers(result), arrays, start, *ends, shown=[Shown(of) for of in (colors, *of_ends)])
    shown = (as_title(job.names[0]), as_title(job.names[0]))
    animations.save_animation(job, result, names, seconds, shown, "Some of the frames, with their times.")
    job.finish()
