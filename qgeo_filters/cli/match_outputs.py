"""What ``qgeo match`` writes for other programs: landmarks of X on Y, the map as a table, both shapes as a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.io.landmark_files import landmarks_content, read_landmarks
from qgeo_filters.io.vertex_table import table_text
from qgeo_filters.matching.map_landmarks import landmarks_at, located
from qgeo_filters.report.html import Table

if TYPE_CHECKING:
    from qgeo_filters.cli.job import Job
    from qgeo_filters.io.landmarks import Frame, Landmarks
    from qgeo_filters.matching.match_result import MatchResult
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.surface import Surface

SCENE, MAP_TABLE, PAIRS = "match.glb", "map.csv", "landmarks.csv"
_AXES = "xyz"


def landmarks_name(path: Path) -> str:
    """Name of the file of the landmarks on Y: of the format of that on X."""
    suffix = ".mrk.json" if path.name.lower().endswith(".mrk.json") else path.suffix
    return f"landmarks_Y{suffix}"


def landmarks_of_x(path: Path, surface: Surface, specimen: str | None, frame: Frame | None) -> Landmarks:
    """Landmarks from a file, known to lie on X: said before the match, not after.

    Raises
    ------
    MeshError, ParameterError
        A malformed file, landmarks off the surface; the message starts with the path.
    """
    known: str | int | None = int(specimen) if specimen is not None and specimen.isdecimal() else specimen
    try:
        marks = read_landmarks(path, specimen=specimen, frame=frame)
    except ParameterError:
        if not isinstance(known, int):
            raise
        marks = read_landmarks(path, specimen=known, frame=frame)  # no name, but a number
    with concerning(str(path)):
        located(marks, surface, "X")
    return marks


def save_landmarks(job: Job, path: Path, marks: Landmarks, found: MatchResult) -> Table:
    """Write the landmarks on Y, and a table of both; returns that table for the report."""
    on_x = landmarks_at(marks.names, located(marks, found.x, "X"), found.x)
    on_y = found.landmarks(marks)
    name = landmarks_name(path)
    with job.file(name) as temporary:
        temporary.write_bytes(landmarks_content(name, on_y))
    columns = ["name"]
    for shape in _AXES[:2]:
        columns += [f"{shape}_vertex", *(f"{shape}_{axis}" for axis in _AXES)]
    rows = [
        [label, *cells_x, *cells_y]
        for label, cells_x, cells_y in zip(marks.names, _cells(on_x), _cells(on_y), strict=True)
    ]
    with job.file(PAIRS) as temporary:
        temporary.write_bytes(table_text(columns, rows))
    lost = int((on_y.vertices < 0).sum())
    note = f"{lost} of them have no partner on Y, or are missing in the file." if lost else ""
    return Table("Landmarks", rows, columns, note)


def _cells(marks: Landmarks) -> list[list[Any]]:
    """Vertex and position of each landmark; None where a number is not known."""
    points = marks.points.astype(object)
    points[np.isnan(marks.points)] = None
    return [[vertex, *point] for vertex, point in zip(marks.vertices.tolist(), points.tolist(), strict=True)]


def save_map_table(job: Job, found: MatchResult) -> None:
    """Write a row for each vertex of X."""
    with job.file(MAP_TABLE) as temporary:
        found.to_csv(temporary)


def save_scene(job: Job, found: MatchResult, normalize: bool, marks: Landmarks | None) -> None:
    """Write both shapes side by side, with the landmarks if there are any."""
    from qgeo_filters.report.glb import write_match_glb

    with job.stage("scene"), job.file(SCENE) as temporary:
        write_match_glb(temporary, found, normalize=normalize, landmarks=marks)


def shown_match(found: MatchResult) -> tuple[Shown, Shown]:
    """What belongs together in one colour, as in the first picture, and the distortion on both shapes."""
    from qgeo_filters.report.glb import map_colors
    from qgeo_filters.report.maps import view_alike
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.report.view import best_view

    x, y = found.x, found.y
    on_x, on_y = map_colors(found, view_alike(x, best_view(x.vertices, x.faces), y, found.p2p))
    return Shown(on_x, found.distortion), Shown(on_y, found.transfer(found.distortion))


def deformed_name(job: Job) -> str:
    """Name of the file of X deformed onto Y."""
    return "_on_".join(job.names)


def deformed(x: Surface, found: MatchResult, shown: Shown) -> Surface:
    """X, with its attributes and colours, laid onto Y; without the faces of vertices that have no place there."""
    import numpy as np

    from qgeo_filters.surface import Surface

    known = np.isfinite(found.positions).all(axis=1) & (found.p2p >= 0)
    painted = shown.on(x)
    faces = x.faces[known[x.faces].all(axis=1)]
    left, corners = np.unique(faces, return_inverse=True)
    attributes = {name: values[left] for name, values in painted.attributes.items()}
    if len(left) < len(known):
        attributes["qgeo_vertex"] = left.astype(np.int32)  # of X
    return Surface(found.positions[left], corners.reshape(-1, 3), attributes)


def files_table(job: Job, landmarks: Path | None, table: bool, scene: bool) -> Table:
    """What is in the files beside the report."""
    rows = {"result.npz": "all arrays; MatchResult.from_npz reads it"}
    rows[f"{deformed_name(job)}.ply"] = "X deformed onto Y, its triangles and colours"
    if scene:
        rows[SCENE] = "both shapes, and landmarks, side by side in the colours of the first picture, for 3D viewers"
    if table:
        rows[MAP_TABLE] = "a row for each vertex of X: its vertex and point on Y, and the distortion"
    if landmarks is not None:
        rows |= {landmarks_name(landmarks): "the landmarks on Y", PAIRS: "the landmarks on both shapes"}
    return Table.of("Files", rows)
