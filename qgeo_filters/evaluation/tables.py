"""Tables of errors as Markdown: one row for each category, and the pooled rows below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation.errors import FAILED, THRESHOLDS, ErrorSummary, SymmetricErrors, area_under_curve


@dataclass(frozen=True, eq=False)
class PairResult:
    """Errors of one map.

    Attributes
    ----------
    name : str
        What was mapped, such as "cat0 - cat1".
    category : str
    errors : SymmetricErrors
    confident : bool
        What the method itself said of the map.
    seconds : float
        CPU time.
    p2p : (n_x,) int
        The map itself; empty where it was not kept.
    mapped : float
        Share of the points with a known image that were given one: less than 1 for parts only.
    coverage : float
        Share of Y's area at the vertices that are the image of some vertex.
    handed : bool
        Whether it is known which maps are mirrored.
    """

    name: str
    category: str
    errors: SymmetricErrors
    confident: bool = True
    seconds: float = float("nan")
    p2p: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    mapped: float = 1.0
    coverage: float = float("nan")
    handed: bool = True

    @property
    def failed(self) -> bool:
        """Whether the mean direct error exceeds `FAILED`."""
        return bool(self.errors.direct.mean() > FAILED)


@dataclass(frozen=True)
class Row:
    """A line of the table, over some pairs.

    Attributes
    ----------
    label : str
    n_pairs, n_mirrored, n_failed, n_confident : int
        Numbers of pairs: all of them, and those of which `SymmetricErrors.mirrored` and so on hold.
    mean, worst : float
        Mean and largest of the pairs' mean direct errors.
    best_per_pair, vertex_minimum : float
        Mean of the pairs' means under the two lenient protocols.
    points : ErrorSummary
        Direct errors of all points of all pairs.
    auc : float
        Area under the curve of the share of points within an error (PCK), from 0 to `AUC_UP_TO`, 1 at best.
    coverage, mapped : float
        Mean over the pairs.
    handed : bool
        Whether mirrored maps are known as such.
    seconds : float
        Mean CPU time of a pair.
    """

    label: str
    n_pairs: int
    n_mirrored: int
    n_failed: int
    n_confident: int
    mean: float
    worst: float
    best_per_pair: float
    vertex_minimum: float
    points: ErrorSummary
    auc: float
    coverage: float
    mapped: float
    handed: bool
    seconds: float

    @classmethod
    def of(cls, label: str, results: Sequence[PairResult]) -> Row:
        """Row over these pairs, each pair counting equally in the means."""
        if not results:
            raise ParameterError(f"no results for the row {label!r}")
        direct = np.concatenate([result.errors.direct for result in results])
        means = np.array([result.errors.direct.mean() for result in results])
        return cls(
            label,
            n_pairs=len(results),
            n_mirrored=sum(result.errors.mirrored for result in results),
            n_failed=sum(result.failed for result in results),
            n_confident=sum(result.confident for result in results),
            mean=float(means.mean()),
            worst=float(means.max()),
            best_per_pair=float(np.mean([result.errors.best_per_pair.mean() for result in results])),
            vertex_minimum=float(np.mean([result.errors.vertex_minimum.mean() for result in results])),
            points=ErrorSummary.of(direct),
            auc=area_under_curve(direct),
            coverage=float(np.mean([result.coverage for result in results])),
            mapped=float(np.mean([result.mapped for result in results])),
            handed=all(result.handed for result in results),
            seconds=float(np.mean([result.seconds for result in results])),
        )


def rows_by_category(results: Sequence[PairResult], pools: Mapping[str, Sequence[str]] | None = None) -> list[Row]:
    """One row for each category in order of appearance, one for each pool of categories, and one for all.

    Parameters
    ----------
    results : sequence of PairResult
    pools : mapping of str to sequence of str, optional
        Label of a pooled row and the categories in it, such as those that parameters were tuned on.
    """
    categories = dict.fromkeys(result.category for result in results)
    rows = [Row.of(category, [result for result in results if result.category == category]) for category in categories]
    for label, members in (pools or {}).items():
        chosen = [result for result in results if result.category in members]
        if chosen:
            rows.append(Row.of(label, chosen))
    return [*rows, Row.of("all", results)]


def markdown(rows: Sequence[Row]) -> str:
    """Table of the rows in Markdown, errors in units of sqrt(area)."""
    shares = [f"< {threshold:g} (%)" for threshold in THRESHOLDS]
    head = [
        "",
        "pairs",
        "mean",
        "median",
        *shares,
        "AUC",
        "coverage (%)",
        "worst pair",
        "mirrored",
        "failed",
        "confident",
    ]
    head += ["best per pair", "per-vertex minimum", "CPU s"]
    lines = [_line(head), _line(["---"] + ["---:"] * (len(head) - 1))]
    for row in rows:
        cells = [row.label, str(row.n_pairs), f"{row.mean:.4f}", f"{row.points.median:.4f}"]
        cells += [f"{100 * share:.1f}" for share in row.points.below]
        cells += [f"{row.auc:.3f}", f"{100 * row.coverage:.1f}", f"{row.worst:.4f}"]
        cells += [str(row.n_mirrored) if row.handed else "?", str(row.n_failed), str(row.n_confident)]
        cells += [f"{row.best_per_pair:.4f}", f"{row.vertex_minimum:.4f}", f"{row.seconds:.1f}"]
        lines.append(_line(cells))
    return "\n".join(lines)


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
