"""A surface together with what the widgets show of it; expensive things come from the stages that filters share."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.known_parts import landmarks_left
from qgeo_filters.spectral.distance_spectrum import Landmarks, is_represented
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface

_KEPT_FIELDS = 64
#: Vertices up to which a spectrum or a symmetry is there in no time to speak of.
QUICK = 1500


class Shape:
    """Distances, eigenfunctions and attributes of a mesh of any host; lengths are in units of sqrt(area).

    Parameters
    ----------
    mesh : mesh object
        What `as_surface` takes; of a `Repair` what it made is shown.
    name : str
    curvature_weight : float
        Of the lifted metric; 0 is the surface's own.
    scalar : str, array-like or callable
        What lifts it, see `surface_scalar`.
    """

    def __init__(
        self, mesh: Any, name: str, curvature_weight: float = CURVATURE_WEIGHT, scalar: Scalar = "mean_curvature"
    ) -> None:
        self.surface: Surface = as_surface(mesh)
        self.repair = mesh if isinstance(mesh, Repair) else None
        self.name = name
        self.unit = float(np.sqrt(self.surface.area))
        self._weight = curvature_weight
        self._scalar = scalar
        self._fields: OrderedDict[int, FloatArray] = OrderedDict()

    @property
    def given(self) -> Surface:
        """The mesh that was given, of a `Repair` too: whose vertices files and functions mean."""
        return self.surface if self.repair is None else self.repair.given

    def vertices_of_given(self, vertices: Sequence[int]) -> list[int]:
        """Vertices of the mesh that was given, for vertices of what is shown."""
        return list(vertices) if self.repair is None else self.repair.origin[list(vertices)].tolist()

    def landmarks_of_given(self, vertices: IndexArray) -> list[int]:
        """Vertices of what is shown, for landmarks on the mesh that was given; see `landmarks_left`."""
        left = vertices if self.repair is None else landmarks_left(self.repair, vertices, self.name)
        return [int(vertex) for vertex in left]

    @cached_property
    def metric(self) -> LiftedMetric:
        """The metric that distances, eigenfunctions and paths are measured in."""
        return stages.metric_of(self.surface, self._scalar, self._weight)

    def metric_of_weight(self, curvature_weight: float) -> LiftedMetric:
        """The metric that the same scalar gives with another weight."""
        # Not a stage: the many metrics that a slider passes through would keep their graphs.
        return lifted_metric(self.surface, self._scalar, curvature_weight)

    @cached_property
    def spectrum(self) -> Spectrum:
        """First eigenpairs of the distance operator."""
        k = min(EIGENPAIRS, self.surface.n_vertices)
        return stages.spectrum_of(self.metric, k, "area", _landmarks(self.surface), "graph", 1e-3)

    @property
    def spectrum_takes_long(self) -> bool:
        """Whether eigenpairs are still to be computed, of a surface for which that takes seconds and more."""
        return "spectrum" not in self.__dict__ and self.surface.n_vertices > QUICK

    def distances_from(self, vertex: int) -> FloatArray:
        """Quasi-geodesic distance of every vertex from one, (n,), in units of sqrt(area); the last 64 are kept."""
        field = self._fields.get(vertex)
        if field is None:
            field = distances(self.surface, [vertex], self.metric)[0] / self.unit
            field.setflags(write=False)
            self._fields[vertex] = field
            if len(self._fields) > _KEPT_FIELDS:
                self._fields.popitem(last=False)
        self._fields.move_to_end(vertex)
        return field

    def eigenfunction(self, k: int) -> FloatArray:
        r"""Eigenfunction k (from 1) without unit, :math:`\phi_k \sqrt{A}`, shape (n,)."""
        if not 1 <= k <= self.spectrum.k:
            raise ParameterError(f"{self.name} has eigenfunctions 1 to {self.spectrum.k}, not {k}")
        return self.spectrum.eigenfunctions[:, k - 1] * self.unit

    def attribute(self, name: str, column: int = 1) -> FloatArray:
        """Column (from 1) of a named attribute as float64, shape (n,)."""
        if name not in self.surface.attributes:
            known = ", ".join(sorted(self.surface.attributes)) or "none"
            raise ParameterError(f"{self.name} has no attribute {name!r} (it has: {known})")
        values = self.surface.attributes[name]
        if values.dtype.kind not in "biuf":
            raise ParameterError(f"attribute {name!r} holds {values.dtype}, no numbers")
        table = values.reshape(self.surface.n_vertices, -1).astype(np.float64)
        return table[:, min(column, table.shape[1]) - 1]

    def attribute_or_nan(self, name: str, column: int = 1) -> FloatArray:
        """The same; NaN throughout where there is no such attribute."""
        if not self.columns(name):
            return np.full(self.surface.n_vertices, np.nan)
        return self.attribute(name, column)

    def columns(self, name: str) -> int:
        """Number of columns of an attribute; 0 where it is absent."""
        values = self.surface.attributes.get(name)
        return 0 if values is None else int(np.prod(values.shape[1:], dtype=int))

    def described(self, vertex: int) -> list[tuple[str, str]]:
        """Attributes of a vertex as names and values for a reader."""
        lines = []
        for name, values in sorted(self.surface.attributes.items()):
            entries = np.atleast_1d(values[vertex]).ravel()
            shown = ", ".join(f"{v:.4g}" if entries.dtype.kind == "f" else str(v) for v in entries[:4])
            lines.append((name, shown + (", …" if len(entries) > 4 else "")))
        return lines


def _landmarks(surface: Surface) -> Landmarks:
    """None while the full matrix is small; beyond that as many landmarks as give a true picture quickly, or a proxy."""
    if is_represented(surface, "auto"):
        return "auto"
    return None if surface.n_vertices <= 8000 else 1000
