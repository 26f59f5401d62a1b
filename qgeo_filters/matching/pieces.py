"""Shapes of several pieces matched piece by piece: a skull and its jaw, the bones of a hand."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment
from tqdm.auto import tqdm

from qgeo_filters._typing import FloatArray, IndexArray, MirrorOption, RepairOption
from qgeo_filters.decimation import decimated
from qgeo_filters.errors import MeshError, ParameterError, concerning
from qgeo_filters.hosts.dispatch import SurfaceLike, surface_and_repair
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.html_repr import card
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.map_transfer import checked_values
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.missing_values import with_missing
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

# Vertices at which pieces are compared, and how many eigenvalues: their size and rough shape.
_COMPARED_AT = 1000
_EIGENVALUES = 12
# Other partners are as likely where that costs less than this more: a mean difference of logarithms.
_UNLIKE = 0.1


@dataclass(frozen=True, eq=False)
class PieceMatch:
    """A piece of X and the piece of Y that it is matched to.

    Attributes
    ----------
    result : MatchResult
        Between the vertices of the pieces.
    vertices_x, vertices_y : (k,) int64
        Vertex of X, and of Y, that each vertex of the piece is.
    """

    result: MatchResult
    vertices_x: IndexArray
    vertices_y: IndexArray


@dataclass(frozen=True, eq=False)
class PiecewiseMatch:
    """Correspondence of shapes of several pieces.

    Attributes
    ----------
    x, y : Surface
        As they were given.
    pieces : tuple of PieceMatch
        The largest first.
    p2p : (n_x,) int64
        Vertex of Y for each vertex of X; -1 on pieces without a partner.
    inverse : (n_y,) int64
        Vertex of X for each vertex of Y; -1 as well.
    confident : bool
        Whether all are, and which pieces belong together is clear.
    explanation : str
    repairs : tuple of str
        What was repaired before, a sentence each.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> vertices = np.concatenate([x.vertices, 0.5 * x.vertices + 9])
    >>> both = qg.Surface(vertices, np.concatenate([x.faces, x.faces + 162]))  # two pieces
    >>> found = qg.match_pieces(both, both)
    >>> print(found.explanation)
    each piece has a partner, and is sure of it
    """

    x: Surface
    y: Surface
    pieces: tuple[PieceMatch, ...]
    p2p: IndexArray
    inverse: IndexArray
    confident: bool
    explanation: str
    repairs: tuple[str, ...]

    def __repr__(self) -> str:
        lines = [f"PiecewiseMatch: {len(self.pieces)} pieces; {'' if self.confident else 'not '}confident"]
        for piece in self.pieces:
            sure = "confident" if piece.result.confident else "not confident"
            lines.append(
                f"  {len(piece.vertices_x)} vertices of X on {len(piece.vertices_y)} of Y, {sure}, distortion "
                f"{piece.result.score:.4f} sqrt(area) in the mean"
            )
        return "\n".join([*lines, f"  {self.explanation}"])

    def _repr_html_(self) -> str:
        table = [
            (
                str(number),
                len(piece.vertices_x),
                len(piece.vertices_y),
                piece.result.confident,
                piece.result.score,
            )
            for number, piece in enumerate(self.pieces)
        ]
        columns = ("piece", "vertices of X", "vertices of Y", "confident", "distortion, sqrt(area)")
        return card(
            f"PiecewiseMatch: {len(self.pieces)} pieces",
            {"repaired": list(self.repairs) or None},
            subtitle=f"{'confident' if self.confident else 'NOT CONFIDENT'}: {self.explanation}",
            table=table,
            columns=columns,
        )

    def transfer(self, values: npt.ArrayLike, to: Literal["y", "x"] = "y", **options: Any) -> np.ndarray:
        """Values of one shape on the other, piece by piece, see `MatchResult.transfer`; NaN, -1 or "" elsewhere."""
        if to not in ("x", "y"):
            raise ParameterError(f"to must be 'x' or 'y', got {to!r}")
        sizes = self.x.n_vertices, self.y.n_vertices
        source, target = sizes if to == "y" else sizes[::-1]
        array = checked_values(values, source, target, "X" if to == "y" else "Y", "Y" if to == "y" else "X")
        missing, out = np.ones(target, dtype=bool), None
        for piece in self.pieces:
            here, there = (piece.vertices_x, piece.vertices_y) if to == "y" else (piece.vertices_y, piece.vertices_x)
            moved = piece.result.transfer(array[here], to=to, **options)
            out = np.zeros((target, *moved.shape[1:]), dtype=moved.dtype) if out is None else out
            out[there], missing[there] = moved, False
        assert out is not None
        return with_missing(out, missing)


def match_pieces(
    x: SurfaceLike,
    y: SurfaceLike,
    *,
    partners: list[tuple[int, int]] | None = None,
    least_area: float = 0.02,
    mirror: MirrorOption = "no",
    repair: RepairOption = "auto",
    parameters: MatchingParameters | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> PiecewiseMatch:
    """Correspondence of two shapes of several pieces, each piece onto the one that it belongs to.

    Parameters
    ----------
    x, y : Surface, or whatever `as_surface` takes
    partners : list of (int, int), optional
        Which piece of X belongs to which of Y, numbered by decreasing area from 0. By default they are told by the
        first eigenvalues of the Laplacian, and by size where both have as many, so that all together differ least.
    least_area : float
        Share of the area from which on a piece counts; smaller ones, and those of too few vertices, are left out.
    mirror : {"no", "yes", "auto"}
        Whether the maps reverse the orientation, see `match`; "auto" decides for each piece by itself.
    repair, parameters, workers
        See `match`.
    progress : bool
        Whether to show a progress bar over the pieces.

    Returns
    -------
    PiecewiseMatch

    Raises
    ------
    MeshError
        No piece that can be matched; a piece that cannot be, see `match`.
    ParameterError
        Partners that are not there, or occur twice.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> vertices = np.concatenate([x.vertices, 0.5 * x.vertices + 9])
    >>> both = qg.Surface(vertices, np.concatenate([x.faces, x.faces + 162]))  # two pieces
    >>> found = qg.match_pieces(both, both)
    >>> found.confident, len(found.pieces), bool((found.p2p == np.arange(324)).all())
    (True, 2, True)
    """
    chosen = MatchingParameters() if parameters is None else parameters
    sides = []
    for name, shape in (("X", x), ("Y", y)):
        with concerning(name):
            sides.append(_Side.of(shape, repair, least_area, chosen))
    one, other = sides
    if partners is None:
        pairs, doubt = _partners(one, other)
    else:
        pairs, doubt = _checked_partners(partners, len(one.pieces), len(other.pieces)), ""
    p2p, inverse = np.full(one.given.n_vertices, -1), np.full(other.given.n_vertices, -1)
    matches = []
    for i, j in tqdm(pairs, desc="pieces", disable=not progress):
        (left, of_x), (right, of_y) = one.pieces[i], other.pieces[j]
        found = match(left, right, partial=False, mirror=mirror, parameters=parameters, workers=workers)
        matches.append(PieceMatch(found, frozen(of_x), frozen(of_y)))
        p2p[of_x] = np.where(found.p2p >= 0, of_y[found.p2p], -1)
        inverse[of_y] = np.where(found.inverse >= 0, of_x[found.inverse], -1)
    said = [
        f"piece {i} of X: {m.result.explanation}"
        for (i, _), m in zip(pairs, matches, strict=True)
        if not m.result.confident
    ]
    both = ("X", one), ("Y", other)
    left_out = [f"pieces of {name} without a partner: {n}" for name, s in both if (n := len(s.pieces) - len(pairs))]
    confident = not said and not doubt
    explanation = "; ".join([doubt] * bool(doubt) + said + left_out) or "each piece has a partner, and is sure of it"
    repairs = tuple(f"{name}: {line}" for name, side in both for line in side.report)
    return PiecewiseMatch(
        one.given, other.given, tuple(matches), frozen(p2p), frozen(inverse), confident, explanation, repairs
    )


@dataclass(frozen=True, eq=False)
class _Side:
    """A shape and its pieces: surfaces, and the given vertex of each of their vertices."""

    given: Surface
    pieces: list[tuple[Surface, IndexArray]]
    report: tuple[str, ...]

    @classmethod
    def of(cls, shape: SurfaceLike, repair: RepairOption, least_area: float, parameters: MatchingParameters) -> _Side:
        if repair == "wrap":
            raise ParameterError("a wrap is one piece: match(repair='wrap') matches it")
        given, repaired = surface_and_repair(shape, repair, "all")
        whole = given if repaired is None else repaired.surface
        origin = np.arange(given.n_vertices) if repaired is None else repaired.origin
        labels = whole.components[1]
        areas, counts = np.bincount(labels, whole.vertex_areas), np.bincount(labels)
        large = (areas >= least_area * whole.area) & (counts >= parameters.minimum_vertices)
        order = [label for label in np.argsort(-areas, kind="stable").tolist() if large[label]]
        if not order:
            raise MeshError(
                f"no piece has {least_area:.0%} of the area and {parameters.minimum_vertices} vertices: "
                f"the largest of {len(areas)} has {areas.max() / whole.area:.0%} and {counts[areas.argmax()]}"
            )
        parts = [whole.submesh(labels == label) for label in order]
        return cls(given, [(part, origin[numbers]) for part, numbers in parts], _report(repaired))

    def sizes(self) -> FloatArray:
        """Logarithm of the share of the area of each piece, (p,)."""
        areas = np.array([part.area for part, _ in self.pieces])
        return np.asarray(np.log(areas / areas.sum()))

    def rough_shapes(self) -> FloatArray:
        """Logarithms of the first eigenvalues of the Laplacian of each piece, of unit area, (p, k)."""
        rows = []
        for part, _ in self.pieces:
            proxy = decimated(part, _COMPARED_AT).surface
            unit = Surface(proxy.vertices / np.sqrt(proxy.area), proxy.faces)
            rows.append(np.log(laplacian_spectrum(unit, _EIGENVALUES + 1).eigenvalues[1:]))
        return np.array(rows)


def _report(repair: Repair | None) -> tuple[str, ...]:
    return () if repair is None else repair.report


def _partners(one: _Side, other: _Side) -> tuple[list[tuple[int, int]], str]:
    """Which piece belongs to which, and what is unclear about it."""
    costs = np.abs(one.rough_shapes()[:, None] - other.rough_shapes()[None]).mean(axis=2)
    if len(one.pieces) == len(other.pieces):  # of a whole that lacks a piece the shares are other ones
        costs += np.abs(one.sizes()[:, None] - other.sizes()[None])
    rows, columns = linear_sum_assignment(costs)
    pairs = list(zip(rows.tolist(), columns.tolist(), strict=True))
    for (i, j), (k, m) in itertools.combinations(pairs, 2):
        if costs[i, m] + costs[k, j] - costs[i, j] - costs[k, m] < _UNLIKE:
            return pairs, (
                f"pieces {i} and {k} of X are so alike that they may belong the other way round to {j} and {m} of Y: "
                "say which by partners="
            )
    return pairs, ""


def _checked_partners(partners: list[tuple[int, int]], n_x: int, n_y: int) -> list[tuple[int, int]]:
    for side, (name, count) in enumerate((("X", n_x), ("Y", n_y))):
        numbers = [pair[side] for pair in partners]
        bad = [number for number in numbers if not 0 <= number < count]
        if bad:
            raise ParameterError(f"partners name piece {bad[0]} of {name}, which has {count}, numbered from 0 by area")
        if len(set(numbers)) < len(numbers):
            raise ParameterError(f"partners name a piece of {name} twice: {numbers}")
    if not partners:
        raise ParameterError("partners is empty: at least one pair of pieces must be matched")
    return [(int(i), int(j)) for i, j in partners]
