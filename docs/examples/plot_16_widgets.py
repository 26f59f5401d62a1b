"""
Widgets in a notebook
=====================

Two linked views of a match, the mirror map, a path under the mouse, the matrix beside the shape, a shape in motion.
Here a page is written, which opens offline in any browser with WebGL; in a notebook the widget is the last line of a
cell.

.. image:: ../images/widget_compare.png
   :alt: Two cows in linked views
   :width: 49%

.. image:: ../images/widget_symmetry.png
   :alt: A cow, its mirror map and its axis
   :width: 49%

.. image:: ../images/widget_geodesics.png
   :alt: A path and its geodesic curvature
   :width: 49%

.. image:: ../images/widget_matrix.png
   :alt: A distance matrix and one of its rows on the cow
   :width: 49%
"""

# sphinx_gallery_thumbnail_path = "images/widget_compare.png"
import tempfile
from pathlib import Path

import pymeshlab

import qgeo_filters as qg
import qgeo_widgets as qw

cow = qg.Surface.read(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj")
widget = qw.geodesics(cow, source=1151, target=2334, curvature_weight=0.1)
widget.path

# %%
# What the mouse does can be done, read and observed from Python.
widget.curvature_weight = 0.0
widget.path

# %%
# One page with everything in it.
with tempfile.TemporaryDirectory() as folder:
    page = Path(folder) / "path.html"
    widget.to_html(page)
    print(f"{page.stat().st_size / 1e6:.1f} MB")

# %%
# A shape in motion, played by the browser.
way = qg.interpolate(cow, cow.with_vertices(cow.vertices * [1, 1, 1.2]), [0, 0.5, 1])
film = qw.animate(way)
film.time = 0.5
film.frame
