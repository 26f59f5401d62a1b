"""From a coarse map to one between all vertices: eigenfunctions, positions and normals agree together.

References
----------
Eisenberger, Laehner, Cremers, "Smooth shells: multi-scale shape registration with functional maps", CVPR 2020,
for intrinsic and extrinsic features from coarse to fine; Ren, Melzi, Wonka, Ovsjanikov, "Discrete
optimization for shape matching", SGP 2021, for maps in both directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.deformation.arap import Solve
from qgeo_filters.matching.level import LevelPair
from qgeo_filters.matching.maps.functional_map import nearest_neighbors_both_ways
from qgeo_filters.matching.schedule import Schedule, Step, area_shares


@dataclass(frozen=True, eq=False)
class DenseMap:
    """A map between all vertices, in both directions.

    Attributes
    ----------
    p2p : (n_x,) int
    inverse : (n_y,) int
    positions : (n_x, 3) float64
        X deformed onto the unit-area Y.
    embedding_x, embedding_y : (n, d) float32
        What was compared: nearest rows are matched.
    """

    p2p: IndexArray
    inverse: IndexArray
    positions: FloatArray
    embedding_x: SingleArray
    embedding_y: SingleArray


def register(
    problem: LevelPair, p2p: IndexArray, schedule: Schedule, solvers: tuple[Solve, ...] | None = None
) -> DenseMap:
    """Map between all vertices from one of the schedule's starting points that is right in the large.

    From low to high frequencies, each vertex of X is matched with the vertex of Y that is nearest in three things
    together: the Laplacian's eigenfunctions (through the functional map of the current matches), the position, and
    the normal, of X deformed towards its matches as rigidly as possible. Matches are taken in both directions, so
    that no part of Y stays uncovered. The maps must keep the orientation: for one that reverses it, pass the problem
    `with_mirrored_y`.

    Parameters
    ----------
    p2p : (s,) int
        Vertex of Y for each of ``schedule.start``.
    solvers : tuple, optional
        ``schedule.prefactor(problem.x.arap)``, where several maps are registered side by side.
    """
    state = _State(problem, p2p, schedule.start)
    if solvers is None:
        solvers = schedule.prefactor(problem.x.arap)
    for step, solve in zip(schedule.steps, solvers, strict=True):
        state.deform(step, solve)
        state.match(step)
    return DenseMap(state.forth, state.back, state.positions, *state.embeddings)


class _State:
    """Matches in both directions, and the deformed shape; changed by each step."""

    def __init__(self, problem: LevelPair, p2p: IndexArray, start: IndexArray) -> None:
        self.problem, self.x, self.y = problem, problem.x, problem.y
        self.points_x, self.forth = start, p2p
        self.points_y, self.back = np.zeros(0, np.int64), np.zeros(0, np.int64)
        self.positions = np.zeros((0, 3))
        self.functional = np.zeros((0, 0), np.float32)
        self.embeddings: tuple[SingleArray, SingleArray] = (np.zeros((0, 0), np.float32),) * 2
        self.target: _Target | None = None

    def deform(self, step: Step, solve: Solve) -> None:
        """Pull X towards the means of its matches, as rigidly as possible."""
        x, stage, given = self.x, step.stage, self.problem.parameters
        self.functional = self._functional_map(step.k)
        targets = self._targets()
        first = not len(self.positions)
        if first:
            smooth = stage.untwist or not step.mass.all()
            self.positions = self._smoothed(step.k, targets, step.mass) if smooth else targets
        wide = given.wide_rotations if stage.untwist else given.narrow_rotations
        for _ in range(max(stage.iterations, given.first_iterations if first else 0)):
            self.positions = x.arap.iterate(solve, step.pull, self.positions, targets, wide if step.fresh else 1)

    def match(self, step: Step) -> None:
        """Match the points of the step in both directions."""
        x, k, stage = self.x, step.k, step.stage
        profiles = self.problem.profiles
        deformed = x.unit.with_vertices(self.positions)
        left = [
            _weight(k) * (x.laplacian[:, :k] @ self.functional), self.positions, stage.normals * deformed.vertex_normals
        ]  # fmt: skip
        if stage.hks:
            left.append(stage.hks * x.log_hks)
        if profiles is not None:
            left.append(self.problem.parameters.hint_weight * profiles[0])
        self.points_x, self.points_y = step.points_x, step.points_y
        if self.target is None or not self.target.serves(step):
            self.target = _Target.of(self.problem, step)
        target, embedding = self.target, _columns(left)
        self.embeddings = embedding, target.embedding
        some = target.embedding[self.points_y]
        forth, back = nearest_neighbors_both_ways(embedding[self.points_x], some, target.tree)
        self.forth, self.back = self.points_y[forth], self.points_x[back]

    def _pairs(self) -> tuple[IndexArray, IndexArray, FloatArray]:
        """Matched vertices of X and of Y, and the area that each match stands for."""
        x, y = self.x, self.y
        some = np.concatenate([self.points_x, self.back]), np.concatenate([self.forth, self.points_y])
        return *some, np.concatenate([area_shares(x, self.points_x), area_shares(y, self.points_y)])

    def _functional_map(self, k: int) -> SingleArray:
        i, j, weight = self._pairs()
        left, right = self.x.laplacian[i, :k], self.y.laplacian[j, :k]
        weighted = left * weight[:, None].astype(np.float32)
        return np.linalg.solve(weighted.T @ left, weighted.T @ right)

    def _smoothed(self, k: int, targets: FloatArray, mass: FloatArray) -> FloatArray:
        """Positions (n_x, 3) that the first eigenfunctions make of those of the matched points."""
        low = self.x.laplacian[:, :k].astype(np.float64)
        weighted = low * mass[:, None]
        return low @ np.linalg.solve(weighted.T @ low, weighted.T @ targets)

    def _targets(self) -> FloatArray:
        """Mean position on Y of the matches of each vertex of X, (n_x, 3)."""
        i, j, weight = self._pairs()
        n = self.x.n_vertices
        total = np.bincount(i, weight, n)
        moved = self.y.unit.vertices[j] * weight[:, None]
        sums = np.column_stack([np.bincount(i, moved[:, axis], n) for axis in range(3)])
        return sums / np.where(total > 0, total, 1.0)[:, None]


@dataclass(frozen=True, eq=False)
class _Target:
    """Y as it is compared in some steps, and a tree of its points."""

    step: Step
    embedding: SingleArray
    tree: cKDTree

    @classmethod
    def of(cls, problem: LevelPair, step: Step) -> _Target:
        y, k, stage = problem.y, step.k, step.stage
        right = [_weight(k) * y.laplacian[:, :k], y.unit.vertices, stage.normals * y.normals]
        if stage.hks:
            right.append(stage.hks * y.log_hks)
        if problem.profiles is not None:
            right.append(problem.parameters.hint_weight * problem.profiles[1])
        embedding = _columns(right)
        return cls(step, embedding, cKDTree(embedding[step.points_y]))

    def serves(self, step: Step) -> bool:
        """Whether another step compares the same: matchings of one size do."""
        mine = self.step
        return step.k == mine.k and step.stage is mine.stage and step.points_y is mine.points_y


def _weight(k: int) -> float:
    """By which eigenfunctions weigh as coordinates do: their sum over k is about k / area."""
    return float(1 / (k * np.sqrt(np.pi)))


def _columns(parts: list[npt.NDArray]) -> SingleArray:
    """Arrays (n, ...) side by side in single precision, (n, d)."""
    result = np.empty((len(parts[0]), sum(part.shape[1] for part in parts)), np.float32)
    first = 0
    for part in parts:
        result[:, first : first + part.shape[1]] = part
        first += part.shape[1]
    return result
