"""
Landmarks carried through a map
===============================

Points that were set on a template, and where they are on another shape. Files of Slicer, tps, MeshLab and others are
read and written.
"""

import tempfile
from pathlib import Path

import numpy as np
import trimesh

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_scalar


def creature(left=1.2):
    """A round body with a head, a tail and four legs; the left foreleg of another length, if you like."""
    ball = trimesh.creation.icosphere(3)
    legs = {(0.6, 0.7, -0.6): 1.2, (-0.6, 0.7, -0.6): left, (0.6, -0.7, -0.6): 0.9, (-0.6, -0.7, -0.6): 0.9}
    radius = np.full(len(ball.vertices), 0.6)
    for direction, length in {**legs, (0, 1, 0.4): 0.8, (0, -1, 0.2): 0.5}.items():
        radius += length * np.exp(12 * (ball.vertices @ (np.array(direction) / np.linalg.norm(direction)) - 1))
    return qg.Surface(ball.vertices * radius[:, None], ball.faces)


def bent(points, amount):
    """Points bent about the x axis, nearly without stretching."""
    x, y, z = points.T
    angle = amount * y
    return np.column_stack([x, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)])


template = creature()
specimen = template.with_vertices(2 * bent(template.vertices, 0.3))
tips = [int((template.vertices @ d).argmax()) for d in ([0.6, 0.7, -0.6], [-0.6, 0.7, -0.6], [0, 1, 0.4], [0, -1, 0.2])]
marks = qg.Landmarks(["right hand", "left hand", "head", "tail"], template.vertices[tips])
marks

# %%
found = qg.match(template, specimen)
carried = found.landmarks(marks)
for name, point in zip(carried.names, carried.points, strict=True):
    print(f"{name:11}", point.round(3))

# %%
# The truth is known here: the same vertices.
np.linalg.norm(carried.points - specimen.vertices[tips], axis=1) / np.sqrt(specimen.area)

# %%
# For Slicer, and back.
with tempfile.TemporaryDirectory() as folder:
    qg.write_landmarks(Path(folder) / "specimen.fcsv", carried)
    again = qg.read_landmarks(Path(folder) / "specimen.fcsv")
again

# %%
# The landmarks on the specimen: distance to the nearest of them.
plot_scalar(specimen, qg.distances(specimen, carried.vertices).min(axis=0), "distance to the nearest landmark")
