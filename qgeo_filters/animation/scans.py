"""Poses of a surface from scans in any triangulation: positions of its own vertices, brought onto each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.animation.places import Places, places_on, warned
from qgeo_filters.animation.poses import listed_poses
from qgeo_filters.closest_points import closest_points
from qgeo_filters.deformation.pose import posed
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.dispatch import as_given
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.surface import Surface

# Below which a scan's shape is that of its reference rather than the scan's own, in sqrt(area).
_SCAN_LENGTH = 0.03
# A scan follows the one before where they are so near, in sqrt(area): then points of the one are marks on the other.
_NEXT, _MARKS = 0.05, 24


def scanned_poses(
    reference: Surface, scans: Any, accept_unsure: bool = False, repair: RepairOption = "auto"
) -> Iterator[FloatArray]:
    """Positions (n, 3) of the reference's vertices in each pose, of which there is a scan in any triangulation.

    Each scan is matched with the reference, and the reference brought onto it as rigidly as possible. Where a scan lies
    near the one before, marks on that one steer the match.

    Raises
    ------
    ParameterError
        A scan whose match is not sure, unless that is accepted, with a warning; one that reverses the orientation.
    """
    follower, count = ScanFollower(reference, accept_unsure, repair), 0
    for count, scan in enumerate(listed_poses(scans), start=1):
        with concerning(f"pose {count - 1}"):
            positions = follower(scan, f"pose {count - 1}")
        yield positions
    if count == 0:
        raise ParameterError("no poses were given")


class ScanFollower:
    """Brings a reference onto one scan after the other, as `scanned_poses` says; a scan that fails leaves no trace."""

    def __init__(self, reference: Surface, accept_unsure: bool = False, repair: RepairOption = "auto") -> None:
        self._reference, self._accept_unsure, self._repair = reference, accept_unsure, repair
        self._prepared = PreparedShape(reference, repair=repair)
        self._before: FloatArray | None = None

    def __call__(self, scan: Any, called: str) -> FloatArray:
        """Positions (n, 3) of the reference's vertices; warnings say what the scan is called."""
        surface, _ = as_given(scan, "auto")
        marks = None if self._before is None else _marks(self._reference, self._before, surface)
        found = match(self._prepared, surface, landmarks=marks, repair=self._repair)
        places = places_on(surface, self._reference, found, self._accept_unsure, by_landmarks=False)
        warned(f"{called}: {doubt}" for doubt in places.doubts)
        self._before = laid_onto(self._reference, surface, places, _SCAN_LENGTH)
        return self._before


def laid_onto(body: Surface, surface: Surface, places: Places, length: float) -> FloatArray:
    """Positions (n, 3) of a body on the surface, of any size, that it is mapped to; its own shape below a length."""
    grown = body.with_vertices(body.vertices / places.size)
    return posed(grown, places.on_x.pulled_back(surface.vertices), length, length)


def _marks(reference: Surface, before: FloatArray, scan: Surface) -> tuple[FloatArray, FloatArray] | None:
    """Points of the reference, and those of the scan nearest to where they were before; None if that is far."""
    near = closest_points(before, scan).pulled_back(scan.vertices)
    if np.linalg.norm(near - before, axis=1).max() > _NEXT * np.sqrt(reference.area):
        return None
    chosen = farthest_in_embedding(reference.vertices, min(_MARKS, reference.n_vertices))
    return reference.vertices[chosen], near[chosen]
