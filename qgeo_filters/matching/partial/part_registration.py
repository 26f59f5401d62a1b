"""A part deformed onto the whole, from a coarse map to one of all vertices.

As `smooth_shells.register`, but for what a part must not do: the whole has no partner on it for most of its points. So
each vertex of the part is drawn to its match, and of the points of the whole only those draw back whose match is
mutual. References stand there; for the functional map of a part see Rodola, Cosmo, Bronstein, Torsello, Cremers,
"Partial functional correspondence", CGF 2017.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.deformation.arap import Pull, Solve
from qgeo_filters.matching.known_parts import KnownParts
from qgeo_filters.matching.maps.functional_map import nearest_neighbors_both_ways
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.registration_stages import Stage, Stages

# Relative to the mean diagonal.
_RIDGE = 1e-6


@dataclass(frozen=True, eq=False)
class PartMap:
    """A part on the whole.

    Attributes
    ----------
    p2p : (n_x,) int
        Vertex of Y for each vertex of X.
    back : (n_y,) int
        Vertex of X that is nearest to each vertex of Y, whether or not that is its partner.
    positions : (n_x, 3) float64
        X deformed onto Y, in Y's place and in units of sqrt(area of Y).
    """

    p2p: IndexArray
    back: IndexArray
    positions: FloatArray


@dataclass(frozen=True, eq=False)
class _Step:
    """One deformation and one matching: number of eigenfunctions, and how strongly the part is pulled."""

    stage: Stage
    k: int
    fresh: bool
    pull: Pull
    solve: Solve


class PartRegistration:
    """Registers maps of some points of one part to one whole; the factorisations are shared by all of them.

    What is known of the place is felt near it, as in `smooth_shells.register`. To be made and released in one thread;
    `register` may run in any.
    """

    def __init__(
        self, x: PartShape, y: PartShape, points: IndexArray, stages: Stages, known: KnownParts | None = None
    ) -> None:
        self.x, self.y, self.points, self.known = x, y, points, known
        mass = np.zeros(x.n_vertices)
        mass[points] = x.area / len(points)
        self.steps: list[_Step] = []
        for number, stage in enumerate(stages):
            sizes = [k for k in stage.sizes if k <= y.laplacian.shape[1]]
            for place, k in enumerate(sizes):
                length = stage.first * (stage.last / stage.first) ** (place / max(len(sizes) - 1, 1))
                pull = Pull((number, place), mass / length**2)
                self.steps.append(_Step(stage, k, place == 0, pull, x.arap.prefactor(pull)))
                mass = x.areas

    def register(self, images: IndexArray) -> PartMap:
        """Map of all vertices from the vertices (s,) of Y to which the points go, right in the large."""
        x = self.x
        i, j, weight = self.points, images, np.full(len(images), x.area / len(images))
        positions = np.zeros((0, 3))
        found: PartMap | None = None
        for step in self.steps:
            functional = self._functional_map(step.k, i, j, weight)
            targets = self._targets(i, j, weight)
            if found is None:
                positions = self._smoothed(targets, np.bincount(i, weight, x.n_vertices).astype(np.float64))
            for _ in range(step.stage.iterations if found else max(step.stage.iterations, x.given.first_iterations)):
                wide = x.given.wide_rotations if step.stage.untwist else x.given.narrow_rotations
                positions = x.arap.iterate(step.solve, step.pull, positions, targets, wide if step.fresh else 1)
            found = self._matched(step, functional, positions)
            i, j, weight = self._pairs(found)
        assert found is not None, "the stages have steps"
        return found

    def release(self) -> None:
        """Forget the factorisations."""
        self.x.arap.release()

    def _functional_map(self, k: int, i: IndexArray, j: IndexArray, weight: FloatArray) -> SingleArray:
        """Map (w, k) of the part's first eigenfunctions to the whole's: as many as have its frequencies, and some."""
        low_x, low_y, given = self.x.laplacian, self.y.laplacian, self.x.given
        wanted = int(np.ceil(k * min(self.x.area, 1.0))) + given.more_functions
        width = max(min(wanted, low_x.shape[1], len(i) // 3), 1)
        left, right = low_x[i, :width], low_y[j, :k]
        weighted = left * weight[:, None].astype(np.float32)
        return np.linalg.solve(_regular(weighted.T @ left), weighted.T @ right)

    def _targets(self, i: IndexArray, j: IndexArray, weight: FloatArray) -> FloatArray:
        """Mean position on Y of the matches of each vertex of X, (n_x, 3)."""
        n = self.x.n_vertices
        mass = np.bincount(i, weight, n)
        moved = self.y.vertices[j] * weight[:, None]
        sums = np.column_stack([np.bincount(i, moved[:, axis], n) for axis in range(3)])
        return sums / np.where(mass > 0, mass, 1.0)[:, None]

    def _smoothed(self, targets: FloatArray, mass: FloatArray) -> FloatArray:
        """Positions (n_x, 3) that the first eigenfunctions make of those of the matched points."""
        low = self.x.laplacian[:, : self.x.given.first_functions].astype(np.float64)
        weighted = low * mass[:, None]
        return low @ np.linalg.solve(_regular(weighted.T @ low), weighted.T @ targets)

    def _matched(self, step: _Step, functional: SingleArray, positions: FloatArray) -> PartMap:
        x, y, k, normals = self.x, self.y, step.k, step.stage.normals
        # Eigenfunctions weigh as coordinates do: their sum over k is about k / area.
        weight = 1 / (k * np.sqrt(np.pi))
        deformed = x.surface.with_vertices(positions)
        carried = x.laplacian[:, : len(functional)] @ functional
        left = [weight * carried, positions, normals * deformed.vertex_normals]
        right = [weight * y.laplacian[:, :k], y.vertices, normals * y.normals]
        if self.known is not None:
            profiles = self.known.profiles
            left.append(self.known.parameters.hint_weight * profiles[0])
            right.append(self.known.parameters.hint_weight * profiles[1])
        forth, back = nearest_neighbors_both_ways(
            np.column_stack(left).astype(np.float32), np.column_stack(right).astype(np.float32)
        )
        return PartMap(forth, back, positions)

    def _pairs(self, found: PartMap) -> tuple[IndexArray, IndexArray, FloatArray]:
        """Matches of all vertices of the part, and of those of the whole that are mutual; the area that each has."""
        x, y = self.x, self.y
        apart = np.linalg.norm(y.vertices[found.p2p[found.back]] - y.vertices, axis=1)
        mutual = np.flatnonzero(apart < x.given.mutual)
        i = np.concatenate([np.arange(x.n_vertices), found.back[mutual]])
        j = np.concatenate([found.p2p, mutual])
        return i, j, np.concatenate([x.areas, y.areas[mutual]])


def _regular(matrix: npt.NDArray) -> npt.NDArray:
    """The matrix of a least-squares problem, positive definite where the points do not determine it."""
    return matrix + _RIDGE * np.trace(matrix) / len(matrix) * np.eye(len(matrix), dtype=matrix.dtype)
