"""
Matching two scans
==================

Two cows: one stands, the other looks to a side. Each has triangles of its own, so that nothing but the shape tells
which point belongs to which.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.maps import plot_correspondence


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
y = remeshed(cow.with_vertices(head_turned(cow.vertices)), 2.5)
x, y

# %%
# No initial map, no position, no scale is used.
found = qg.match(x, y)
found

# %%
# Whether it is sure, and why.
found.confident, found.explanation

# %%
# Each vertex of X has the colour of the point of Y that it belongs to.
plot_correspondence(x, y, found.p2p)

# %%
# Here the truth is known: where each vertex of X is on the cow, and where that is when the head is turned.
truth = head_turned(x.vertices)
error = np.linalg.norm(found.barycentric.pulled_back(y.vertices) - truth, axis=1) / np.sqrt(y.area)
print(f"mean error {error.mean():.4f} sqrt(area), the largest {error.max():.4f}")
