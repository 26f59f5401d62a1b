"""A shape at one of its resolutions: coarse where maps are sought, finer where they are finished."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Protocol

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.deformation.arap import ArapSolver
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.surface import Surface


class Level(ABC):
    """What registration needs of a shape at one resolution.

    Attributes
    ----------
    surface : Surface
        In the unit of the shape.
    unit : Surface
        The same with unit area, its centre of area in the origin.
    scale : float
    centre : (3,) float64
        ``unit.vertices * scale + centre`` are the vertices of ``surface``.
    """

    surface: Surface
    unit: Surface
    scale: float
    centre: FloatArray

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self.scale = float(np.sqrt(surface.area))
        self.centre = surface.vertex_areas @ surface.vertices / surface.area
        self.unit = Surface((surface.vertices - self.centre) / self.scale, surface.faces)

    @property
    def n_vertices(self) -> int:
        """Number of vertices at this resolution."""
        return self.unit.n_vertices

    @cached_property
    def areas(self) -> FloatArray:
        """Area of each vertex, (n,), summing to 1."""
        return self.unit.vertex_areas

    @cached_property
    def normals(self) -> FloatArray:
        """Angle-weighted unit normals, (n, 3)."""
        return self.unit.vertex_normals

    @cached_property
    def arap(self) -> ArapSolver:
        """Its as-rigid-as-possible deformation."""
        return ArapSolver(self.unit.vertices, self.unit.faces)

    @property
    @abstractmethod
    def laplacian(self) -> SingleArray:
        """Eigenfunctions of the Laplace-Beltrami operator of the unit-area shape, (n, up to 200)."""

    @property
    @abstractmethod
    def log_hks(self) -> FloatArray:
        """Logarithm of the heat kernel h(t; p, p) at a few times, (n, 3)."""

    @property
    @abstractmethod
    def fps(self) -> IndexArray:
        """Farthest points, (m,), the vertex of largest mean distance first."""


class LevelPair(Protocol):
    """Two shapes between which a map is registered, each at one resolution."""

    @property
    def x(self) -> Level:
        """The shape that is deformed."""

    @property
    def y(self) -> Level:
        """The shape that it is deformed onto."""

    @property
    def parameters(self) -> MatchingParameters:
        """What the registration goes by."""

    @property
    def profiles(self) -> tuple[SingleArray, SingleArray] | None:
        """Columns (n_x, k) and (n_y, k) that agree where a map agrees with what is known; None if nothing is."""


def reflected(surface: Surface) -> Surface:
    """Image in a mirror, vertex by vertex; faces turn over, so that normals keep pointing out."""
    return Surface(surface.vertices * np.array([-1.0, 1.0, 1.0]), surface.faces[:, ::-1])
