"""What `animate` takes: an animation, or meshes with equal triangles, one for each frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_filters.animation.poses import given_poses, has_no_triangles, listed_poses
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.dispatch import as_surface, is_mesh

_WANTED = "animate takes an Animation, a Transfer, or meshes with equal triangles"


def animations_of(given: Any) -> list[tuple[str, Animation]]:
    """Name and animation of each pane: X and Y of a transfer, else one.

    Raises
    ------
    ParameterError
        What is no animation; no mesh at all; meshes of other triangles; a source of other frames than its transfer.
    MeshError
        What is no mesh.
    """
    if isinstance(given, Transfer) and given.source is not None:
        if not np.array_equal(given.source.times, given.times):
            raise ParameterError(
                f"the source has {len(given.source)} frames, at other times than the {len(given)} of Y"
            )
        return [("X", given.source), ("Y", given)]
    return [("shape", given if isinstance(given, Animation) else _of_meshes(given))]


def _of_meshes(given: Any) -> Animation:
    try:
        meshes = list(listed_poses(given))
    except ParameterError as error:
        raise ParameterError(f"{_WANTED}, got one {type(given).__name__}") from error
    if not meshes:
        raise ParameterError(f"{_WANTED}, got an empty {type(given).__name__}")
    if has_no_triangles(meshes[0]):
        raise ParameterError("positions alone have no triangles: animate(qgeo_filters.Animation(mesh, positions))")
    with concerning("mesh 0"):
        first = as_surface(given if is_mesh(given) else meshes[0])
    return Animation(first, np.stack(list(given_poses(first, meshes))))
