"""Animations as binary glTF with morph targets: what Blender, three.js and Windows play."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.atomic import atomic_write
from qgeo_filters.io.gltf_writing import colored_mesh
from qgeo_filters.report.film import checked_seconds
from qgeo_filters.report.glb import placed_beside
from qgeo_filters.report.reel import Reel, reels
from qgeo_filters.report.view import View

_FLOAT, _SCALAR, _VECTOR = 5126, "SCALAR", "VEC3"  # as glTF numbers and names them


def write_animated_glb(
    path: str | PathLike[str],
    animation: Animation,
    *,
    seconds: float | None = None,
    names: tuple[str, str] = ("X", "Y"),
    view: View | None = None,
) -> None:
    """Write the frames as morph targets of one mesh, and a track that plays them; of a `Transfer` X beside Y.

    Parameters
    ----------
    path : path
    animation : Animation
    seconds : float, optional
        How long it takes; by default a twelfth of a second a frame, and at least two seconds.
        Frames stand where their times are.
    names : (str, str)
        Of the nodes of X and Y.
    view : View, optional
        From which the shapes are placed; `best_view` of the first frame by default, of a `Transfer` that of Y at rest.

    Notes
    -----
    The mesh is the first frame, each further one a target with positions and normals: 24 bytes a vertex and frame.
    Between frames a viewer goes on straight lines. Coordinates are those of the animation; the node turns, scales and
    moves the shape.
    """
    import trimesh

    length = checked_seconds(seconds, len(animation))
    shapes = reels(animation, names, view)
    if len(shapes) > 1 and shapes[0].name == shapes[1].name:  # nodes are known by their names
        shapes = [replace(reel, name=f"{reel.name} {side}") for reel, side in zip(shapes, "XY", strict=True)]
    scene = trimesh.Scene()
    for reel, side in zip(shapes, (-1.0, 1.0) if len(shapes) > 1 else (0.0,), strict=True):
        surface = reel.animation.surface
        first = surface.with_vertices(reel.animation.positions[0])
        mesh = colored_mesh(first.vertices, surface.faces, reel.colors, first.vertex_normals)
        placement = placed_beside(reel.shown, reel.view, float(np.sqrt(surface.area)), side)
        scene.add_geometry(mesh, node_name=reel.name, geom_name=f"{reel.name} mesh", transform=placement)
    content = scene.export(
        file_type="glb",
        include_normals=True,
        buffer_postprocessor=lambda items, tree: _add_frames(items, tree, shapes, length),
    )
    with atomic_write(path) as file:
        file.write(content)


def _add_frames(items: dict[str, bytes], tree: dict[str, Any], shapes: list[Reel], length: float) -> None:
    """Add targets to the meshes of a scene, and an animation of their weights."""
    times = shapes[0].animation.times
    if len(times) == 1:
        return
    numbers = ((times - times[0]) * length / (times[-1] - times[0])).astype(np.float32)
    clock = _accessor(items, tree, numbers, _SCALAR, bounds=True)
    track: dict[str, Any] = {"name": "poses", "samplers": [], "channels": []}
    for reel in shapes:
        node = next(k for k, node in enumerate(tree["nodes"]) if node.get("name") == reel.name)
        mesh = tree["meshes"][tree["nodes"][node]["mesh"]]
        mesh["primitives"][0]["targets"] = [
            {name: _accessor(items, tree, change, _VECTOR, bounds=name == "POSITION") for name, change in frame.items()}
            for frame in _changes(reel.animation)
        ]
        count = len(reel.animation) - 1
        mesh["weights"] = [0.0] * count
        weights = np.eye(count + 1, count, k=-1, dtype=np.float32).ravel()
        track["channels"].append({"sampler": len(track["samplers"]), "target": {"node": node, "path": "weights"}})
        track["samplers"].append(
            {"input": clock, "output": _accessor(items, tree, weights, _SCALAR), "interpolation": "LINEAR"}
        )
    tree["animations"] = [track]


def _changes(animation: Animation) -> list[dict[str, np.ndarray]]:
    """What positions and normals add to those of the first frame, for each further one."""
    frames = [(frame.vertices, frame.vertex_normals) for frame in animation]
    start: tuple[FloatArray, FloatArray] = frames[0]
    return [
        {"POSITION": (places - start[0]).astype(np.float32), "NORMAL": (normals - start[1]).astype(np.float32)}
        for places, normals in frames[1:]
    ]


def _accessor(
    items: dict[str, bytes], tree: dict[str, Any], values: np.ndarray, kind: str, bounds: bool = False
) -> int:
    """Number of a new accessor of numbers that are put at the end of the buffer."""
    accessor: dict[str, Any] = {
        "bufferView": len(items), "byteOffset": 0, "componentType": _FLOAT, "count": len(values), "type": kind,
    }  # fmt: skip
    if bounds:
        rows = values.reshape(len(values), -1)
        accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
    items[f"frame-{len(items)}"] = np.ascontiguousarray(values, dtype="<f4").tobytes()
    tree["accessors"][f"frame-{len(items)}"] = accessor
    return len(tree["accessors"]) - 1
