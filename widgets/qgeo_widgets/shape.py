"""A mesh together with what the widgets show of it; expensive things come from the stages that filters share."""

from __future__ import annotations

from collections import OrderedDict
from functools import cached_property
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, RepairOption
from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.filters.repaired import repaired_values
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.matching.known_parts import landmarks_left
from qgeo_filters.repair.triangle_soup import Pieces
from qgeo_filters.spectral.distance_spectrum import Landmarks, is_represented
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface
from qgeo_widgets.shown_mesh import ShownMesh

_KEPT_FIELDS = 64
#: Vertices up to which a spectrum or a symmetry is there in no time to speak of.
QUICK = 1500


class Shape:
    """Distances, eigenfunctions and attributes of a mesh of any host; lengths are in units of sqrt(area).

    What is shown is the mesh as it was given, and all vertices are its own. What is measured is that, or its repair, or
    the closed surface around it; fields are carried to the given vertices as filters do, NaN where one has no place.

    Parameters
    ----------
    mesh : mesh object
        What `as_surface` takes, or a `Repair`.
    name : str
    curvature_weight : float
        Of the lifted metric; 0 is the surface's own.
    scalar : str, array-like or callable
        What lifts it, see `surface_scalar`.
    repair, pieces
        See `ShownMesh.of`.

    Attributes
    ----------
    surface : Surface
        The mesh that was given, which is shown.
    repair : Repair or None
    measured : Surface
        What lengths are measured on.
    unit : float
        Its sqrt(area).
    """

    def __init__(
        self,
        mesh: Any,
        name: str,
        curvature_weight: float = CURVATURE_WEIGHT,
        scalar: Scalar = "mean_curvature",
        repair: RepairOption = "auto",
        pieces: Pieces = "largest",
    ) -> None:
        self._mesh = ShownMesh.of(mesh, repair, pieces)
        self.surface, self.repair, self.measured = self._mesh.surface, self._mesh.repair, self._mesh.measured
        self.name = name
        self.unit = float(np.sqrt(self.measured.area))
        self._weight = curvature_weight
        self.scalar: Scalar = scalar if self.repair is None else repaired_values(self.repair, scalar)
        self._fields: OrderedDict[int, FloatArray] = OrderedDict()

    @property
    def to_match(self) -> tuple[Any, RepairOption]:
        """What the stages of matching take, and what is still to be repaired of it."""
        return self._mesh.to_match

    @property
    def report(self) -> str:
        """What is measured in place of the mesh, a sentence; empty where that is the mesh itself."""
        return "" if self.repair is None else "; ".join(self.repair.report)

    # -- places -------------------------------------------------------------------------------------

    @cached_property
    def stand_ins(self) -> IndexArray:
        """Measured vertex that stands for each given one, (n,); -1 where there is none."""
        return np.arange(self.surface.n_vertices) if self.repair is None else self.repair.vertex_of_original

    def stand_in(self, vertex: int) -> int:
        """Measured vertex that stands for a given one.

        Raises
        ------
        MeshError
            One that a repair removed, or that lies deep inside a wrap.
        """
        found = int(self.stand_ins[vertex])
        if found < 0:
            raise MeshError(f"vertex {vertex} of {self.name} has no place on what is measured ({self.report})")
        return found

    def carried(self, values: np.ndarray) -> np.ndarray:
        """Values of the measured vertices at the given ones, (n, ...); NaN, -1 or False where one has no place."""
        return values if self.repair is None else self.repair.map_back(values)

    def on_measured(self, values: np.ndarray) -> np.ndarray:
        """Values of the given vertices at the measured ones."""
        return values if self.repair is None else values[self.repair.origin]

    @cached_property
    def normals(self) -> FloatArray:
        """Which way each vertex faces, (n, 3): out of what is measured, however the faces of the mesh are written."""
        own = self.surface.vertex_normals
        if self.repair is None:
            return own
        carried = self.repair.map_back(self.measured.vertex_normals)
        return np.where(np.isfinite(carried), carried, own)

    def check_landmarks(self, vertices: IndexArray) -> None:
        """Raise `ParameterError` for a landmark on what the repair removed, far from all that is left."""
        if self.repair is not None:
            landmarks_left(self.repair, vertices, self.name)

    # -- what is measured ---------------------------------------------------------------------------

    @cached_property
    def metric(self) -> LiftedMetric:
        """The metric that distances, eigenfunctions and paths are measured in."""
        return stages.metric_of(self.measured, self.scalar, self._weight)

    def metric_of_weight(self, curvature_weight: float) -> LiftedMetric:
        """The metric that the same scalar gives with another weight."""
        # Not a stage: the many metrics that a slider passes through would keep their graphs.
        return lifted_metric(self.measured, self.scalar, curvature_weight)

    @cached_property
    def spectrum(self) -> Spectrum:
        """First eigenpairs of the distance operator, on the measured vertices."""
        k = min(EIGENPAIRS, self.measured.n_vertices)
        return stages.spectrum_of(self.metric, k, "area", _landmarks(self.measured), "graph", 1e-3)

    @property
    def spectrum_takes_long(self) -> bool:
        """Whether eigenpairs are still to be computed, of a surface for which that takes seconds and more."""
        return "spectrum" not in self.__dict__ and self.measured.n_vertices > QUICK

    def distances_from(self, vertex: int) -> FloatArray:
        """Quasi-geodesic distance of every vertex from one, (n,), in units of sqrt(area); the last 64 are kept."""
        field = self._fields.get(vertex)
        if field is None:
            row = distances(self.measured, [self.stand_in(vertex)], self.metric)[0]
            field = self.carried(row) / self.unit
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
        return self.carried(self.spectrum.eigenfunctions[:, k - 1]) * self.unit

    # -- attributes of the mesh ---------------------------------------------------------------------

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
