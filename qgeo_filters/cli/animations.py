"""What commands share that make animations: the files that are written."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.animation.sequence import Animation
    from qgeo_filters.cli.job import Job

#: What is written where no other file is asked for.
SCENE = "animation.glb"

Animate = Annotated[
    list[str] | None,
    typer.Option(
        "--animate",
        metavar="NAME",
        help="File to write among the results: .glb (a scene with morph targets, which Blender, three.js and Windows "
        "play), .gif or .mp4. May be given several times; animation.glb if left out.",
        show_default=False,
    ),
]
Seconds = Annotated[
    float | None,
    typer.Option(
        "--seconds", help="How long the animation takes; a twelfth of a second a frame and at least two if left out."
    ),
]
Unsure = Annotated[
    bool, typer.Option("--accept-unsure", help="Go on, with a warning, where the correspondence is not sure.")
]


def animation_names(animate: Sequence[str] | None) -> list[str]:
    """Names of the files of the animation.

    Raises
    ------
    ParameterError
        A path rather than a name, or a kind that cannot be written.
    """
    from qgeo_filters.report.animation_file import checked_kind

    names = list(dict.fromkeys(animate or [SCENE]))
    for name in names:
        if Path(name).name != name:
            raise ParameterError(f"--animate takes a name among the results, got {name}: -o says in which folder")
        checked_kind(name)
    return names


def save_animation(
    job: Job, animation: Animation, files: Sequence[str], seconds: float | None, names: tuple[str, str], caption: str
) -> None:
    """Write the animation as each of the files, and its film strip."""
    from qgeo_filters.report.animation_file import write_animation
    from qgeo_filters.report.film import plot_film_strip

    for name in files:
        with job.stage(f"write {name}"), job.file(name) as temporary:
            write_animation(temporary, animation, seconds=seconds, names=names)
    job.picture("film_strip", caption, partial(plot_film_strip, animation, names=names))


def numbers(animation: Animation) -> dict[str, Any]:
    """Numbers of an animation for result.json."""
    from qgeo_filters.animation.measures import edge_changes, folded_edges

    changes = edge_changes(animation)
    return {
        "frames": len(animation),
        "mean_edge_change": float(changes.mean()),
        "largest_mean_edge_change": float(changes.max()),
        "folded_edges": sum(folded_edges(animation.surface, frame) for frame in animation.positions),
        **({"notes": list(animation.notes)} if animation.notes else {}),
    }
