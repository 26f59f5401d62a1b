"""``qgeo collection landmarks`` and ``common``: what is placed on one shape, on all; all with the triangles of one."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from qgeo_filters.cli.in_turn import Batch
from qgeo_filters.cli.options import Also, Json, Output, Pictures, Quiet, Settings
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.io.landmarks import Frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from qgeo_filters.collection.collection import Collection
    from qgeo_filters.report.view import View
    from qgeo_filters.surface import Surface

_TABLE = "landmarks.csv"
# Pictures of the modes of variation.
_MODES, _SIGMA = 3, 2.0
# Shapes in a picture.
_SHOWN = 12

Shapes = Annotated[
    Path,
    typer.Argument(
        metavar="STORE", help="What build made, or a folder of meshes, of which one is made.", show_default=False
    ),
]
Kept = Annotated[
    Path, typer.Option("--store", metavar="STORE", help="Folder of the results where STORE is a folder of meshes.")
]
Maps = Annotated[
    Literal["matched", "mended", "tree", "template", "all ways"],
    typer.Option(
        "--maps",
        help="As matched from that shape; or such as agree with all others, for which all pairs are matched: "
        "'all ways' is the middle of all ways through a third shape.",
    ),
]
Processes = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", help="Processes at most; all cores if left out.", show_default=False),
]


def landmarks(
    store: Shapes,
    marks: Annotated[
        Path, typer.Argument(metavar="MARKS", help="Landmarks: .fcsv, .mrk.json, .csv, .tps, ...", show_default=False)
    ],
    on: Annotated[
        str, typer.Option("--on", metavar="NAME", help="The shape that they are placed on.", show_default=False)
    ],
    maps: Maps = "matched",
    frame: Annotated[
        Frame | None,
        typer.Option("--frame", help="Frame of the meshes: landmarks that say they are in the other one are turned."),
    ] = None,
    kept: Kept = Path("shapes.zarr"),
    workers: Processes = None,
    output: Output = None,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Carry landmarks from one shape to all: landmarks.csv with columns shape, landmark, x, y, z.

    Pairs that are not matched yet are matched first; a shape without a map is named, and the rest goes on; the exit
    code is then 1. result.npz: points (m, k, 3), shapes (m,), landmarks (k,).
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.collection.landmarks import write_landmark_table
    from qgeo_filters.io.landmark_files import read_landmarks
    from qgeo_filters.report.landmarks import plot_landmarks

    given = read_landmarks(marks)
    if frame is not None and given.frame is not None:
        given = given.in_frame(frame)
    collection = _collection(store, kept)
    parameters = {"store": str(collection.store.root), "landmarks": str(marks), "on": on, "maps": maps, "frame": frame}
    settings = Settings(output, quiet, json, pictures=pictures)
    job = Job("collection landmarks", settings, parameters, inputs=[marks], pictures=["landmarks"], texts=[_TABLE])
    batch = Batch()
    with job.stage("match"):
        _match_from(collection, on, maps, workers)
        collection = _mapped(collection, on, maps, batch)
    job.subject = f"{len(given.names)} landmarks of {on} on {len(collection)} shapes"
    with job.stage("carry"):
        found = collection.landmarks(given, on, how=maps)
    points = np.stack([one.points for one in found.values()])
    lost = int(np.isnan(points).any(axis=2).sum())
    results: dict[str, Any] = {"shapes": len(found), "landmarks": len(given.names), "without_image": lost}
    results |= {"not_sure": _unsure(collection, on), **batch.for_results()}
    job.save(results, {"points": points, "shapes": np.array(list(found)), "landmarks": np.array(given.names)})
    with job.file(_TABLE) as temporary:
        write_landmark_table(temporary, found)
    shown = {name: collection.surface(name) for name in [on, *(n for n in collection.names if n != on)][:_SHOWN]}
    caption = f"Landmarks of {on}, each in one colour on all shapes{_first(len(found))}."
    job.picture("landmarks", caption, lambda: plot_landmarks(shown, found))
    job.finish()
    batch.finish(len(collection) + len(batch.bad), "shapes were left out")


def common(
    store: Shapes,
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help="The shape whose triangles all get.", show_default=False)
    ],
    maps: Maps = "matched",
    scale: Annotated[
        bool, typer.Option("--scale", help="Whether the mean and the modes are regardless of size.")
    ] = False,
    accept_unsure: Annotated[bool, typer.Option("--accept-unsure", help="Use maps that are not sure, too.")] = False,
    kept: Kept = Path("shapes.zarr"),
    workers: Processes = None,
    output: Output = None,
    pictures: Pictures = True,
    also: Also = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Give all shapes the triangles of one: NAME.ply each, mean.ply, and the modes in which they vary.

    A shape without a map, or with one that is not sure, is named and left out; the exit code is then 1. Shapes are
    where they were; mean and modes are of the shapes laid on each other (Procrustes). result.npz: positions
    (m, n, 3), modes (k, n, 3), variance (k,), explained (k,), scores (m, k), shapes (m,).
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.collection.shape_model import shape_model
    from qgeo_filters.report.colors import position_colors
    from qgeo_filters.report.maps import plot_poses
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.report.view import best_view

    collection = _collection(store, kept)
    names = collection.names
    extremes = {
        f"mode{k}{sign}": (k, sigma)
        for k in range(min(_MODES, len(names) - 1))
        for sign, sigma in (("-", -_SIGMA), ("+", _SIGMA))
    }
    taken = [name for name in ("mean", *extremes) if name in names]
    if taken:
        raise ParameterError(f"a shape is called {taken[0]}, as a file of the model is: give it another name")
    parameters: dict[str, Any] = {
        "store": str(collection.store.root),
        "template": template,
        "maps": maps,
        "scale": scale,
    }
    settings = Settings(output, quiet, json, pictures=pictures, also=also)
    job = Job(
        "collection common", settings, parameters, pictures=["shapes", "modes"], meshes_made=[*names, "mean", *extremes]
    )
    batch = Batch()
    with job.stage("match"):
        _match_from(collection, template, maps, workers)
        collection = _mapped(collection, template, maps, batch, sure=maps == "matched" and not accept_unsure)
    names = collection.names
    extremes = {name: place for name, place in extremes.items() if place[0] < len(names) - 1}
    job.subject = f"{len(names)} shapes with the triangles of {template}"
    with job.stage("remesh"):
        found = collection.common(template, how=maps, accept_unsure=accept_unsure)
    with job.stage("model"):
        model = shape_model(found.aligned(scale=scale))
    results = {"shapes": len(found), "vertices": found.template.n_vertices, "explained": model.explained.tolist()}
    results |= batch.for_results()
    arrays = {name: getattr(model, name) for name in ("modes", "variance", "explained", "scores")}
    job.save(results, {"positions": found.positions, **arrays, "shapes": np.array(names)})
    model_meshes = {"mean": model.mean} | {name: model.mode(*place) for name, place in extremes.items()}
    body = found.template
    colors = position_colors(body.vertices, best_view(body.vertices, body.faces).axes)
    job.write_meshes({name: Shown(colors).on(found[name]) for name in names})
    changes = {name: np.linalg.norm(mesh.vertices - model.mean.vertices, axis=1) for name, mesh in model_meshes.items()}
    job.write_meshes({name: Shown(colors, changes[name]).on(mesh) for name, mesh in model_meshes.items()})
    same = np.arange(found.template.n_vertices)

    def plot(some: dict[str, Surface], view: View | None = None) -> Figure:
        return plot_poses(list(some.values()), [same] * len(some), names=list(some), columns=5, view=view)

    shown = {name: found[name] for name in names[:_SHOWN]}
    job.picture("shapes", f"Equal vertices have equal colours{_first(len(names))}.", lambda: plot(shown))
    caption = f"The mean, and it with each mode {_SIGMA:g} standard deviations less and more."
    job.picture("modes", caption, lambda: plot(model_meshes, best_view(model.mean.vertices, model.mean.faces)))
    job.finish()
    batch.finish(len(collection) + len(batch.bad), "shapes were left out")


def _first(count: int) -> str:
    return f"; the first {_SHOWN} of {count}" if count > _SHOWN else ""


def _collection(place: Path, kept: Path) -> Collection:
    """The store, or that of a folder of meshes."""
    from qgeo_filters.collection.collection import Collection
    from qgeo_filters.collection.records import METADATA

    return Collection.open(place) if (place / METADATA).exists() or not place.exists() else Collection(place, kept)


def _match_from(collection: Collection, name: str, maps: str, workers: int | None) -> None:
    """Match what the maps from one shape need: it with all others, or all pairs."""
    collection.surface(name)  # raises where there is none
    some = [(x, y) for x, y in itertools.combinations(collection.names, 2) if maps != "matched" or name in (x, y)]
    collection.match(some, workers=workers)


def _mapped(collection: Collection, name: str, maps: str, batch: Batch, *, sure: bool = False) -> Collection:
    """The shapes that can be reached from this one, by a match that is sure where it must be; the others are named.

    Raises
    ------
    MeshError
        None can: why the first of them cannot.
    """
    table = collection.table()
    why = {problem.subject: problem.reason for problem in collection.problems if problem.lost}
    kept, lost = [name], {}
    for other in collection.names:
        of = table[(table.x == other) | (table.y == other)]
        if maps == "matched":
            of = of[(of.x == name) | (of.y == name)]
        good = of[of.problem == ""]
        if other == name:
            continue
        if good.empty:
            said = (why.get(subject) for subject in (name, other, f"{name} - {other}", f"{other} - {name}"))
            lost[other] = next(filter(None, said), f"no match leads from {name} to it")
        elif sure and not good.confident.any():
            lost[other] = f"the match is not sure: {good.explanation.iloc[0]}; --accept-unsure takes it all the same"
        else:
            kept.append(other)
    if lost and len(kept) == 1:
        first = next(iter(lost))
        raise MeshError(f"{name} - {first}: {lost[first]}")
    # Files that could not be read are no shapes of the collection.
    lost |= {other: reason for other, reason in why.items() if other not in lost and " - " not in other}
    for other, reason in lost.items():
        batch.leave_out(other, reason)
    return collection.only([one for one in collection.names if one in kept]) if lost else collection


def _unsure(collection: Collection, name: str) -> list[str]:
    """Shapes whose match with this one is not sure."""
    table = collection.table()
    of = table[((table.x == name) | (table.y == name)) & ~table.confident]
    return sorted({*of.x, *of.y} - {name})
