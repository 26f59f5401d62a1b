"""What a user knows of the place of a part: landmarks and labels, in the vertices that a partial match works on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.matching.hints import Hints
from qgeo_filters.matching.known_parts import KnownParts, full_labels, full_vertices
from qgeo_filters.matching.partial.distance_bounds import violations
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.validation import frozen


def known_of_part(
    hints: Hints, prepared: tuple[PreparedShape, PreparedShape], shapes: tuple[PartShape, PartShape], part: int
) -> KnownParts | None:
    """What is known, X being the part and Y the whole; None if nothing of it is left on both.

    Parameters
    ----------
    prepared, shapes : pair
        Of the part and of the whole.
    part : int
        Which column of the hints is that of the part: 0 or 1.
    """
    sides = (part, 1 - part)
    landmarks = np.column_stack(
        [
            working.proxy.nearest_corner[full_vertices(shape, hints.landmarks[:, side])]
            for side, shape, working in zip(sides, prepared, shapes, strict=True)
        ]
    )
    numbers = [
        _labels(shape, working, hints.labels[side])
        for side, shape, working in zip(sides, prepared, shapes, strict=True)
    ]
    labels = np.intersect1d(numbers[0], numbers[1])
    labels = labels[labels >= 0]
    if not len(landmarks) and not len(labels):
        return None
    rows = [
        frozen(
            np.concatenate(
                [working.distances(landmarks[:, side]), *(working.distance_from(own == n)[None] for n in labels)]
            ).astype(np.float32)
        )
        for side, (working, own) in enumerate(zip(shapes, numbers, strict=True))
    ]
    return KnownParts(frozen(landmarks), labels, rows[0], rows[1], prepared[0].parameters)


def resized(known: KnownParts, ratio: float) -> KnownParts:
    """The same for a part so many times as large."""
    return replace(known, to_x=frozen(known.to_x * np.float32(ratio)))


def hint_costs(known: KnownParts | None, x: PartShape, y: PartShape) -> SingleArray:
    """Cost (m_x, m_y) of mapping each farthest point of X to each of Y, by what is known.

    How far distances from known parts lie outside the bounds that a cut leaves (see `distance_bounds`), beyond what a
    landmark may be off: the mean over all of them.
    """
    costs = np.zeros((len(x.fps), len(y.fps)), dtype=np.float32)
    if known is None:
        return costs
    rim = x.rim.astype(np.float32)
    for here, there in zip(known.to_x, known.to_y, strict=True):
        most = here[x.fps]
        # A way out of the part and in again crosses its rim twice, once at most as near to the known part as this.
        least = np.minimum(most, rim[x.fps] + rim[here.argmin()])
        outside = violations(least[:, None], most[:, None], there[y.fps][None])
        costs += np.clip(outside - known.parameters.hint_softness, 0, known.parameters.hint_reach)
    return costs / np.float32(len(known.to_x))


def _labels(shape: PreparedShape, working: PartShape, labels: IndexArray) -> IndexArray:
    return full_labels(shape, labels)[working.proxy.vertices] if len(labels) else labels
