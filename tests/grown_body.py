"""A body with four limbs, and another pose of it in which two of them have grown together."""

from __future__ import annotations

import functools

import numpy as np
from shapes import bent, limbed

from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.surface import Surface

LIMBS = ((0.7, 0.6, -0.4), (-0.5, 0.8, -0.4), (0, -1, 0.3), (0, 0.6, 0.8))


@functools.cache
def body() -> Surface:
    return Surface(*limbed(LIMBS, (1.2, 0.9, 0.7, 0.4), 3))


@functools.cache
def grown() -> Surface:
    """Another pose, in which the ends of two limbs have grown together: a tube joins a triangle of each."""
    vertices, faces = bent(body().vertices, 0.2), body().faces
    centres = vertices[faces].mean(axis=1)
    one, other = (int((centres @ np.array(limb)).argmax()) for limb in LIMBS[:2])
    a = faces[one]
    b = faces[other][::-1]
    b = min((np.roll(b, k) for k in range(3)), key=lambda turned: np.linalg.norm(vertices[a] - vertices[turned]))
    tube = [f for k in range(3) for f in ((a[k], a[k - 2], b[k]), (a[k - 2], b[k - 2], b[k]))]
    return Surface(vertices, np.concatenate([np.delete(faces, [one, other], axis=0), tube]))


@functools.cache
def prepared_body() -> PreparedShape:
    """The body with what belongs to it alone, which is the same in all tests."""
    return PreparedShape(body())


@functools.cache
def prepared_grown() -> PreparedShape:
    """The same of the other pose."""
    return PreparedShape(grown())
