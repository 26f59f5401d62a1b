"""
The poses of one shape on another
=================================

A cow that turns its head, and another cow in other triangles, of another size and in another place, which then does
so, too. No markers are given; the map is found.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.film import plot_film_strip


def head_turned(points, degrees=50, begin=0.3, end=0.55):
    """The cow looking to a side: what lies before ``begin`` is turned, little by little up to ``end``."""
    angle = np.radians(degrees) * np.clip((points[:, 2] - begin) / (end - begin), 0, 1)
    x, z = points[:, 0], points[:, 2] - begin
    turned = [x * np.cos(angle) + z * np.sin(angle), points[:, 1], begin - x * np.sin(angle) + z * np.cos(angle)]
    return np.column_stack(turned)


def remeshed(surface, edge):
    """The surface in new triangles; ``edge`` is their length, in per cent of the bounding box's diagonal."""
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.faces)))
    meshes.meshing_isotropic_explicit_remeshing(targetlen=pymeshlab.PercentageValue(edge))
    return qg.as_surface(meshes, repair=True)


cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
x = remeshed(cow, 3)
poses = [head_turned(x.vertices, degrees) for degrees in (15, 30, 45, 60)]
y = remeshed(cow, 2.5)
y = y.with_vertices(2 * y.vertices + 1)

# %%
moved = qg.transfer_deformation(x, poses, y)
moved

# %%
print(moved.correspondence.explanation)

# %%
# Above what was given, below what was found.
plot_film_strip(moved, 4, names=("given", "found"))

# %%
# The truth is known: the same turn of Y's own head.
truth = [2 * head_turned((y.vertices - 1) / 2, degrees) + 1 for degrees in (15, 30, 45, 60)]
error = np.linalg.norm(moved.positions - truth, axis=2).mean(axis=1) / np.sqrt(y.area)
print("mean error of each pose, sqrt(area):", error.round(4))
