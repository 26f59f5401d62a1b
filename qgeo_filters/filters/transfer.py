"""TransferAttributes: values of one mesh on another that lies on the same surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import igl
import numpy as np

from qgeo_filters.errors import MeshError
from qgeo_filters.filters.base import Filter, registered
from qgeo_filters.interop import as_surface
from qgeo_filters.surface import Surface


@registered
class TransferAttributes(Filter):
    """Adds the attributes of another mesh, from the closest point on it, interpolated within its triangle.

    For after remeshing or simplification, where hosts drop or garble their attributes: keep the mesh from
    before and transfer from it.

    Parameters
    ----------
    source : mesh of any kind, or path
        Where the attributes come from; both meshes in one frame.
    names : sequence of str, optional
        Attributes to transfer; all of the source by default.

    Notes
    -----
    Floating-point values are interpolated. Whole numbers (labels, indices) and booleans are taken from the
    nearest corner instead, since an interpolated label means nothing. Vertex indices stay indices of the
    source.
    """

    def __init__(self, source: Any = None, names: Sequence[str] | None = None) -> None:
        self.source = source
        self.names = names

    @property
    def outputs(self) -> Mapping[str, str]:  # type: ignore[override]
        """The transferred attributes."""
        return {name: f"as on the source, {name}" for name in self._wanted(as_surface(self.source))}

    def _wanted(self, source: Surface) -> list[str]:
        names = list(source.attributes) if self.names is None else list(self.names)
        missing = [name for name in names if name not in source.attributes]
        if missing:
            known = ", ".join(sorted(source.attributes)) or "none"
            raise MeshError(f"the source has no attribute {missing[0]!r}; it has {known}")
        return names

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Transferred attributes by name."""
        if self.source is None:
            raise ValueError("TransferAttributes needs a source mesh: TransferAttributes(source=mesh)")
        source = as_surface(self.source)
        names = self._wanted(source)
        # libigl's tree compares with absolute tolerances: give it a surface of unit size.
        centre, unit = source.vertices.mean(axis=0), np.sqrt(source.area) or 1.0
        vertices = (source.vertices - centre) / unit
        faces = source.faces.astype(np.int64)
        _, face, closest = igl.point_mesh_squared_distance((surface.vertices - centre) / unit, vertices, faces)
        corners = source.faces[face]
        a, b, c = (vertices[corners[:, k]] for k in range(3))
        barycentric = np.clip(igl.barycentric_coordinates(closest, a, b, c), 0, 1)
        # A triangle without area has no barycentric coordinates: the nearest corner it is.
        gaps = np.stack([np.linalg.norm(closest - corner, axis=1) for corner in (a, b, c)], axis=1)
        nearest = np.eye(3)[gaps.argmin(axis=1)]
        bad = ~np.isfinite(barycentric).all(axis=1)
        barycentric[bad] = nearest[bad]
        barycentric /= barycentric.sum(axis=1, keepdims=True)
        nearest_corner = np.take_along_axis(corners, barycentric.argmax(axis=1)[:, None], axis=1)[:, 0]
        result = {}
        for name in names:
            values = source.attributes[name]
            if values.dtype.kind == "f":
                result[name] = np.einsum("ij,ij...->i...", barycentric, values[corners])
            else:
                result[name] = values[nearest_corner]
        return result
