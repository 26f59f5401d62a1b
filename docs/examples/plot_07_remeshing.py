"""
Remeshing with attributes kept
==============================

Remeshing and decimation drop or garble what was known at the vertices. Keep the mesh from before, and take the values
from its closest points.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.decimation import decimated
from qgeo_filters.report.figures import plot_attribute

path = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
meshes = pymeshlab.MeshSet(verbose=False)
meshes.load_new_mesh(str(path))
before = (qg.Curvatures() | qg.SurfaceScalar())(meshes)
rich = qg.as_surface(before)
sorted(rich.attributes)

# %%
# The same set is decimated by PyMeshLab.
meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=2000)
after = qg.TransferAttributes(source=rich, names=["qgeo_scalar", "qgeo_mean_curvature"])(meshes)
poor = qg.as_surface(after)
poor, sorted(name for name in poor.attributes if name.startswith("qgeo"))

# %%
plot_attribute(poor, "qgeo_scalar", poor.attributes["qgeo_scalar"])

# %%
# The package has a decimation of its own, which keeps the topology and knows the place of every old vertex on the new
# surface, so that values go both ways.
small = decimated(rich, 700)
height = small.surface.vertices[:, 1]
back = small.pulled_back(height)
print(small.surface, f"largest error of the height: {np.abs(back - rich.vertices[:, 1]).max():.4f}")
