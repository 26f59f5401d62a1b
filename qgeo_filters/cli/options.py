"""Arguments and options that several commands share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from qgeo_filters._typing import RepairOption

#: What results say of a spectrum that nothing stands in for.
ALL_DISTANCES = "all distances"

_FORMATS = "OFF, OBJ, PLY, STL, GLB, MAT, TOSCA's .vert/.tri; with their extras VTK, Gmsh, GIFTI, FreeSurfer."

MeshFile = Annotated[Path, typer.Argument(metavar="MESH", help=_FORMATS, show_default=False)]
MeshFiles = Annotated[
    list[Path],
    typer.Argument(
        metavar="MESH...",
        help=f"{_FORMATS} Several, or a folder: each has its own results; what is bad is named, the rest goes on, and "
        "the exit code is 1.",
        show_default=False,
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="DIR",
        help="Folder for the results, made if missing; qgeo-out/COMMAND-MESH if left out. The same command on the "
        "same mesh replaces its results there. No file of yours is replaced.",
        show_default=False,
    ),
]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print result.json instead of the table.")]
Repair = Annotated[
    bool | None,
    typer.Option(
        "--repair/--no-repair",
        help="Make the mesh manifold and one piece first, or refuse what is not; if left out, repair what is wrong. "
        "The report says what changed; results are on the vertices of the file.",
        show_default=False,
    ),
]
Force = Annotated[
    bool, typer.Option("--force-repair", help="Repair even where more than a hundredth of the area is removed by it.")
]
Wrap = Annotated[
    bool,
    typer.Option(
        "--wrap",
        help="Work on a closed surface around each mesh: for raw CT and models in many pieces, which are refused "
        "otherwise. Results are on the vertices of the file, -1 or NaN deep inside.",
    ),
]
Pictures = Annotated[bool, typer.Option("--pictures/--no-pictures", help="Write PNG pictures.")]
#: Suffixes of the files as which a mesh is written beside PLY, for --also.
ALSO = ("vtp", "vtu", "glb", "csv", "obj")


def _also(given: list[str] | None) -> list[str]:
    """The suffixes, each once, of "vtp,glb" and the like."""
    suffixes = [part.strip().lower().removeprefix(".") for text in given or () for part in text.split(",")]
    for suffix in suffixes:
        if suffix not in ALSO:
            raise typer.BadParameter(f"{suffix!r} is none of {', '.join(ALSO)}")
    return list(dict.fromkeys(suffixes))


Also = Annotated[
    list[str] | None,
    typer.Option(
        "--also",
        metavar="vtp,vtu,glb,csv,obj",
        help="Write each mesh, beside PLY, as these too: .vtp or .vtu for ParaView, .glb for Blender and browsers, "
        ".csv with a row for each vertex, .obj; commas between.",
        callback=_also,
        show_default=False,
    ),
]
Hints = Annotated[
    list[Path] | None,
    typer.Option(
        "--hints",
        metavar="FILE",
        help="What is roughly known, and steers the search: a vertex of X and one of Y a line, from 0; or, given "
        "twice, landmarks on X and on Y, of which those of equal names belong together.",
    ),
]
HintsFrame = Annotated[
    Literal["RAS", "LPS"] | None,
    typer.Option("--frame", help="Frame of the meshes: landmarks that say they are in the other one are turned."),
]
Scalar = Annotated[
    str, typer.Option("--scalar", help="Curvature that bends the metric, or the name of an attribute of the mesh.")
]
Weight = Annotated[
    float,
    typer.Option(
        "-w", "--curvature-weight", help="lambda, a fraction of sqrt(area) per standard deviation; 0: plain geodesics."
    ),
]
Smoothing = Annotated[float, typer.Option("--smoothing", help="Averages the scalar over this fraction of sqrt(area).")]
Method = Annotated[
    Literal["graph", "exact", "edges"],
    typer.Option("--method", help="Near-exact and fast, exact, or Dijkstra on edges (for comparison)."),
]
Accuracy = Annotated[float, typer.Option("--accuracy", help="Relative error bound of the graph method.")]


def _bounded(context: typer.Context, workers: int | None) -> int | None:
    """Bound the threads of everything that the command does."""
    if workers is not None:
        from qgeo_filters.parallel import default_workers

        context.with_resource(default_workers(workers))
    return workers


Workers = Annotated[
    int | None,
    typer.Option(
        "--threads",
        "--workers",
        metavar="N",
        help="Threads at most; all cores that it may use if left out. Results do not depend on it.",
        callback=_bounded,
        show_default=False,
    ),
]


def repair_option(repair: bool | None, force: bool, wrap: bool = False) -> RepairOption:
    """What ``--repair``, ``--force-repair`` and ``--wrap`` ask for together, or leave to the command."""
    if wrap:
        if force or repair is not None:
            raise typer.BadParameter("--wrap is instead of --repair, --no-repair and --force-repair")
        return "wrap"
    return "force" if force else "auto" if repair is None else repair


@dataclass(frozen=True)
class Settings:
    """What a command is asked to do with its results."""

    output: Path | None = None
    quiet: bool = False
    json: bool = False
    repair: RepairOption = "auto"
    pictures: bool = True
    also: Sequence[str] | None = None
