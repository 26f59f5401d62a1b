"""The steps of a registration from coarse to fine: what is matched at each, and how strongly the shape is pulled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.deformation.arap import ArapSolver, Pull, Solve
from qgeo_filters.matching.level import Level, LevelPair
from qgeo_filters.matching.registration_stages import Stage, Stages


@dataclass(frozen=True, eq=False)
class Step:
    """One deformation and one matching.

    Attributes
    ----------
    k : int
        Number of Laplacian eigenfunctions.
    length : float
        Below which the deformed shape does not follow the map, in sqrt(area).
    stage : Stage
    fresh : bool
        Whether it is at the first size of its stage.
    mass : (n_x,) float64
        Area for which each vertex of X stands, 0 where the step before did not match it.
    pull : Pull
        The mass over the squared length.
    points_x, points_y : (s,), (t,) int
        The vertices that are matched after the deformation.
    """

    k: int
    length: float
    stage: Stage
    fresh: bool
    mass: FloatArray
    pull: Pull
    points_x: IndexArray
    points_y: IndexArray


@dataclass(frozen=True, eq=False)
class Schedule:
    """Steps in order, for maps of the vertices ``start`` of X: walked by the factorisation and by the registration."""

    start: IndexArray
    steps: tuple[Step, ...]

    @classmethod
    def of(cls, problem: LevelPair, stages: Stages, start: IndexArray | None = None) -> Schedule:
        """Schedule of some stages; the map to begin with is one of all vertices, unless ``start`` says of which."""
        points = np.arange(problem.x.n_vertices) if start is None else start
        return cls(points, tuple(_steps(problem, stages, points)))

    def prefactor(self, arap: ArapSolver) -> tuple[Solve, ...]:
        """A solver for each step, factorised in this thread, see `ArapSolver.prefactor`."""
        return tuple(arap.prefactor(step.pull) for step in self.steps)


def _steps(problem: LevelPair, stages: Stages, start: IndexArray) -> Iterator[Step]:
    x, y, given = problem.x, problem.y, problem.parameters
    widest = min(x.laplacian.shape[1], y.laplacian.shape[1])
    matched = start
    for number, stage in enumerate(stages):
        sizes = [k for k in stage.sizes if k <= widest] or [widest]
        for place, k in enumerate(sizes):
            length = stage.first * (stage.last / stage.first) ** (place / max(len(sizes) - 1, 1))
            at_the_end = number == len(stages) - 1 and k == sizes[-1]
            some = given.registration_points if k < stage.full and not at_the_end else None
            points_x, points_y = _matched(x, some), _matched(y, some)
            for _ in range(given.matchings):
                mass = mass_of(x, matched)
                pull = Pull((length, len(matched)), mass / length**2)
                yield Step(k, length, stage, place == 0, mass, pull, points_x, points_y)
                matched = points_x


def _matched(shape: Level, count: int | None) -> IndexArray:
    """The first farthest points, or all vertices."""
    return np.arange(shape.n_vertices) if count is None else shape.fps[:count]


def mass_of(shape: Level, points: IndexArray) -> FloatArray:
    """Area for which each vertex stands, (n,), 0 where it is none of the points."""
    mass = np.zeros(shape.n_vertices)
    mass[points] = area_shares(shape, points)
    return mass


def area_shares(shape: Level, points: IndexArray) -> FloatArray:
    """Part of the area for which each point stands: its own where all vertices take part, equal parts otherwise."""
    if len(points) == shape.n_vertices:
        return shape.areas[points]
    return np.full(len(points), 1.0 / max(len(points), 1))
