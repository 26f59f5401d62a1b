"""
A mesh with much wrong with it
==============================

What is wrong is said in one sentence, what was repaired in several; results come back on the vertices that were
given.
"""

import numpy as np
import trimesh

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_distance_field, plot_surface


def creature(left=1.2):
    """A round body with a head, a tail and four legs; the left foreleg of another length, if you like."""
    ball = trimesh.creation.icosphere(3)
    legs = {(0.6, 0.7, -0.6): 1.2, (-0.6, 0.7, -0.6): left, (0.6, -0.7, -0.6): 0.9, (-0.6, -0.7, -0.6): 0.9}
    radius = np.full(len(ball.vertices), 0.6)
    for direction, length in {**legs, (0, 1, 0.4): 0.8, (0, -1, 0.2): 0.5}.items():
        radius += length * np.exp(12 * (ball.vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return qg.Surface(ball.vertices * radius[:, None], ball.faces)


body = creature()
rng = np.random.default_rng(0)

# %%
# A triangle soup, as STL files are: each face has corners of its own. Some are turned over, one is there twice, a few
# are missing, and a crumb lies beside.
faces = np.arange(3 * body.n_faces).reshape(-1, 3)
points = body.vertices[body.faces].reshape(-1, 3)
turned = rng.random(len(faces)) < 0.2
faces[turned] = faces[turned][:, ::-1]
kept = np.delete(faces, rng.integers(0, len(faces), 3), axis=0)
crumb = np.array([[3.0, 3, 3], [3.1, 3, 3], [3, 3.1, 3]])
mess = (
    np.concatenate([points, crumb]),
    np.concatenate([kept, kept[:1], [[len(points), len(points) + 1, len(points) + 2]]]),
)
try:
    qg.match(mess, body, repair=False)
except qg.MeshError as error:
    print(error)

# %%
repair = qg.repair_surface(mess, fill_holes=True)
print(repair.surface)
print("\n".join(repair.report))

# %%
plot_surface(repair.surface)

# %%
# What no repair mends, such as a body made of pieces that cross, is wrapped in a closed surface.
rod = trimesh.creation.capsule(height=2.4, radius=0.25).apply_translation([0, 0, -1.2])
crossed = np.concatenate([body.vertices, rod.vertices]), np.concatenate([body.faces, rod.faces + body.n_vertices])
wrap = qg.wrap_surface(crossed)
print("\n".join(wrap.report))
plot_surface(wrap.surface)

# %%
# Filters repair a copy and bring values back to the vertices that were given.
filter = qg.QuasiGeodesicDistances(sources=0)
out = filter(mess, repair=True)
values = out.attributes["qgeo_distance"]
values.shape, int(np.isnan(values).sum())

# %%
plot_distance_field(repair.surface, values[repair.origin], int(repair.vertex_of_original[0]))
