"""TransferAttributes: values of one mesh on another, on the same surface or in another pose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from qgeo_filters._typing import RepairOption
from qgeo_filters.closest_points import closest_points
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered
from qgeo_filters.filters.repaired import other_mesh, repair_now
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.maps.barycentric import BarycentricMap
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface


@registered
class TransferAttributes(Filter):
    """Adds the attributes of another mesh: from the closest point on it, or from the corresponding one.

    By closest points for after remeshing or simplification, where hosts drop or garble their attributes: keep the mesh
    from before and transfer from it. Along a correspondence for what was drawn or measured on another pose.

    Parameters
    ----------
    source : mesh of any kind, or path
        Where the attributes come from; without a correspondence, both meshes in one frame.
    names : str or sequence of str, optional
        Attributes to transfer; all of the source by default.
    correspondence : bool, or result of `match`
        Whether to take the corresponding point instead of the closest: True finds the map from the mesh to the source
        as the `Correspondence` filter does (and together with it only once); a result of ``match(mesh, source)`` is
        taken as it is.

    Notes
    -----
    Floating-point values are interpolated within the triangle. Whole numbers (labels, indices) and booleans are taken
    from the nearest corner instead, since an interpolated label means nothing. Vertex indices stay indices of the
    source. Where neither `names` are given nor the source is a `Surface`, `outputs` is empty until the first call: it
    reads no file and no mesh of a host.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> rich = surface.with_attributes({"height": surface.vertices[:, 2]})
    >>> bare, _ = surface.submesh(surface.vertices[:, 2] > 0)
    >>> out = qg.TransferAttributes(source=rich)(bare)
    >>> np.allclose(out.attributes["height"], bare.vertices[:, 2])
    True
    """

    pointwise = True

    names_: list[str]
    """Attributes that the last call transferred."""

    values_: dict[str, np.ndarray]
    """Their values at the vertices that were given."""

    def __init__(
        self,
        *,
        source: Any = None,
        names: str | Sequence[str] | None = None,
        correspondence: bool | MatchResult = False,
    ) -> None:
        self.source = source
        self.names = names
        self.correspondence = correspondence

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """From the surface itself, with one attribute."""
        return cls(source=surface.with_attributes({"height": surface.vertices[:, 2]}))

    @property
    def outputs(self) -> Mapping[str, str]:  # type: ignore[override]
        """The transferred attributes: those of `names` or of a `Surface`; of any other source once it has been read."""
        names: Iterable[str] = getattr(self, "names_", ())
        if self.names is not None:
            names = self._chosen(self.names)
        elif isinstance(self.source, Surface):
            names = self.source.attributes
        return {name: f"as on the source, {name}" for name in names}

    @staticmethod
    def _chosen(names: str | Sequence[str]) -> list[str]:
        return [names] if isinstance(names, str) else list(names)

    def _wanted(self, source: Surface) -> list[str]:
        names = list(source.attributes) if self.names is None else self._chosen(self.names)
        missing = [name for name in names if name not in source.attributes]
        if missing:
            known = ", ".join(sorted(source.attributes)) or "none"
            raise MeshError(f"the source has no attribute {missing[0]!r}; it has {known}")
        return names

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Transferred attributes by name."""
        if self.source is None:
            raise ParameterError("TransferAttributes needs a source mesh: TransferAttributes(source=mesh)")
        source, repair_source = other_mesh(self.source, self.repair_)
        surface_of_source = source.given if isinstance(source, Repair) else source
        self.names_ = self._wanted(surface_of_source)
        shape = repair_now(self.repair_, surface)
        place = self._place(shape, source, repair_source, progress)
        self.values_ = {name: self._pulled_back(place, surface_of_source.attributes[name]) for name in self.names_}
        here = shape.origin if isinstance(shape, Repair) else slice(None)
        return {name: values[here] for name, values in self.values_.items()}

    def on_given(self, repair: Repair, added: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The values at the points that belong to the vertices that were given."""
        return {name: values for name, values in self.values_.items() if name in added}

    def _pulled_back(self, place: BarycentricMap, values: np.ndarray) -> np.ndarray:
        """Values at the points, of a kind that has something to say where a vertex had to go, as `Repair.map_back`."""
        signed = self.repair_ is not None and values.dtype.kind == "u"
        return place.pulled_back(values.astype(np.int64) if signed else values)

    def _place(
        self, shape: Surface | Repair, source: Surface | Repair, repair: RepairOption, progress: bool
    ) -> BarycentricMap:
        """Point of the source for each vertex that was given."""
        if self.correspondence is True:
            return stages.correspondence_of(shape, source, True, progress, repair_y=repair, partial=False).barycentric
        surface, onto = (one.given if isinstance(one, Repair) else one for one in (shape, source))
        if self.correspondence is False:
            place = closest_points(surface.vertices, onto)
            return place if isinstance(shape, Surface) else place.only(shape.vertex_of_original >= 0)
        place = self.correspondence.barycentric
        if len(place.faces) != surface.n_vertices or place.faces.max() >= onto.n_faces:
            raise MeshError(
                f"the correspondence maps {len(place.faces)} vertices to triangles up to {place.faces.max()}, but the "
                f"mesh has {surface.n_vertices} vertices and the source {onto.n_faces} triangles"
            )
        return place
