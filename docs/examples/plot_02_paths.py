"""
Paths as lines in Open3D
========================

The straightest way between two vertices, on the surface itself and where curvature bends the metric; as a
``LineSet``.
"""

from pathlib import Path

import numpy as np
import open3d as o3d
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.charts import plot_path_curvature
from qgeo_filters.report.figures import plot_path

cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
muzzle, tail = 1151, 2334
own = qg.quasi_geodesic(cow, muzzle, tail)
guided = qg.quasi_geodesic(cow, muzzle, tail, qg.lifted_metric(cow, curvature_weight=0.1))
own, guided

# %%
# The guided path is short *and* keeps to places of like curvature.
plot_path(cow, guided)

# %%
# A ``LineSet`` of both, for ``draw_geometries`` and for files.
points = np.concatenate([own.points, guided.points])
ends = np.arange(len(points) - 1)
ends = ends[ends != len(own.points) - 1]  # no line from the first path to the second
lines = o3d.geometry.LineSet(
    o3d.utility.Vector3dVector(points), o3d.utility.Vector2iVector(np.column_stack([ends, ends + 1]))
)
lines

# %%
# The geodesic curvature, eq. (1), is zero where a path is straight. What is left are vertices at which a shortest path
# may bend.
plot_path_curvature(own)

# %%
# A distance is the length of the shortest path.
abs(qg.distances(cow, muzzle, method="exact")[0, tail] / own.length - 1) < 1e-9
