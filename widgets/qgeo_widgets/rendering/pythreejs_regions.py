"""What a pane draws over the triangles in which regions meet, so that their borders are sharp."""

from __future__ import annotations

from typing import Any

import numpy as np
import pythreejs as three

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.region_borders import region_borders

# Before the mesh, which is pushed back by twice as much, and behind lines, which are not.
_MATERIAL = {
    "vertexColors": "VertexColors",
    "side": "DoubleSide",
    "polygonOffset": True,
    "polygonOffsetFactor": 1.0,
    "polygonOffsetUnits": 1.0,
}


class RegionOverlay:
    """Pieces of one region each, over a mesh of these points, normals and faces."""

    def __init__(self, scene: Any, points: FloatArray, normals: FloatArray, faces: IntArray) -> None:
        self._scene, self._points, self._normals, self._faces = scene, points, normals, faces
        self._mesh: Any = None
        self._retired: list[Any] = []

    def show(self, labels: IndexArray | None, palette: FloatArray | None) -> None:
        """Regions (n,) in colours (k, 3), the last one for negative labels; None shows nothing."""
        if self._mesh is not None:
            self._scene.remove(self._mesh)
            # Closed one change later: the front end may still be drawing it.
            self._close_retired()
            self._retired.append(self._mesh)
            self._mesh = None
        if labels is None or palette is None:
            return
        borders = region_borders(self._faces, labels)
        if not len(borders.labels):
            return
        arrays = {
            "position": borders.at_points(self._points),
            "normal": borders.at_points(self._normals),
            "color": np.repeat(palette[borders.labels], 3, axis=0),
        }
        attributes = {
            name: three.BufferAttribute(np.ascontiguousarray(each, dtype=np.float32), normalized=False)
            for name, each in arrays.items()
        }
        self._mesh = three.Mesh(three.BufferGeometry(attributes=attributes), three.MeshLambertMaterial(**_MATERIAL))
        self._scene.add(self._mesh)

    def close(self) -> None:
        """Free what was drawn; what still is belongs to the scene."""
        self._close_retired()

    def _close_retired(self) -> None:
        for mesh in self._retired:
            close_tree(mesh)
        self._retired.clear()
