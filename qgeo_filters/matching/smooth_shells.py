"""From a coarse map to one between all vertices: eigenfunctions, positions and normals agree together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.matching.initialization.sign_search import Hypothesis
from qgeo_filters.matching.maps.functional_map import functional_map, nearest, nearest_both, upsampled
from qgeo_filters.matching.prepared_shape import PreparedShape

# Farthest points on which the eigenfunctions of the distances are brought together.
_GROWTH_POINTS = 800
_GROWTH_STEP = 10
# Eigenfunctions of the Laplacian that carry a map of farthest points to all vertices.
_SPREAD = 20


@dataclass(frozen=True)
class Pass:
    """One passage through the frequencies.

    Attributes
    ----------
    sizes : tuple of int
        Numbers of Laplacian eigenfunctions, increasing.
    first, last : float
        Length, in sqrt(area), below which the deformed shape does not follow the map, at the first and last size.
    normals : float
        Weight of normals against positions.
    turns : int
        Turns of the deformation for each matching.
    full : int
        Number of eigenfunctions from which on all vertices are matched, not only farthest points: fewer cannot tell
        vertices apart. At the very end all are, always.
    untwist : bool
        Whether the deformation starts afresh from the low frequencies of the map, limbs shrunk to their axes, with
        rotations of wide neighbourhoods: how a limb is turned about its axis then follows from the body that it
        grows on, not from the map.
    kernels : float
        Weight of the heat kernels against positions: they tell the front of a head from its back, which hardly strains
        the neck.
    """

    sizes: tuple[int, ...]
    first: float
    last: float
    normals: float
    turns: int = 3
    full: int = 1000
    untwist: bool = False
    kernels: float = 0.0


_SIZES = (20, 30, 45, 65, 90, 120, 160, 200)
#: What was best on the tuning categories (see benchmarks/README.md): from a trial to where the cost tells, and on to
#: the end.
SETTLING = (Pass((20, 20, 30), 0.15, 0.08, 0.03, turns=6, untwist=True), Pass(_SIZES, 0.05, 0.02, 0.07))
ENDING = (Pass(_SIZES, 0.03, 0.015, 0.03, full=90),)
#: As settling, but led by the heat kernels: right where a head had been turned about its axis, sometimes wrong
#: elsewhere, so that the cost must decide.
RECONSIDERING = (replace(SETTLING[0], kernels=0.5), SETTLING[1])
#: Enough to tell which of several maps is right.
TRIAL = (Pass((20, 30, 45), 0.05, 0.035, 0.07, untwist=True),)
# Matchings at each size.
_MATCHINGS = 2
_FIRST_TURNS = 8
# How often rotations are averaged over neighbours at the first size of a pass.
_WIDE, _NARROW = 30, 3
# Farthest points that are matched before all vertices are.
_COARSE = 1500


@dataclass(frozen=True, eq=False)
class Finished:
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


def grown(x: PreparedShape, y: PreparedShape, hypothesis: Hypothesis, vertices: IndexArray) -> IndexArray:
    """Images (s,) of some vertices of X, by spectral upsampling over the eigenfunctions of the distances."""
    phi_x, phi_y = (shape.views[hypothesis.metric].eigenfunctions for shape in (x, y))
    width = min(phi_x.shape[1], phi_y.shape[1])
    start = min(20, width)
    coarse = upsampled(phi_x, phi_y, hypothesis.p2p, hypothesis.points, [start])
    points, others = x.samples[:_GROWTH_POINTS], phi_y[y.samples]
    images = nearest(phi_x[points, :start] @ coarse, others[:, :start])
    functional = upsampled(phi_x, others, images, points, range(start, width + 1, _GROWTH_STEP))
    k = len(functional)
    return nearest(phi_x[vertices, :k] @ functional, phi_y[:, :k])


def spread(x: PreparedShape, y: PreparedShape, hypothesis: Hypothesis, vertices: IndexArray) -> IndexArray:
    """Images (s,) of some vertices of X, by the first eigenfunctions of the Laplacian."""
    points = hypothesis.points
    left, right = x.laplacian[:, :_SPREAD], y.laplacian[:, :_SPREAD]
    return nearest(left[vertices] @ functional_map(left[points], right, hypothesis.p2p), right)


def finished(
    x: PreparedShape,
    y: PreparedShape,
    p2p: IndexArray,
    passes: tuple[Pass, ...] = SETTLING + ENDING,
    points: IndexArray | None = None,
) -> Finished:
    r"""Map between all vertices from one of ``points`` (of all by default) that is right in the large.

    From low to high frequencies, each vertex of X is matched with the vertex of Y that is nearest in three things
    together: the Laplacian's eigenfunctions (through the functional map of the current matches), the position, and
    the normal, of X deformed towards its matches as rigidly as possible. Matches are taken in both directions, so
    that no part of Y stays uncovered. The maps must keep the orientation: for one that reverses it, pass
    ``y.mirrored``.

    References
    ----------
    Eisenberger, Laehner, Cremers, "Smooth shells: multi-scale shape registration with functional maps", CVPR 2020,
    for intrinsic and extrinsic features from coarse to fine; Ren, Melzi, Wonka, Ovsjanikov, "Discrete
    optimization for shape matching", SGP 2021, for maps in both directions.
    """
    state = _State(x, y, p2p, points)
    for step in _steps(x, y, passes):
        state.advance(step)
    return Finished(state.forth, state.back, state.positions, *state.embeddings)


def factorised(x: PreparedShape, y: PreparedShape, passes: tuple[Pass, ...], points: IndexArray | None = None) -> None:
    """Factorise in this thread what `finished` will solve with these passes.

    SciPy leaks the memory of a factorisation that is made in one thread and dropped in another one.
    """
    matched = np.arange(x.n_vertices) if points is None else points
    for step in _steps(x, y, passes):
        for _ in range(_MATCHINGS):
            x.rigidity.pulled(_mass(x, matched) / step.length**2)
            matched = _matched(x, step)


@dataclass(frozen=True)
class _Step:
    """Matchings with one number of eigenfunctions: their number, the length of the pass there, and which points."""

    k: int
    length: float
    stage: Pass
    fresh: bool
    coarse: bool


def _steps(x: PreparedShape, y: PreparedShape, passes: tuple[Pass, ...]) -> Iterator[_Step]:
    for number, stage in enumerate(passes):
        sizes = [k for k in stage.sizes if k <= min(x.laplacian.shape[1], y.laplacian.shape[1])]
        for place, k in enumerate(sizes):
            length = stage.first * (stage.last / stage.first) ** (place / max(len(sizes) - 1, 1))
            final = number == len(passes) - 1 and k == sizes[-1]
            yield _Step(k, length, stage, fresh=place == 0, coarse=k < stage.full and not final)


def _matched(shape: PreparedShape, step: _Step) -> IndexArray:
    """The vertices that the step matches."""
    return shape.samples[:_COARSE] if step.coarse else np.arange(shape.n_vertices)


class _State:
    """Matches in both directions, and the deformed shape; changed by each step."""

    def __init__(self, x: PreparedShape, y: PreparedShape, p2p: IndexArray, points: IndexArray | None) -> None:
        self.x, self.y = x, y
        self.points_x, self.forth = np.arange(x.n_vertices) if points is None else points, p2p
        self.points_y, self.back = np.zeros(0, np.int64), np.zeros(0, np.int64)
        self.positions = np.zeros((0, 3))
        self.embeddings: tuple[SingleArray, SingleArray] = (np.zeros((0, 0), np.float32),) * 2

    def advance(self, step: _Step) -> None:
        """Deform and match again."""
        x, y, k, stage = self.x, self.y, step.k, step.stage
        for _ in range(_MATCHINGS):
            functional = self._functional(k)
            targets, mass = self._targets()
            pull = mass / step.length**2
            solve = x.rigidity.pulled(pull)
            first = not len(self.positions)
            if first:
                self.positions = self._smoothed(k, targets, mass) if stage.untwist or not mass.all() else targets
            wide = _WIDE if stage.untwist else _NARROW
            for _turn in range(max(stage.turns, _FIRST_TURNS if first else 0)):
                self.positions = x.rigidity.step(solve, pull, self.positions, targets, wide if step.fresh else 1)
            # Eigenfunctions weigh as coordinates do: their sum over k is about k / area.
            weight = 1 / (k * np.sqrt(np.pi))
            deformed = x.unit.with_vertices(self.positions)
            left = [weight * (x.laplacian[:, :k] @ functional), self.positions, stage.normals * deformed.vertex_normals]
            right = [weight * y.laplacian[:, :k], y.unit.vertices, stage.normals * y.normals]
            if stage.kernels:
                left.append(stage.kernels * x.heat_kernels)
                right.append(stage.kernels * y.heat_kernels)
            self.embeddings = np.column_stack(left).astype(np.float32), np.column_stack(right).astype(np.float32)
            self.points_x, self.points_y = _matched(x, step), _matched(y, step)
            forth, back = nearest_both(self.embeddings[0][self.points_x], self.embeddings[1][self.points_y])
            self.forth, self.back = self.points_y[forth], self.points_x[back]

    def _pairs(self) -> tuple[IndexArray, IndexArray, FloatArray]:
        """Matched vertices of X and of Y, and the area that each match stands for."""
        x, y = self.x, self.y
        some = np.concatenate([self.points_x, self.back]), np.concatenate([self.forth, self.points_y])
        return *some, np.concatenate([_shares(x, self.points_x), _shares(y, self.points_y)])

    def _functional(self, k: int) -> SingleArray:
        i, j, weight = self._pairs()
        left, right = self.x.laplacian[i, :k], self.y.laplacian[j, :k]
        weighted = left * weight[:, None].astype(np.float32)
        return np.linalg.solve(weighted.T @ left, weighted.T @ right)

    def _smoothed(self, k: int, targets: FloatArray, mass: FloatArray) -> FloatArray:
        """Positions (n_x, 3) that the first eigenfunctions make of those of the matched points."""
        low = self.x.laplacian[:, :k].astype(np.float64)
        weighted = low * mass[:, None]
        return low @ np.linalg.solve(weighted.T @ low, weighted.T @ targets)

    def _targets(self) -> tuple[FloatArray, FloatArray]:
        """Mean position on Y of the matches of each vertex of X, and the area by which it is drawn there."""
        i, j, weight = self._pairs()
        n = self.x.n_vertices
        total = np.bincount(i, weight, n)
        moved = self.y.unit.vertices[j] * weight[:, None]
        sums = np.column_stack([np.bincount(i, moved[:, axis], n) for axis in range(3)])
        targets: FloatArray = sums / np.where(total > 0, total, 1.0)[:, None]
        return targets, _mass(self.x, self.points_x)


def _mass(shape: PreparedShape, points: IndexArray) -> FloatArray:
    """Area for which each vertex stands, (n,), 0 where it is none of the points."""
    mass = np.zeros(shape.n_vertices)
    mass[points] = _shares(shape, points)
    return mass


def _shares(shape: PreparedShape, points: IndexArray) -> FloatArray:
    """Part of the area for which each point stands: its own where all vertices take part, equal parts otherwise."""
    if len(points) == shape.n_vertices:
        return shape.areas[points]
    return np.full(len(points), 1.0 / max(len(points), 1))
