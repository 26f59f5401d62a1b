"""
A spectrum that hardly changes with the pose
============================================

Eigenfunctions of all distances describe a shape: two poses have nearly the same.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.charts import plot_spectrum
from qgeo_filters.report.figures import plot_eigenfunctions


def head_turned(points, degrees=50, begin=0.3, end=0.55):
    """The cow looking to a side: what lies before ``begin`` is turned, little by little up to ``end``."""
    angle = np.radians(degrees) * np.clip((points[:, 2] - begin) / (end - begin), 0, 1)
    x, z = points[:, 0], points[:, 2] - begin
    turned = [x * np.cos(angle) + z * np.sin(angle), points[:, 1], begin - x * np.sin(angle) + z * np.cos(angle)]
    return np.column_stack(turned)


cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
posed = cow.with_vertices(head_turned(cow.vertices))
standing, turned = (qg.distance_spectrum(shape, k=12) for shape in (cow, posed))
standing

# %%
plot_eigenfunctions(cow, standing, range(6))

# %%
plot_spectrum(standing.eigenvalues)

# %%
# Divided by the area to the power 3/2 an eigenvalue has no unit.
values = [s.eigenvalues / shape.area**1.5 for s, shape in ((standing, cow), (turned, posed))]
np.abs(values[0] / values[1] - 1).round(3)

# %%
# Along a map, here equal vertices, eigenfunctions are paired by eq. (4) of the paper. C_XY tells how far the poses are
# apart.
pairs = qg.commutative_eigenspectra(standing, turned, np.arange(cow.n_vertices))
print(f"C_XY = {pairs.c_xy:.3f}; two unrelated sets of functions would have {12 * np.sqrt(2):.1f}")
