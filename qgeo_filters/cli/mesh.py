"""``qgeo info``: what a mesh is and what is wrong with it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from qgeo_filters.cli.options import (
    Also,
    Force,
    Json,
    MeshFiles,
    Output,
    Pictures,
    Quiet,
    Settings,
    Wrap,
    repair_option,
)

if TYPE_CHECKING:
    from qgeo_filters.surface import Surface


def _system(wanted: bool) -> None:
    if wanted:
        from qgeo_filters.cli.system import system_information

        typer.echo(system_information())
        raise typer.Exit


def info(
    meshes: MeshFiles,
    system: Annotated[
        bool,
        typer.Option(
            "--system", callback=_system, is_eager=True, help="Say what a bug report needs instead: versions."
        ),
    ] = False,
    output: Output = None,
    repair: Annotated[
        bool, typer.Option("--repair", help="Make the mesh manifold and one piece first; the report says what changed.")
    ] = False,
    force: Force = False,
    wrap: Wrap = False,
    pictures: Pictures = True,
    also: Also = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Describe a mesh: size, pieces, boundary, what is not manifold."""
    from qgeo_filters.cli.in_turn import in_turn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.report.figures import plot_surface

    # Described as it is, unless one of them is asked for.
    mend = repair_option(repair or None, force, wrap) if repair or force or wrap else False

    def one(mesh: Path, settings: Settings) -> None:
        job = Job("info", settings, {"repair": mend}, [mesh], pictures=["surface"])
        (surface,) = job.read()
        with job.stage("describe"):
            results = {**job.meshes[0], **details(surface)}
        del results["path"]
        arrays = {"face_areas": surface.face_areas, "vertex_areas": surface.vertex_areas, "edges": surface.edges}
        job.save(results, arrays, surface)
        caption = "The surface" + (", its boundary in red." if not surface.is_closed else ": it has no boundary.")
        job.picture("surface", caption, lambda: plot_surface(surface))
        job.finish()

    in_turn(meshes, Settings(output, quiet, json, mend, pictures, also), one, "info")


def details(surface: Surface) -> dict[str, Any]:
    """Numbers of a surface for result.json: what kind of surface it is, and the quality of its triangles."""
    lengths = surface.edge_lengths
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return {
        "closed": surface.is_closed,
        "oriented": surface.is_oriented,
        "winding": surface.winding,
        "euler_characteristic": surface.euler_characteristic,
        "nonmanifold_edges": len(surface.nonmanifold_edges),
        "nonmanifold_vertices": len(surface.nonmanifold_vertices),
        "unwelded_vertices": len(surface.unwelded_vertices),
        "unreferenced_vertices": len(surface.unreferenced_vertices),
        "faces_without_area": int((surface.face_areas == 0).sum()),
        "edge_length_min": float(lengths.min()),
        "edge_length_mean": float(lengths.mean()),
        "edge_length_max": float(lengths.max()),
        "smallest_angle_degrees": math.degrees(surface.corner_angles.min()),
        "bounding_box_min": low.tolist(),
        "bounding_box_max": high.tolist(),
        "attributes": sorted(surface.attributes),
        "advice": advice(surface),
    }


def advice(surface: Surface) -> list[str]:
    """What --repair mends in a surface, as commands do by themselves where they must; nothing for most."""
    sides = {"inward": "the faces are wound inwards", "mixed": "some faces are wound outwards and some inwards"}
    found = [f"{sides[surface.winding]}: --repair turns them"] if surface.winding in sides else []
    if len(surface.unwelded_vertices):
        found.append("vertices lie on each other along seams: --repair joins them")
    return found
