"""
Between two poses, as an animation
==================================

The way from one pose to another, as rigid as possible at every moment: limbs turn and do not shrink.
"""

import tempfile
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


cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
turned = cow.with_vertices(head_turned(cow.vertices, 90))
way = qg.interpolate(cow, turned, np.linspace(0, 1, 9))
way

# %%
plot_film_strip(way, 5)

# %%
# Half way, edges should have the mean of their lengths at both ends. On straight lines they are shorter.
mean = (cow.edge_lengths + turned.edge_lengths) / 2
straight = cow.with_vertices((cow.vertices + turned.vertices) / 2)
for name, shape in (("as rigid as possible", way[4]), ("on straight lines", straight)):
    print(f"{name}: {100 * np.abs(shape.edge_lengths / mean - 1).max():.1f} % at most")

# %%
# Morph targets for Blender and three.js, and a moving picture.
with tempfile.TemporaryDirectory() as folder:
    for name in ("cow.glb", "cow.gif"):
        qg.write_animation(Path(folder) / name, way)
        print(name, f"{(Path(folder) / name).stat().st_size / 1e6:.1f} MB")
