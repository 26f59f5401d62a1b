"""
The accessor of PyVista
=======================

Every filter is a method of ``mesh.qgeo``, of every PyVista surface.
"""

import numpy as np
import pyvista

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_attribute, plot_distance_field

mesh = pyvista.ParametricEllipsoid(1.5, 1.0, 0.7, u_res=40, v_res=30).triangulate().clean()
mesh.points += 0.15 * np.sin(3 * mesh.points[:, [1, 2, 0]])
print([name for name in dir(mesh.qgeo) if not name.startswith("_")])

# %%
out = mesh.qgeo.quasi_geodesic_distances(sources=0, curvature_weight=0.0)
out.point_data.keys()

# %%
plot_distance_field(out, out.point_data["qgeo_distance"], 0)

# %%
# Parameters are those of the filter; a pipeline goes through ``apply``.
out = mesh.qgeo.apply(qg.Curvatures() | qg.SurfaceScalar())
plot_attribute(out, "qgeo_mean_curvature", out.point_data["qgeo_mean_curvature"])

# %%
# A path as a line of PyVista: ``pyvista.lines_from_points`` takes its points.
path = qg.quasi_geodesic(mesh, 0, mesh.n_points // 2)
line = pyvista.lines_from_points(path.points)
line.compute_cell_sizes()["Length"].sum(), path.length
