"""
Hints where a shape looks alike in several ways
===============================================

A star with five equal arms goes onto itself in five ways, each as good as the others. A landmark or two say which is
meant.
"""

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

import qgeo_filters as qg
from qgeo_filters.report.maps import plot_correspondence


def star(turn=0.0, arms=5):
    """A round body with equal arms in a plane and a hump above; ``turn`` moves the triangles, and not the shape."""
    ball = trimesh.creation.icosphere(2)
    points = ball.vertices @ Rotation.from_euler("xyz", [turn, turn, turn]).as_matrix()
    directions = [(np.cos(angle), np.sin(angle), 0.0) for angle in 2 * np.pi * np.arange(arms) / arms]
    radius = np.full(len(points), 0.6)
    for direction, length in [*((direction, 1.2) for direction in directions), ((0, 0, 1), 0.3)]:
        radius += length * np.exp(10 * (points @ direction - 1))
    surface = qg.Surface(points * radius[:, None], ball.faces)
    return surface, [int((surface.vertices @ direction).argmax()) for direction in directions]


x, tips_x = star()
y, tips_y = star(turn=1.0)


def arms_reached(found):
    """For each arm of X, to which arm of Y its tip is taken."""
    image = y.vertices[found.p2p[tips_x]]
    return np.linalg.norm(image[:, None] - y.vertices[tips_y], axis=2).argmin(axis=1).tolist()


# %%
# Without a hint one of the five comes out, that which the triangles make a little cheaper, and it is not called sure.
# With finer triangles it may be: ``confident`` knows how much the next map costs, and not what you mean.
shapes = qg.PreparedShape(x), qg.PreparedShape(y)  # matched twice: what belongs to one shape is computed once
alone = qg.match(*shapes)
print(arms_reached(alone), alone.confident, alone.explanation)

# %%
# Two arms that are known settle which of the ways is meant.
known = qg.match(*shapes, landmarks=[(tips_x[0], tips_y[2]), (tips_x[1], tips_y[3])])
print(known.confident, known.explanation)

# %%
# As the hints say, two arms further on.
arms_reached(known)

# %%
plot_correspondence(x, y, known.p2p)
