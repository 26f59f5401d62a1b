"""
How far apart poses are
=======================

The distance of two poses is that of their eigenfunctions along the map between them, C_XY. D(S), eq. (5) of the paper,
is its mean over a set of poses.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.maps import plot_poses


def head_turned(points, degrees=50, begin=0.3, end=0.55):
    """The cow looking to a side: what lies before ``begin`` is turned, little by little up to ``end``."""
    angle = np.radians(degrees) * np.clip((points[:, 2] - begin) / (end - begin), 0, 1)
    x, z = points[:, 0], points[:, 2] - begin
    turned = [x * np.cos(angle) + z * np.sin(angle), points[:, 1], begin - x * np.sin(angle) + z * np.cos(angle)]
    return np.column_stack(turned)


cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
poses = [cow.with_vertices(head_turned(cow.vertices, degrees)) for degrees in (0, 30, 60)]
swollen = cow.with_vertices(cow.vertices + 0.08 * cow.vertex_normals)

# %%
# Poses of one mesh: vertex i is the same point of all. Meshes with triangles of their own are matched first, or maps
# are given.
found = qg.compatibility([*poses, swollen], k=6)
found.c_xy.round(2)

# %%
# The last is no pose: it is another, thicker cow, and farther from all poses than they are from each other.
among_poses = found.c_xy[:3, :3].max()
nearest = found.c_xy[3, :3].min()
print(f"C_XY of poses up to {among_poses:.2f}, to the thicker cow {nearest:.2f} and more; D(S) = {found.d_s:.2f}")

# %%
plot_poses([*poses, swollen], found.maps, names=["standing", "30 degrees", "60 degrees", "thicker"])
