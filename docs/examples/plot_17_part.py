"""
A part matched to the whole
===========================

Half a body, as a scan from one side or a cut gives it: partners where there are any, -1 where there are none.
"""

import numpy as np
import trimesh

import qgeo_filters as qg
from qgeo_filters.report.maps import plot_correspondence


def creature(left=1.2):
    """A round body with a head, a tail and four legs; the left foreleg of another length, if you like."""
    ball = trimesh.creation.icosphere(3)
    legs = {(0.6, 0.7, -0.6): 1.2, (-0.6, 0.7, -0.6): left, (0.6, -0.7, -0.6): 0.9, (-0.6, -0.7, -0.6): 0.9}
    radius = np.full(len(ball.vertices), 0.6)
    for direction, length in {**legs, (0, 1, 0.4): 0.8, (0, -1, 0.2): 0.5}.items():
        radius += length * np.exp(12 * (ball.vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return qg.Surface(ball.vertices * radius[:, None], ball.faces)


def bent(points, amount):
    """Points bent about the x axis, nearly without stretching."""
    x, y, z = points.T
    angle = amount * y
    return np.column_stack([x, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)])


body = creature(left=1.5)
posed = body.with_vertices(bent(body.vertices, 0.25))
part, origin = posed.submesh(body.vertices[:, 1] > -0.35)
part, body

# %%
# Both have their true sizes: ``normalize=False``.
found = qg.match(part, body, partial=True, normalize=False)
print(found.explanation)
print(f"{100 * found.overlap_x:.0f} % of the part have a partner, {100 * found.overlap_y:.0f} % of the body")

# %%
plot_correspondence(part, body, found.p2p)

# %%
# The truth is known.
partner = found.p2p >= 0
error = np.linalg.norm(body.vertices[found.p2p] - body.vertices[origin], axis=1)[partner] / np.sqrt(body.area)
print(f"mean error {error.mean():.3f} sqrt(area), {100 * (error < 0.1).mean():.0f} % within .1")
