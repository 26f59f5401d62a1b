"""How unlike the surroundings of points of a part and of points of the whole are, whatever was cut away."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.matching.partial.part_shape import PartShape

_LEAST_AREA = 1e-9
# Radius of a ball whose area can be told from its vertices, in mean edges.
_EDGES = 3.0


def descriptor_costs(x: PartShape, y: PartShape) -> SingleArray:
    """Cost (m_x, m_y) of mapping each farthest point of X to each of Y.

    Geodesic balls that do not reach the rim have the area that they have on the whole; those that do have at most that.
    Added to it is the difference of the mean curvature, which tells the inside of a bend from its outside.
    """
    given = x.given
    radii = np.array(given.ball_radii)
    relative = 0.5 * np.log(
        np.maximum(x.balls[:, None], _LEAST_AREA) / np.maximum(y.balls[None], _LEAST_AREA)
    )  # of lengths
    whole = (radii <= x.rim[x.fps][:, None])[:, None]
    balls = np.minimum(np.where(whole, np.abs(relative), np.maximum(relative, 0)), given.ball_cap).mean(axis=2)
    bulge = np.minimum(np.abs(x.bulge[:, None] - y.bulge[None]) / given.bulge_scale, given.bulge_cap)
    return np.ascontiguousarray((balls + bulge).astype(np.float32))


def ball_agreement(x: PartShape, y: PartShape, places: IndexArray) -> float:
    """Agreement of the areas of balls that do not reach the rim with those around the images, 1 if they are equal.

    One minus half the mean squared difference of their logarithms over their variance at each radius, of those that
    several edges span.

    Parameters
    ----------
    places : (s,) int
        Of the images of X's first farthest points among Y's.
    """
    points = x.fps[: len(places)]
    radii = np.array(x.given.ball_radii)
    coarsest = max(x.surface.edge_lengths.mean(), y.surface.edge_lengths.mean())
    inside = (radii <= x.rim[points][:, None]) & (radii > _EDGES * coarsest)
    here, there = np.log(x.balls[: len(places)]), np.log(y.balls[places])
    squares = variance = 0.0
    for one, other, told in zip(here.T, there.T, inside.T, strict=True):
        squares += float(((one - other)[told] ** 2).sum())
        variance += float(((one[told] - one[told].mean()) ** 2).sum()) if told.any() else 0.0
    return 1 - 0.5 * squares / variance if variance > 0 else 1.0
