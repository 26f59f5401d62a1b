"""
Labels, colours and texture coordinates carried over
====================================================

What was drawn or measured on a template, on a scan in another pose and another triangulation.
"""

from pathlib import Path

import numpy as np
import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_attribute
from qgeo_filters.report.maps import plot_region_pair


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
template = remeshed(cow, 3)
scan = remeshed(cow.with_vertices(head_turned(cow.vertices)), 2.5)
found = qg.match(scan, template)
found.explanation

# %%
# Labels are whole numbers or text: a vertex gets that of most of the area that is mapped to it.
height, along = template.vertices[:, 1], template.vertices[:, 2]
part = np.where(along > 0.45, 0, np.where(height < -0.25, 1, 2))  # head, legs, trunk
on_scan = found.transfer(part, to="x")
plot_region_pair(template, scan, part, on_scan, names=("template", "scan"))

# %%
# Numbers, such as colours and texture coordinates, are interpolated within triangles. ``to="y"`` is the other way.
uv = np.column_stack([(along - along.min()) / np.ptp(along), (height - height.min()) / np.ptp(height)])
plot_attribute(scan, "uv", found.transfer(uv, to="x"))

# %%
# A filter does the same for meshes of a host, here of PyMeshLab. With ``correspondence=True`` it finds the map itself.
meshes = pymeshlab.MeshSet(verbose=False)
meshes.add_mesh(pymeshlab.Mesh(np.array(scan.vertices), np.array(scan.faces)))
carry = qg.TransferAttributes(source=template.with_attributes({"part": part}), correspondence=found)
out = carry(meshes)
np.unique(out.current_mesh().vertex_custom_scalar_attribute_array("part"))
