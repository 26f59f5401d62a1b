"""
Distances from a point that is picked in Open3D
===============================================

A filter takes an Open3D mesh and returns one with named values at its vertices. The sources are vertices, such as
those that were picked with a mouse.
"""

from pathlib import Path

import open3d as o3d
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.charts import plot_distance_matrix
from qgeo_filters.report.figures import plot_distance_field

path = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
mesh = o3d.t.io.read_triangle_mesh(str(path))

# %%
# With a screen ``picked = draw_geometries_with_vertex_selection([mesh.to_legacy()])`` gives vertices. Here a point is
# known, the muzzle, and Open3D finds the vertex that is nearest to it.
tree = o3d.core.nns.NearestNeighborSearch(mesh.vertex.positions)
tree.knn_index()
muzzle = o3d.core.Tensor([[0.03, 0.22, 0.87]], dtype=mesh.vertex.positions.dtype)
picked = int(tree.knn_search(muzzle, 1)[0].item())
picked

# %%
# Open3D joins vertices of equal position when it reads, and on the cow two parts of the surface then touch in one
# vertex. ``repair=True`` works on a repaired copy and carries the values back to your vertices.
filter = qg.QuasiGeodesicDistances(sources=picked, curvature_weight=0.01)
out = filter(mesh, repair=True)
print(filter.repair_.report)
distance = out.vertex["qgeo_distance"].numpy()[:, 0]

# %%
# Colours that ``draw_geometries`` shows come from :class:`~qgeo_filters.Paint`. Pictures without a screen are drawn by
# the package.
painted = qg.Paint(attribute="qgeo_distance")(out).to_legacy()
painted.has_vertex_colors()

# %%
surface = qg.as_surface(out)
plot_distance_field(surface, distance, picked)

# %%
# All distances, from each vertex to each, are one call. The rows are put in an order along the surface.
cow = qg.Surface.read(path)
plot_distance_matrix(qg.distance_matrix(cow), cow)
