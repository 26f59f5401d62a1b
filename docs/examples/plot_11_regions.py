"""
Regions that are symmetric
==========================

Eq. (3) of the paper: points at which a sum of eigenfunctions is equal may be mirror images. Three ways to read it,
and how well each holds for a shape whose mirror map is known.
"""

from pathlib import Path

import pymeshlab

import qgeo_filters as qg
from qgeo_filters.matching.symmetry_measure import symmetry_epsilon, symmetry_regions
from qgeo_filters.report.maps import plot_symmetry

cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
spectrum = qg.distance_spectrum(cow, k=20)
plot_symmetry(cow, symmetry_regions(spectrum, k0=5))

# %%
# The cow is its own mirror image in x = 0: the closest points say which vertices belong together.
from scipy.spatial import cKDTree

mirror = cKDTree(cow.vertices).query(cow.vertices * [-1, 1, 1])[1]
for reading in ("printed", "even", "absolute"):
    ratio = symmetry_epsilon(spectrum, mirror, reading=reading) / symmetry_epsilon(spectrum, reading=reading)
    print(f"{reading:9} mirror images differ {ratio:.2f} times as much as any two points")
