"""``qgeo transfer``: the poses of one shape on another, with no markers."""

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

_NO_RESULT = "poses have no results"


def transfer(
    reference: Annotated[
        Path, typer.Argument(metavar="X", help="X at rest; of a folder the first mesh.", show_default=False)
    ],
    onto: Annotated[
        Path, typer.Option("--onto", metavar="Y", help="Y at rest; of a folder the first mesh.", show_default=False)
    ],
    poses: Annotated[
        list[Path] | None,
        typer.Argument(metavar="POSE...", help="Poses of X, files or folders; of a folder X its other meshes."),
    ] = None,
    scans: Annotated[
        bool, typer.Option("--scans", help="Poses in any triangulation: each is matched with X at rest first.")
    ] = False,
    same_pose: Annotated[
        bool,
        typer.Option("--same-pose/--other-pose", help="Whether X and Y at rest stand alike, or Y is to stand as X."),
    ] = True,
    same_body: Annotated[
        bool, typer.Option("--same-body", help="With --other-pose: X and Y are one body, of one shape.")
    ] = False,
    align: Annotated[
        bool,
        typer.Option("--align/--no-align", help="Fit turn, size and position of X to Y, or leave them."),
    ] = True,
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
    """Move Y as X is moved: deformation transfer along a correspondence that is found, not given.

    Where it is not sure nothing is moved: look at it with qgeo match, and give a few landmarks with --hints (the end
    of the tail, the nose, a foot), or go on with --accept-unsure.

    Y_POSE.ply: Y in each pose, written as it is finished; a pose that cannot be read or does not fit is named, and the
    others go on. result.npz: positions (k, n_Y, 3), and corners (n_Y, 3) and
    coordinates (n_Y, 3), the point of X for each vertex of Y. animation.glb: both shapes, playing.
    """
    import numpy as np

    from qgeo_filters.animation.places import warned
    from qgeo_filters.animation.pose_transfer import PoseTransfer
    from qgeo_filters.animation.poses import given_pose
    from qgeo_filters.animation.scans import ScanFollower
    from qgeo_filters.animation.sequence import Animation
    from qgeo_filters.cli import animations
    from qgeo_filters.cli.in_turn import Batch
    from qgeo_filters.cli.job import Job
    from qgeo_filters.cli.job_text import as_title, numbered
    from qgeo_filters.filters import stages
    from qgeo_filters.io.folders import mesh_files
    from qgeo_filters.io.hint_files import read_hints
    from qgeo_filters.matching import hints as known
    from qgeo_filters.report.reel import transfer_colors
    from qgeo_filters.report.shown import Shown

    mend = repair_option(repair, force, wrap)
    first, *others = mesh_files(reference)
    files = [file for path in poses or () for file in mesh_files(path)] or others
    if not files:
        raise ParameterError("no poses: name their files, a folder of them, or as X a folder that holds them too")
    names = animations.animation_names(animate)
    y_file = mesh_files(onto)[0]
    frames = numbered([f"{y_file.stem}_{file.stem}" for file in files])
    parameters: dict[str, Any] = {
        "poses": [str(file) for file in files],
        "scans": scans,
        "same_pose": same_pose,
        "same_body": same_body,
        "align": align,
        "hints": hints and [str(file) for file in hints],
        "frame": frame,
        "accept_unsure": unsure,
        "seconds": seconds,
        "repair": mend,
    }
    settings = Settings(output, quiet, json, mend, pictures, also)
    job = Job(
        "transfer",
        settings,
        parameters,
        [first, y_file],
        names=("X", "Y"),
        inputs=[*files, *(hints or ())],
        pictures=("film_strip",),
        texts=names,
        meshes_made=frames,
    )
    x, y = job.read_given()
    landmarks = known.Hints.of(x, y, read_hints(hints, frame)).landmarks if hints else None
    with job.stage("correspondence"):
        found = stages.correspondence_of(x, y, True, repair_x=mend, repair_y=mend, landmarks=landmarks)
    for index, name in enumerate(("X: ", "Y: ")):
        job.repaired(index, [line.removeprefix(name) for line in found.repairs if line.startswith(name)])
    with job.stage("prepare"):
        plan = PoseTransfer.of(x, y, found, same_pose=same_pose, same_body=same_body, align=align, accept_unsure=unsure)
    colors = transfer_colors(x, plan.places.on_x)
    batch, followed, moved = Batch(), [], []
    with job.stage("poses"):
        warned(plan.doubts)
        follower = ScanFollower(x, unsure, mend) if scans else None
        for file, name in zip(files, frames, strict=True):
            with batch.trying(file):
                pose = follower(file, str(file)) if follower else given_pose(x, file)
                positions = plan.moved(pose)
                displacement = np.linalg.norm(positions - y.vertices, axis=1)
                job.write_meshes({name: Shown(colors[1], displacement).on(y.with_vertices(positions))})
                followed.append(plan.frame(pose))
                moved.append(positions)
    if not moved:
        batch.finish(len(files), _NO_RESULT)
    result = plan.result(followed, moved)
    arrays = {
        "positions": result.positions,
        "corners": plan.places.on_x.corners,
        "coordinates": plan.places.on_x.coordinates,
    }
    of_x = animations.numbers(Animation(plan.aligned_x, np.stack(followed)))
    numbers = {"apart": result.apart, "mean_edge_change_of_x": of_x["mean_edge_change"], **animations.numbers(result)}
    job.save(
        {**numbers, "confident": found.confident, "score": found.score, **batch.for_results()},
        arrays,
        x,
        y,
        shown=[Shown(of) for of in colors],
    )
    called = (as_title(job.names[0]), as_title(job.names[1]))
    caption = "Some of the poses of X, and Y moved as they are; what belongs together has one colour."
    animations.save_animation(job, result, names, seconds, called, caption)
    job.finish()
    batch.finish(len(files), _NO_RESULT)
