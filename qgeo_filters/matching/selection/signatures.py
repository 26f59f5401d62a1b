"""Whether a map relates points of like surroundings: a second opinion beside the distances."""

from __future__ import annotations

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.problem import MatchProblem


def hks_agreement(problem: MatchProblem, p2p: IndexArray) -> float:
    """Least agreement of heat kernels after more than the least heat, see `hks_agreements`."""
    return min(hks_agreements(problem, p2p)[problem.parameters.hks_compared_from :])


def hks_agreements(problem: MatchProblem, p2p: IndexArray) -> tuple[float, ...]:
    """Agreement of the logarithm of the heat kernel h(t; p, p) with that at the images, 1 if equal; at each time.

    One minus half the mean squared difference over the variance on X: the correlation, for maps that keep mean and
    variance.

    References
    ----------
    Sun, Ovsjanikov, Guibas, "A concise and provably informative multi-scale signature based on heat diffusion",
    SGP 2009.
    """
    x, y = problem.x, problem.y
    return tuple(_agreement(one, other, x.areas) for one, other in zip(x.log_hks.T, y.log_hks[p2p].T, strict=True))


def curvature_agreement(problem: MatchProblem, p2p: IndexArray) -> float:
    """Agreement of the mean curvature, after a little heat, with that at the images; 1 if it is equal."""
    x, y = problem.x, problem.y
    return _agreement(x.smoothed_mean_curvature, y.smoothed_mean_curvature[p2p], x.areas)


def relief_agreement(problem: MatchProblem, p2p: IndexArray) -> float:
    """Agreement of the relief with that at the images; 1 if it is equal.

    Unlike the heat kernels it knows inside from outside: a breast is not like a back.
    """
    x, y = problem.x, problem.y
    return _agreement(x.relief, y.relief[p2p], x.areas)


def _agreement(one: FloatArray, other: FloatArray, areas: FloatArray) -> float:
    variance = float(areas @ (one - areas @ one) ** 2)
    return 1 - 0.5 * float(areas @ (one - other) ** 2) / variance if variance > 0 else 1.0
