"""A validated triangle mesh: the ground floor that every algorithm of the package stands on."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from os import PathLike
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, RepairOption
from qgeo_filters.errors import DisconnectedError, MeshError, ParameterError
from qgeo_filters.html_repr import card, shown
from qgeo_filters.io.formats import path_in_errors, read_raw, write_raw
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.mesh_connectivity import MeshConnectivity
from qgeo_filters.repair.sound import sound_mesh
from qgeo_filters.repair.triangle_soup import MOST_AREA_LOST, most_lost, repaired_mesh
from qgeo_filters.repair.welding import not_welded, welded
from qgeo_filters.repair.winding import Winding, winding
from qgeo_filters.triangle_geometry import face_crosses, unit_normals
from qgeo_filters.validation import checked_attributes, checked_faces, checked_repair, checked_vertices, listed, owned


class Surface(MeshConnectivity):
    """A triangle mesh whose arrays are known to be good.

    Parameters
    ----------
    vertices : array-like, shape (n, 3)
        Coordinates, in any unit of length. Copied to float64.
    faces : array-like, shape (m, 3)
        Vertex indices from 0. Copied to int32.
    attributes : mapping of str to array-like, shape (n,) or (n, ...), optional
        Named values per vertex. Copied.

    Raises
    ------
    MeshError
        Empty, wrong shape, coordinates that are not finite, indices out of range, a face that names a
        vertex twice, an attribute of the wrong length. The message says which index and how many.

    Notes
    -----
    Immutable: attributes cannot be set, all arrays are read-only for good, derived quantities are computed once,
    on first use; `with_vertices` and `with_attributes` give changed copies. A mesh that is not manifold, in several
    pieces or not orientable can be held and described; whatever needs more says so through `require_manifold` and
    `require_connected`.

    Examples
    --------
    >>> corner = qg.Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 3, 1], [0, 2, 3]])
    >>> corner
    Surface(4 vertices, 3 faces)
    >>> corner.area, corner.is_closed, corner.boundary_vertices
    (1.5, False, array([1, 2, 3], dtype=int32))
    >>> corner.with_attributes({"height": [0, 0, 0, 1]}).attributes["height"]
    array([0, 0, 0, 1])
    >>> qg.Surface(corner.vertices, [[0, 1, 7]])
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.MeshError: faces[0] refers to vertex 7, but there are 4 vertices, numbered from 0 (1 ...
    """

    attributes: Mapping[str, np.ndarray]

    def __init__(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        checked = owned(checked_vertices(vertices))
        self.__dict__.update(
            vertices=checked,
            faces=owned(checked_faces(faces, len(checked))),
            attributes=checked_attributes(attributes or {}, len(checked)),
        )

    def __setattr__(self, name: str, value: object) -> None:
        # cached_property writes to __dict__ and does not come here.
        way_out = "attributes" if name == "attributes" else "vertices"
        advice = f"; surface.with_{way_out}(...) gives another one" if name in ("vertices", "attributes") else ""
        raise AttributeError(f"cannot set {name!r}: a Surface never changes{advice}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"cannot delete {name!r}: a Surface never changes")

    def __repr__(self) -> str:
        names = f", attributes={sorted(self.attributes)}" if self.attributes else ""
        return f"Surface({self.n_vertices} vertices, {self.n_faces} faces{names})"

    def _repr_html_(self) -> str:
        size = np.ptp(self.vertices, axis=0)
        facts = {
            "vertices": self.n_vertices,
            "faces": self.n_faces,
            "extent": " x ".join(map(shown, size.tolist())),
            "area": self.area,
            "pieces": int(self.components[0] - self.unreferenced_vertices.size),
            "closed": self.is_closed,
            "manifold": self.is_manifold,
        }
        table = [(name, f"{values.dtype}, {values.shape}") for name, values in sorted(self.attributes.items())]
        return card("Surface", facts, table=table, columns=("attribute", "values") if table else ())

    def __getstate__(self) -> dict[str, Any]:
        return {"vertices": self.vertices, "faces": self.faces, "attributes": dict(self.attributes)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]

    # -- making others ------------------------------------------------------------------------------

    @classmethod
    def from_raw(cls, raw: RawMesh) -> Surface:
        """Surface of arrays as they came from a file or another library; raises `MeshError` for what cannot be one."""
        return cls(raw.vertices, raw.faces, raw.attributes)

    @classmethod
    def read(cls, path: str | PathLike[str], *, repair: RepairOption = False) -> Surface:
        """Surface from a file.

        Parameters
        ----------
        path : path
            OFF, OBJ, PLY, STL, glTF, TOSCA's .vert/.tri and .mat; VTK, Gmsh, GIFTI and FreeSurfer's surfaces where
            the extras are installed. Told by the suffix, see `io.formats`.
        repair : bool or "force"
            Triangulate polygons and make the mesh manifold and one piece; `repair_surface` also says what was changed.
            More than a hundredth of the area is removed only with "force". (For "wrap" see `wrap_surface`.)

        Raises
        ------
        FileNotFoundError, IsADirectoryError
        MeshError
            An unknown suffix, a malformed file, polygons, an invalid mesh; the message starts with the path.
        """
        if checked_repair(repair) == "wrap":
            raise ParameterError("to wrap a file, call wrap_surface(path) or as_surface(path, repair='wrap')")
        raw = read_raw(path, repair=bool(repair))
        with path_in_errors(path):
            return cls.from_raw(repaired_mesh(sound_mesh(raw), most_lost=most_lost(repair)).mesh if repair else raw)

    def write(self, path: str | PathLike[str]) -> None:
        """Write to a file, atomically; PLY, VTK's and CSV keep all attributes, others warn, see `io.formats`."""
        write_raw(path, self.vertices, self.faces, self.attributes)

    def with_attributes(self, attributes: Mapping[str, npt.ArrayLike]) -> Surface:
        """Surface with these attributes added, equal names replaced. Derived quantities are shared."""
        other = object.__new__(Surface)
        together = MappingProxyType({**self.attributes, **checked_attributes(attributes, self.n_vertices)})
        other.__dict__.update(self.__dict__, attributes=together)
        return other

    def turned_over(self) -> Surface:
        """The same surface with all faces looking to the other side."""
        return Surface(self.vertices, self.faces[:, ::-1], self.attributes)

    def with_vertices(self, vertices: npt.ArrayLike) -> Surface:
        """Surface of the same faces and attributes at other positions: another pose."""
        if np.shape(vertices) != self.vertices.shape:
            raise MeshError(f"the pose has shape {np.shape(vertices)}, expected {self.vertices.shape}")
        return Surface(vertices, self.faces, self.attributes)

    def submesh(self, keep: npt.NDArray[np.bool_]) -> tuple[Surface, npt.NDArray[np.int64]]:
        """Part of the surface on the kept vertices, and the original index of each of its vertices."""
        origin = np.flatnonzero(keep)
        renumbered = np.full(self.n_vertices, -1, dtype=np.int32)
        renumbered[origin] = np.arange(len(origin))
        faces = renumbered[self.faces]
        faces = faces[(faces >= 0).all(axis=1)]
        attributes = {name: values[origin] for name, values in self.attributes.items()}
        return Surface(self.vertices[origin], faces, attributes), origin

    def largest_component(self) -> tuple[Surface, npt.NDArray[np.int64]]:
        """Piece of largest area, and the original index of each of its vertices."""
        _, labels = self.components
        area = np.bincount(labels, weights=self.vertex_areas)
        return self.submesh(labels == area.argmax())

    # -- metric quantities --------------------------------------------------------------------------

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """Length of each edge, shape (E,), in the unit of the vertices."""
        a, b = self.edges.T
        return owned(np.linalg.norm(self.vertices[a] - self.vertices[b], axis=1))

    @cached_property
    def _face_crosses(self) -> FloatArray:
        return owned(face_crosses(self.vertices, self.faces))

    @cached_property
    def face_areas(self) -> FloatArray:
        """Area of each triangle, shape (m,)."""
        return owned(0.5 * np.linalg.norm(self._face_crosses, axis=1))

    @cached_property
    def area(self) -> float:
        """Total area; ``sqrt(area)`` is the package's unit of length for parameters without a unit."""
        return float(self.face_areas.sum())

    @cached_property
    def vertex_areas(self) -> FloatArray:
        """Barycentric area of each vertex (a third of its triangles), shape (n,); they sum to `area`."""
        return owned(np.bincount(self.faces.ravel(), np.repeat(self.face_areas / 3, 3), minlength=self.n_vertices))

    @cached_property
    def face_normals(self) -> FloatArray:
        """Unit normal of each triangle, shape (m, 3); zero where the triangle has no area."""
        return owned(unit_normals(self._face_crosses))

    @cached_property
    def corner_angles(self) -> FloatArray:
        """Angle of each triangle at each of its corners, shape (m, 3), radians."""
        corners = np.ascontiguousarray(self.vertices.T)[:, self.faces.T]  # (coordinate, corner, face)
        there = corners[:, [1, 2, 0]] - corners
        back = -there[:, [2, 0, 1]]
        (a, b, c), (u, v, w) = there, back
        cross = np.sqrt((b * w - c * v) ** 2 + (c * u - a * w) ** 2 + (a * v - b * u) ** 2)
        # atan2 keeps full precision near 0 and pi, where arccos loses half of the digits.
        angles = np.ascontiguousarray(np.arctan2(cross, a * u + b * v + c * w).T)
        return owned(angles)

    @cached_property
    def vertex_normals(self) -> FloatArray:
        """Angle-weighted unit normal of each vertex, shape (n, 3); zero without faces or where they cancel."""
        corner, weighted = self.faces.T.ravel(), self.corner_angles.T[..., None] * self.face_normals
        total = np.column_stack(
            [np.bincount(corner, weighted[..., axis].ravel(), minlength=self.n_vertices) for axis in range(3)]
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        # At the seam of a one-sided surface opposite normals cancel up to rounding, which has no direction.
        return owned(np.divide(total, length, out=np.zeros_like(total), where=length > 1e-12))

    # -- sides and seams ----------------------------------------------------------------------------

    @cached_property
    def winding(self) -> Winding:
        """Which side the faces take for out: "outward", "inward", "mixed" or "undetermined", see `repair.winding`."""
        return winding(self.vertices, self.faces)

    @cached_property
    def unwelded_vertices(self) -> IndexArray:
        """Boundary vertices that lie where others do, along edges of both: what ``repair=True`` joins with those."""
        if self.is_closed:
            return owned(np.empty(0, dtype=np.int64))
        joined, _ = welded(self.vertices, self.faces)
        return owned(np.flatnonzero(joined != np.arange(self.n_vertices)))

    # -- requirements -------------------------------------------------------------------------------

    def require_connected(self, purpose: str) -> None:
        """Raise `DisconnectedError`, with the sizes of the pieces, unless all vertices are connected."""
        count, labels = self.components
        if count == 1:
            return
        sizes = np.sort(np.bincount(labels))[::-1]
        loose = self.unreferenced_vertices
        without = f", {loose.size} of them single vertices without faces ({listed(loose)})" if loose.size else ""
        largest = np.bincount(labels, self.vertex_areas).max()
        option = "True" if largest >= (1 - MOST_AREA_LOST) * self.area else "'force'"
        double = self.unwelded_vertices.size
        raise DisconnectedError(
            f"{purpose} needs a mesh in one piece, but there are {count} pieces of {listed(sizes)} vertices{without}; "
            + (not_welded(double) if double else f"take surface.largest_component()[0], or repair={option}")
        )
