"""
Many shapes in one store
========================

A folder of shapes becomes tables, pictures and maps that agree. Each shape is prepared once, each pair matched once; a
second run computes nothing. The shapes are a body in two poses, and a longer one.
"""

import numpy as np

import qgeo_filters as qg
from qgeo_filters.report.collection_charts import plot_dendrogram, plot_heat_map


def bent(surface, curvature):
    """The body rolled onto a circle about the x axis: distances on it hardly change."""
    x, y, z = surface.vertices.T
    angle, radius = curvature * y, 1 / curvature
    return surface.with_vertices(
        np.column_stack([x, (radius - z) * np.sin(angle), radius - (radius - z) * np.cos(angle)])
    )


body = qg.testing.sample_surface()
long = body.with_vertices(body.vertices * [1, 1.5, 1])
shapes = {"short0": bent(body, 0.1), "short1": bent(body, 0.3), "long0": bent(long, 0.1)}

# %%
# With ``store="shapes.zarr"`` what is found stays; without one, as here, it lives as long as the object. A folder, or a
# list of files, does as well. One metric is enough for shapes as plain as these.
plain = qg.MatchingParameters(curvature_weights=(0.15,))
collection = qg.Collection(shapes, groups=lambda name: name.rstrip("0123456789"), parameters=plain)
collection.match(workers=1)
collection.table()[["x", "y", "group_x", "group_y", "c_xy", "distortion", "confident"]].round(3)

# %%
# How far the shapes are apart, by the eigenfunctions of their distances along the maps:
distances = collection.distances("c_xy")
plot_heat_map(distances, collection.groups, label="C_XY (no unit)")

# %%
plot_dendrogram(distances, collection.groups, label="C_XY (no unit)")

# %%
# Maps that contradict those through other shapes are named; here there are none.
collection.consistency().wrong()

# %%
# A landmark that is placed on one shape is placed on all:
collection.landmark_table([17], on="short0").round(2)
