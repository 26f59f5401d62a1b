"""A pair of shapes that is being matched, with all that a run goes by."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, RepairOption, SingleArray
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.matching.hints import Hints, LabelPair, LandmarkPairs
from qgeo_filters.matching.known_parts import KnownParts, require_landmarks_left
from qgeo_filters.matching.level import Level
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape, Shape


@dataclass(frozen=True, eq=False)
class MatchProblem:
    """Maps are sought from X to Y.

    Attributes
    ----------
    x, y : PreparedShape
        Prepared with the same parameters.
    parameters : MatchingParameters
    log : MatchLog
        What was proposed so far, and what became of it.
    reflection : bool
        Whether Y is X's image in a mirror, vertex by vertex, and the identity is no answer: a self-symmetry.
    hints : Hints, optional
        What is known of the map.
    """

    x: PreparedShape
    y: PreparedShape
    parameters: MatchingParameters = field(default_factory=MatchingParameters)
    log: MatchLog = field(default_factory=MatchLog)
    reflection: bool = False
    hints: Hints | None = None

    @classmethod
    def of(
        cls,
        x: Shape,
        y: Shape,
        parameters: MatchingParameters | None = None,
        *,
        repair: RepairOption = "auto",
        landmarks: LandmarkPairs | None = None,
        labels: LabelPair | None = None,
        progress: bool = False,
    ) -> MatchProblem:
        """Problem of two shapes, prepared already or not.

        Parameters
        ----------
        x, y : Surface, whatever `as_surface` takes, or PreparedShape
        parameters : MatchingParameters, optional
            Those that a shape was prepared with, by default.
        repair : bool, "auto" or "force"
            Of shapes that are not prepared yet, see `PreparedShape`.
        landmarks, labels : optional
            What is known, in vertices of the surfaces that were given, see `Hints.of`.

        Raises
        ------
        MeshError
            A shape that cannot be matched; the message begins with X or Y.
        ParameterError
            Hints that cannot be; shapes that were prepared with different parameters: their distances, and so maps,
            cannot be compared.
        """
        chosen = _chosen(parameters, x, y)
        with concerning("X"):
            first = _prepared(x, chosen, repair, progress)
        with concerning("Y"):
            second = _prepared(y, chosen, repair, progress)
        if landmarks is None and labels is None:
            return cls(first, second, chosen)
        hints = Hints.of(first.given, second.given, landmarks, labels)
        require_landmarks_left(hints, first, second)
        return cls(first, second, chosen, hints=hints)

    @classmethod
    def of_reflection(
        cls,
        x: Shape,
        parameters: MatchingParameters | None = None,
        *,
        repair: RepairOption = "auto",
        progress: bool = False,
    ) -> MatchProblem:
        """Problem of a shape and its own image in a mirror; parameters as in `of`."""
        chosen = _chosen(parameters, x)
        shape = _prepared(x, chosen, repair, progress)
        return cls(shape, shape.mirrored, chosen, reflection=True)

    @cached_property
    def known(self) -> KnownParts | None:
        """Parts of X and Y that are known to belong together, if any are."""
        if not self.hints:
            return None
        known = KnownParts.of(self.hints, self.x, self.y, self.parameters)
        return replace(known, merged=int(np.sign(self.more_handles))) if len(known.to_x) else None

    @property
    def profiles(self) -> tuple[SingleArray, SingleArray] | None:
        """Values per vertex of X and of Y that known parts share, see `KnownParts.profiles`."""
        return self.known.profiles if self.known else None

    @property
    def fine(self) -> FinePair:
        """The shapes at the resolution at which maps are finished."""
        return FinePair.of(self)

    @cached_property
    def more_handles(self) -> int:
        """How many handles X has more than Y; either may have grown together where it touches itself."""
        return (self.x.full.genus or 0) - (self.y.full.genus or 0)  # matched shapes have an outside

    def with_mirrored_y(self) -> MatchProblem:
        """The problem of X and the mirror image of Y: maps that reverse the orientation keep it there."""
        return replace(self, y=self.y.mirrored).with_known(self.known)  # intrinsically the same

    def swapped(self) -> MatchProblem:
        """The problem of maps from Y to X."""
        return replace(self, x=self.y, y=self.x).with_known(self.known and self.known.swapped())

    def with_known(self, known: KnownParts | None) -> MatchProblem:
        """The same problem, but for what is known."""
        other = replace(self)
        other.__dict__["known"] = known
        return other

    @cached_property
    def _surroundings(self) -> tuple[FloatArray, FloatArray]:
        """Heat kernel signature and relief of X and of Y, (n_x, k) and (n_y, k), in deviations on X."""
        times = slice(self.parameters.hks_compared_from, None)
        here, there = (np.column_stack([shape.log_hks[:, times], shape.relief]) for shape in (self.x, self.y))
        deviation = np.sqrt(self.x.areas @ (here - self.x.areas @ here) ** 2)
        deviation[deviation == 0] = np.inf  # what is the same everywhere tells nothing apart
        return here / deviation, there / deviation

    def unlikeness(self, points: IndexArray, p2p: IndexArray) -> FloatArray:
        """How unlike the surroundings of points and of their images are, (...): a factor, 1 for what is usual.

        A man's hands go onto a gorilla's feet with less distortion than onto its hands; what surrounds them differs.

        Parameters
        ----------
        points : (s,) int
            Vertices of X.
        p2p : (..., s) int
            Vertex of Y for each of them.
        """
        given = self.parameters
        if self.reflection:  # what is left in place agrees best
            return np.ones(p2p.shape[:-1])
        here, there = self._surroundings
        gaps = np.mean((here[points] - there[p2p]) ** 2, axis=-2) / 2
        disagreements = gaps[..., :-1].max(axis=-1), gaps[..., -1]
        factors = [(gap + given.least_unlike) / (given.usually_unlike + given.least_unlike) for gap in disagreements]
        return np.asarray(np.sqrt(factors[0] * factors[1]) ** given.unlike_counts)

    def dearness(self, points: IndexArray, p2p: IndexArray) -> FloatArray:
        """By what the distortion of maps of these points is multiplied where they are ranked, (...)."""
        return self.penalties(points, p2p) * self.unlikeness(points, p2p)

    def penalties(self, points: IndexArray, p2p: IndexArray) -> FloatArray:
        """How many times as dear maps of these points are for what they do to the hints, (...); 1 without any.

        Parameters
        ----------
        points : (s,) int
            Vertices of X.
        p2p : (..., s) int
            Vertex of Y for each of them.
        """
        return self.known.penalties(points, p2p) if self.known else np.ones(p2p.shape[:-1])


@dataclass(frozen=True, eq=False)
class FinePair:
    """Two shapes at the resolution at which maps are finished; see `MatchProblem`."""

    x: Level
    y: Level
    parameters: MatchingParameters
    profiles: tuple[SingleArray, SingleArray] | None

    @classmethod
    def of(cls, problem: MatchProblem) -> FinePair:
        """The fine levels of a problem, what is known interpolated."""
        x, y, profiles = problem.x, problem.y, problem.profiles
        if profiles is not None:
            profiles = x.proxy.pulled_back(profiles[0]), y.proxy.pulled_back(profiles[1])
        return cls(x.fine, y.fine, problem.parameters, profiles)


def _chosen(parameters: MatchingParameters | None, *shapes: Shape) -> MatchingParameters:
    """The parameters that were given, or those of the first shape that was prepared, or the default."""
    prepared = (shape.parameters for shape in shapes if isinstance(shape, PreparedShape))
    return parameters or next(prepared, MatchingParameters())


def _prepared(shape: Shape, parameters: MatchingParameters, repair: RepairOption, progress: bool) -> PreparedShape:
    prepared = PreparedShape.of(shape, parameters, repair=repair, progress=progress)
    for key, value in prepared.parameters.of_shape().items():
        if value != getattr(parameters, key):
            raise ParameterError(
                f"the shape was prepared with {key}={value!r}, but the match goes by {getattr(parameters, key)!r}: "
                "prepare both shapes with the same parameters"
            )
    return prepared
