"""
Several pieces, each onto its own
=================================

A skull and its jaw, the bones of a hand: shapes of several pieces, in any order. Each piece is matched with the one
that it belongs to.
"""

import numpy as np
import trimesh

import qgeo_filters as qg
from qgeo_filters.report.maps import plot_region_pair


def body(limbs, level=3):
    """A round body with a limb of a given length in each direction."""
    ball = trimesh.creation.icosphere(level)
    radius = np.full(len(ball.vertices), 0.6)
    for direction, length in limbs.items():
        radius += length * np.exp(12 * (ball.vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return ball.vertices * radius[:, None], ball.faces


def together(*meshes):
    """One mesh of all pieces."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return qg.Surface(np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces))


large, large_faces = body({(1, 0.2, 0): 1.3, (-0.6, 0.8, 0.1): 0.9, (0, -0.5, 1): 0.6, (0.2, 0.1, -1): 0.4})
small, small_faces = body({(0, 1, 0): 0.9, (0.5, -0.7, 0.5): 0.6, (-0.8, -0.2, 0.3): 0.3}, level=2)
x = together((large, large_faces), (0.5 * small + [0, -2, 0], small_faces))
y = together((0.5 * small[:, [1, 2, 0]] + [3, 0, 0], small_faces), (large[:, [1, 2, 0]], large_faces))

# %%
found = qg.match_pieces(x, y)
print(found.explanation)
for piece in found.pieces:
    print(
        f"vertices {piece.vertices_x.min()}... of X onto {piece.vertices_y.min()}... of Y: {piece.result.explanation}"
    )

# %%
# The truth is known: the pieces stand in the other order.
truth = np.concatenate([np.arange(len(large)) + len(small), np.arange(len(small))])
error = np.linalg.norm(y.vertices[found.p2p] - y.vertices[truth], axis=1) / np.sqrt(y.area)
print(f"mean error {error.mean():.4f} sqrt(area)")

# %%
piece_of_y = y.components[1]
plot_region_pair(x, y, piece_of_y[found.p2p], piece_of_y)
