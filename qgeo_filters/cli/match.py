"""``qgeo match``: which points of two shapes belong together, with no initial map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

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
from qgeo_filters.errors import MeshError, ParameterError, reason

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters._typing import PartialOption
    from qgeo_filters.matching.match_result import MatchResult


def match(
    x: Annotated[Path, typer.Argument(metavar="X", help="A mesh file, as in qgeo info.", show_default=False)],
    y: Annotated[Path, typer.Argument(metavar="Y", help="The shape that it is mapped to.", show_default=False)],
    truth: Annotated[
        Path | None,
        typer.Option(
            "--truth",
            metavar="FILE",
            help="True vertex of Y (from 0; -1: not known) for each of X, as .npz, .npy or text: adds errors.",
        ),
    ] = None,
    hints: Hints = None,
    landmarks_file: Annotated[
        Path | None,
        typer.Option(
            "--landmarks",
            metavar="FILE",
            help="Landmarks on X, carried to Y: .fcsv, .mrk.json, .tps, .pts, .landmarkAscii, .pp or a table "
            "(name, x, y, z or vertex).",
        ),
    ] = None,
    specimen: Annotated[
        str | None,
        typer.Option("--specimen", metavar="NAME", help="Which specimen of a .tps file that holds several."),
    ] = None,
    frame: HintsFrame = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write the map as map.csv, a row for each vertex of X.")] = False,
    glb: Annotated[
        bool, typer.Option("--glb/--no-glb", help="Write both shapes in colours that belong together, as match.glb.")
    ] = True,
    normalize: Annotated[
        bool, typer.Option("--normalize/--no-normalize", help="Compare shapes regardless of their size.")
    ] = True,
    partial: Annotated[
        bool | None,
        typer.Option(
            "--partial/--no-partial",
            help="Whether one shape is a part of the other; by default that is tried where a match is not sure.",
            show_default=False,
        ),
    ] = None,
    mirror: Annotated[
        Literal["auto", "no", "yes"],
        typer.Option("--mirror", help="Whether Y is a mirror image of X, as a left bone is of a right one."),
    ] = "auto",
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
    """Find the vertex of Y for each vertex of X: two shapes that bend into each other, no initial map.

    result.npz: p2p (n_X,), score, runner_up, inverse (n_Y,), -1 where there is no partner, functional_map (20, 20),
    distortion (n_X,), regions_x (n_X,), regions_y (n_Y,), corners (n_X, 3) and barycentric (n_X, 3), the vertices
    of a triangle of Y and the place within it, finer than p2p, and errors (n_X,) with --truth. X_on_Y.ply: X deformed
    onto Y. match_log.md: every map that was proposed, what it cost, and which rule dropped it. match.glb: both shapes
    side by side, for any 3D viewer. With --landmarks also landmarks_Y, in the format of FILE, and landmarks.csv; with
    --csv map.csv. With --hints also landmarks (k, 2) and landmark_errors (k,), how far the map comes from each, in
    sqrt(area). Meshes have what belongs together in one colour, and the distortion as quality.
    """
    import numpy as np

    from qgeo_filters.cli import match_outputs as outputs
    from qgeo_filters.cli import match_pictures as drawn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters import stages
    from qgeo_filters.io.hint_files import read_hints
    from qgeo_filters.matching import hints as known
    from qgeo_filters.matching.map_files import arrays_of
    from qgeo_filters.matching.matchable import check_same_size
    from qgeo_filters.matching.partial.partial_match import matched_as_part

    mend = repair_option(repair, force, wrap)
    as_part: PartialOption = "auto" if partial is None else partial
    parameters: dict[str, Any] = {
        "normalize": normalize,
        "truth": truth and str(truth),
        "hints": hints and [str(file) for file in hints],
        "landmarks": landmarks_file and str(landmarks_file),
        "specimen": specimen,
        "frame": frame,
        "repair": mend,
        "partial": as_part,
        "mirror": mirror,
    }
    written = [outputs.SCENE] * glb + [outputs.MAP_TABLE] * csv
    if landmarks_file is not None:
        written += [outputs.landmarks_name(landmarks_file), outputs.PAIRS]
    job = Job(
        "match",
        Settings(output, quiet, json, mend, pictures, also),
        parameters,
        [x, y],
        names=("X", "Y"),
        inputs=[file for file in (truth, *(hints or ()), landmarks_file) if file is not None],
        pictures=(*drawn.NAMES, *(() if truth is None else drawn.NAMES_OF_ERRORS)),
        texts=("match_log.md", *written),
        meshes_made=[outputs.deformed_name],
    )
    shape_x, shape_y = job.read_given()
    shapes = shape_x, shape_y
    target = None if truth is None else read_truth(truth, shapes[0].n_vertices, shapes[1].n_vertices)
    landmarks = known.Hints.of(*shapes, read_hints(hints, frame)).landmarks if hints else None
    marks = landmarks_file and outputs.landmarks_of_x(landmarks_file, shape_x, specimen, frame)
    # Raw CT has walls inside: what tells its size is the area of its wrap.
    size_x, size_y = (stages.wrap_of(shape).surface if mend == "wrap" else shape for shape in shapes)
    whole = not matched_as_part(size_x, size_y, as_part, normalize)
    if not normalize and whole:
        check_same_size(size_x, size_y)
    prepared = []  # held here: the next stages then find them, whatever the bound of the cache
    for index, shape in enumerate(shapes if whole else ()):
        with job.stage(f"spectra of {'XY'[index]}", index):
            prepared.append(stages.prepared_shape_of(shape, repair=mend))
    with job.stage("match"):
        found = stages.correspondence_of(
            *shapes,
            normalize,
            repair_x=mend,
            repair_y=mend,
            partial=as_part,
            mirror=mirror,
            landmarks=landmarks,
        )
    for index, name in enumerate(("X: ", "Y: ")):
        job.repaired(index, [line.removeprefix(name) for line in found.repairs if line.startswith(name)])
    arrays = arrays_of(found)
    arrays |= {"corners": found.barycentric.corners, "barycentric": found.barycentric.coordinates}
    attributes: dict[str, np.ndarray] = {
        "qgeo_correspondence": found.p2p.astype(np.int32),
        "qgeo_region": found.regions_x,
        "qgeo_distortion": found.distortion,
    }
    if landmarks is not None:
        arrays |= {"landmarks": landmarks, "landmark_errors": found.landmark_errors}
    results = match_results(found)
    errors = None
    if target is not None:
        with job.stage("errors"):
            errors = found.error(target)
        results |= error_results(errors)
        arrays["errors"] = attributes["qgeo_error"] = errors
    shown = outputs.shown_match(found)
    described = shapes[0].with_attributes(attributes)
    job.save(results, arrays, described, shapes[1].with_attributes({"qgeo_region": found.regions_y}), shown=shown)
    job.write_meshes({outputs.deformed_name(job): outputs.deformed(described, found, shown[0])})
    job.text("match_log.md", f"{found.log}\n")
    tables = [outputs.save_landmarks(job, landmarks_file, marks, found)] if landmarks_file and marks else []
    if csv:
        outputs.save_map_table(job, found)
    if glb:
        outputs.save_scene(job, found, normalize, marks or None)
    drawn.draw_match(job, *shapes, found, errors)
    tables.append(drawn.draw_worst(job, *shapes, found, errors))
    drawn.draw_log(job, found.log)
    job.finish([*tables, outputs.files_table(job, landmarks_file, csv, glb)])


def read_truth(path: Path, n_x: int, n_y: int) -> np.ndarray:
    """True vertex of Y for each vertex of X, (n_x,), from a file; -1 where it is not known.

    Raises
    ------
    ParameterError
        Not that many whole numbers within Y, or an .npz in which the array cannot be told.
    """
    from qgeo_filters.io.number_files import number_table, saved_arrays, whole_numbers
    from qgeo_filters.validation import checked_indices

    try:
        if path.suffix in (".npz", ".npy"):
            arrays = saved_arrays(path)
            name = next((name for name in ("", "truth", "p2p") if name in arrays), None)
            if name is None and len(arrays) != 1:
                raise MeshError(f"it holds {', '.join(arrays) or 'nothing'}: call the array of true vertices 'truth'")
            values = arrays[name] if name is not None else next(iter(arrays.values()))
        else:
            values = number_table(path)
            values = values.ravel() if 1 in values.shape else values
        if values.shape != (n_x,):
            raise MeshError(f"expected one vertex of Y for each of the {n_x} of X, got shape {values.shape}")
        whole = whole_numbers(values, "truth")
    except MeshError as error:
        raise ParameterError(f"{path}: not a list of vertices ({reason(error)})") from error
    return checked_indices(whole, n_y, str(path), missing=True)


def match_results(found: MatchResult) -> dict[str, Any]:
    """Numbers of a correspondence for result.json; distortions in units of sqrt(area)."""
    import numpy as np

    return {
        "confident": found.confident,
        "explanation": found.explanation,
        "score": found.score,
        "largest_distortion": float(np.nanmax(found.distortion)),
        "runner_up": found.runner_up,
        "margin": found.margin,
        "orientation": found.orientation,
        "hks_agreement": found.hks_agreement,
        "c_xy": found.c_xy,
        "vertices_of_y_reached": len(np.unique(found.p2p[found.p2p >= 0])),
        "vertices_of_x_without_partner": int(np.sum(found.p2p < 0)),
        "overlap_x": found.overlap_x,
        "overlap_y": found.overlap_y,
    }


def error_results(errors: np.ndarray) -> dict[str, Any]:
    """Numbers of the errors against the truth, in units of sqrt(area), for result.json; NaN is not counted."""
    import numpy as np

    from qgeo_filters.evaluation.errors import THRESHOLDS, ErrorSummary

    known = errors[np.isfinite(errors)]
    if not known.size:
        raise ParameterError("--truth knows no vertex that the map has a partner for")
    summary = ErrorSummary.of(known)
    shares = {
        f"percent_within_{threshold:g}": 100 * share for threshold, share in zip(THRESHOLDS, summary.below, strict=True)
    }
    shares["vertices_with_an_error"] = known.size
    return {"mean_error": summary.mean, "median_error": summary.median, "max_error": summary.maximum, **shares}
