"""A filter on a repaired copy of a mesh: its parameters taken there, and what it adds brought back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from qgeo_filters._typing import RepairOption
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import DisconnectedError, MeshError
from qgeo_filters.hosts.dispatch import as_given
from qgeo_filters.hosts.given_images import images_on_given, keep_vertices
from qgeo_filters.hosts.repair import Repair, repaired_within
from qgeo_filters.repair.triangle_soup import PIECES, most_lost
from qgeo_filters.surface import Surface
from qgeo_filters.validation import listed

Result = TypeVar("Result")


def least_repair(mesh: Any, apply: Callable[[Repair], Result], refusal: MeshError | None = None) -> Result:
    """What a filter does to a mesh that needs repair: with all of its pieces, or with the largest if it must.

    Parameters
    ----------
    mesh : mesh object
    apply : callable
        Gives what is done to the repaired mesh.
    refusal : MeshError, optional
        Why the filter refused the mesh as it is: raised where there is nothing to repair.
    """
    for pieces in PIECES:
        found = repaired_within(mesh, most_lost("auto"), pieces)
        if not found.changed and refusal is not None and pieces == PIECES[-1]:
            raise refusal
        try:
            return apply(found)
        except DisconnectedError:
            if pieces == PIECES[-1]:
                raise
    raise AssertionError("unreachable: the last attempt returns or raises")


@contextmanager
def parameters_on(repair: Repair, filters: Iterable[Any]) -> Iterator[None]:
    """Context in which parameters that are vertices of the original, or values there, are those of the repaired mesh.

    Each filter knows the repair by its ``repair_`` there, and after it.

    Raises
    ------
    MeshError
        A vertex that had to go.
    """
    changes = [(step, step.get_params(), step.repaired_parameters(repair)) for step in filters]
    try:
        for step, _, changed in changes:
            step.repair_ = repair
            for name, value in changed.items():
                setattr(step, name, value)
        yield
    finally:
        for step, given, changed in changes:
            for name in changed:
                setattr(step, name, given[name])


def other_mesh(obj: Any, repair: Repair | None) -> tuple[Surface | Repair, RepairOption]:
    """A second mesh, and what is to be repaired of it: it is wrapped where the first one was.

    Parameters
    ----------
    obj : see `as_surface`
        A `Repair` stands as it is, for the mesh that was given to it.
    repair : Repair, optional
        Of the first mesh.
    """
    if isinstance(obj, Repair):
        return obj, False
    asked: RepairOption = "auto" if keep_vertices(repair) else "wrap"
    return as_given(obj, asked)[0], asked


def repair_now(repair: Repair | None, surface: Surface) -> Surface | Repair:
    """What a filter works on, with the mesh that was given: moved as steps before it moved the repaired one.

    Parameters
    ----------
    repair : Repair, optional
    surface : Surface
        That which ``repair`` made, with attributes of its own, and maybe elsewhere.
    """
    if repair is None or not np.array_equal(surface.faces, repair.surface.faces):  # that of another mesh, before
        return surface
    if np.array_equal(surface.vertices, repair.surface.vertices):
        return repair
    shift = np.nan_to_num(repair.map_back(surface.vertices - repair.surface.vertices))
    return replace(repair, given=repair.given.with_vertices(repair.given.vertices + shift), surface=surface)


def carried_back(repair: Repair, values: np.ndarray, are_vertices: bool) -> np.ndarray:
    """Values at the original vertices; those that are vertices themselves as original ones."""
    if are_vertices:
        return images_on_given(values, repair, repair, repair.surface)
    return repair.map_back(values)


def repaired_vertices(repair: Repair, name: str, vertices: Any) -> Any:
    """Repaired vertices that stand for original ones; what is none is left for the filter to refuse."""
    numbers = as_array(vertices)
    if numbers.dtype.kind not in "iu" or ((numbers < 0) | (numbers >= len(repair.vertex_of_original))).any():
        return vertices
    there = repair.vertex_of_original[numbers]
    if (there < 0).any():
        gone = listed(numbers.ravel()[there.ravel() < 0])
        raise MeshError(f"{name}: {gone} had to go when the mesh was repaired ({'; '.join(repair.report)})")
    return int(there) if numbers.ndim == 0 else there


def repaired_values(repair: Repair, values: Any) -> Any:
    """Values of the original vertices at the repaired ones; names and functions as they are."""
    if isinstance(values, str) or callable(values) or values is None:
        return values
    array = as_array(values)
    return array[repair.origin] if array.shape[:1] == repair.vertex_of_original.shape else values
