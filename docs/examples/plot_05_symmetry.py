"""
Symmetry, and how left and right differ
=======================================

A point map of a shape to itself that swaps left and right, found without a hint; and what differs between the two
sides.
"""

import numpy as np
import trimesh

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_scalar
from qgeo_filters.report.maps import plot_sides, plot_symmetry


def creature(left=1.2):
    """A round body with a head, a tail and four legs; the left foreleg of another length, if you like."""
    ball = trimesh.creation.icosphere(3)
    legs = {(0.6, 0.7, -0.6): 1.2, (-0.6, 0.7, -0.6): left, (0.6, -0.7, -0.6): 0.9, (-0.6, -0.7, -0.6): 0.9}
    radius = np.full(len(ball.vertices), 0.6)
    for direction, length in {**legs, (0, 1, 0.4): 0.8, (0, -1, 0.2): 0.5}.items():
        radius += length * np.exp(12 * (ball.vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return qg.Surface(ball.vertices * radius[:, None], ball.faces)


body = creature()
symmetry = qg.self_symmetry(body)
symmetry.found, symmetry.reason

# %%
# A point and its mirror image have one colour.
plot_symmetry(body, p2p=symmetry.nearest)

# %%
# Two sides, and an axis between them. Which of them is left nobody can tell from the shape.
plot_sides(body, symmetry.side)

# %%
# A body with one longer arm has no exact symmetry. The map is there all the same, and ``asymmetry`` tells where the
# distances of the two sides differ most.
uneven = creature(left=1.5)
other = qg.self_symmetry(uneven)
print(other.reason)
print(f"mean asymmetry {symmetry.score:.4f} and {other.score:.4f} sqrt(area)")

# %%
plot_scalar(uneven, other.asymmetry, "asymmetry, sqrt(area)")

# %%
# Values of one side on the other: ``other.barycentric.pulled_back(values)``. Here the difference of the heights of a
# point and of its mirror image.
height = uneven.vertices[:, 1]
plot_scalar(uneven, height - other.barycentric.pulled_back(height), "height less that of the mirror image")
