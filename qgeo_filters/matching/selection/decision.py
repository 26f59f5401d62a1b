"""Which of several maps between all vertices is the best."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from qgeo_filters.matching.initialization.candidates import Candidate, dearer_than, mapped_points
from qgeo_filters.matching.maps.map_distance import are_different, landmark_lower_bound
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.cost import Contender, registered
from qgeo_filters.matching.selection.fixed_limbs import without_fixed_limbs
from qgeo_filters.matching.selection.part_icp import turned_parts


@dataclass(frozen=True, eq=False)
class Decision:
    """The best map, and how clear the choice was.

    Attributes
    ----------
    best : Contender
        Between the shapes as they were searched, to be finished, see `matching.finish`.
    margin : float
        How many times its cost the next different contender's is; inf if there is none.
    runner_up : float
        Distortion of that one.
    unhinted : float
        How many times its cost the cheapest different contender's would be if there were no hints; inf without any.
    contrary : float
        How many times its cost that of the next different contender is along which the relief agrees clearly better;
        inf if there is none.
    """

    best: Contender
    margin: float
    runner_up: float
    unhinted: float = np.inf
    contrary: float = np.inf


def choose_map(problem: MatchProblem, pool: list[Candidate]) -> Decision:
    """The best of the candidates between the coarse shapes: of those cheap in a preview the one that ends cheapest."""
    with _factorisations_released(problem):
        ranked = previewed(problem, pool)
        return _settled(problem, ranked, apart=problem.parameters.different_mean)


def choose_reflection(problem: MatchProblem, pool: list[Candidate]) -> Decision:
    """The best of the candidates for a reflection of X, registered.

    As `choose_map`, but for what only reflections suffer from: limbs that are left in place, and parts of the body that
    are turned about the axis.
    """
    with _factorisations_released(problem):
        ranked = without_fixed_limbs(problem, previewed(problem, pool))
        decision = _settled(problem, ranked, apart=problem.parameters.reflection_apart)
        return replace(decision, best=_with_parts_turned(problem, decision.best))


@contextmanager
def _factorisations_released(problem: MatchProblem) -> Iterator[None]:
    try:
        yield
    finally:
        problem.x.arap.release()


def previewed(problem: MatchProblem, pool: list[Candidate]) -> list[Contender]:
    """The best different candidates, deformed onto Y on trial, the cheapest first.

    A map that is right in one part and wrong in another, such as one that swaps two legs, can keep distances better
    than the right one does between two poses; but a deformation that follows it has to tear, fold or twist the surface
    in between. The maps must keep the orientation.
    """
    given, log = problem.parameters, problem.log
    ranked = sorted(pool, key=lambda c: c.rank)
    ratio = given.reflection_preview_ratio if problem.reflection else given.preview_ratio
    bound = ratio * ranked[0].rank + given.ratio_slack
    # What would win without the hints is tried in any case, so that their disagreement can be told.
    unhinted = min(pool, key=lambda c: c.unhinted_rank)
    tried: list[Candidate] = []
    for c in ranked:
        like = next((t for t in tried if not _differ(problem, c, t)), None)
        if like is not None:
            log.drop(c.number, f"the same map as #{like.number}")
        elif c is unhinted:
            tried.append(c)
        elif c.rank > bound:
            log.drop(c.number, dearer_than(problem, bound))
        elif len(tried) >= given.preview_count:
            log.drop(c.number, f"not among the {given.preview_count} that distort least")
        else:
            tried.append(c)
    maps = [(c.number, c.p2p) for c in tried]
    ranks = sorted(registered(problem, maps, given.preview, mapped_points(problem)), key=lambda c: c.cost)
    for contender in ranks:
        note_costs(problem, contender, preview_cost=contender.cost)
    return ranks


def close_contenders(problem: MatchProblem, ranked: list[Contender]) -> list[Contender]:
    """Those whose cost in the preview is near the least, not too many of one kind."""
    given, log = problem.parameters, problem.log
    close: list[Contender] = []
    for c in ranked:
        kin = [t for t in close if _gap(problem, c, t) < given.kin_distance]
        if c.cost > given.close_ratio * ranked[0].cost:
            log.drop(c.number, f"costs more than {given.close_ratio:g} times the least in the preview")
        elif len(close) == given.close_count:
            log.drop(c.number, f"not among the {given.close_count} cheapest in the preview")
        elif len(kin) >= given.kin_count:
            log.drop(c.number, f"near #{kin[0].number}, of whose kind there are {given.kin_count}")
        else:
            close.append(c)
    if not problem.reflection:
        return close
    different: list[Contender] = []
    for c in close:
        like = next((t for t in different if _gap(problem, c, t) < given.reflection_same), None)
        if like is None:
            different.append(c)
        else:
            log.drop(c.number, f"has become the same map as #{like.number} in the preview")
    return different


def settled(problem: MatchProblem, close: list[Contender]) -> list[Contender]:
    """Contenders where they end, in order: registered, or guided by heat kernels from there if that costs less."""
    given = problem.parameters
    ends = registered(problem, [(c.number, c.dense.p2p) for c in close], given.coarse_to_fine)
    # Along a reflection by which heat kernels agree closely nothing is turned, and they would lead to the same end.
    closely = given.reflection_closely_alike if problem.reflection else np.inf
    led = [c for c in ends if c.hks_agreement < closely]
    again = {c.number: c for c in registered(problem, [(c.number, c.dense.p2p) for c in led], given.hks_guided)}
    best = [led_by_kernels(problem, c, again[c.number]) if c.number in again else c for c in ends]
    for c in best:
        note_costs(problem, c, end_cost=c.end_cost)
    return best


def led_by_kernels(problem: MatchProblem, contender: Contender, led: Contender) -> Contender:
    """The cheaper of a contender and what heat kernels made of it.

    They may lead a limb to another that is as stout as it is, where they agree, of course; but all else tells: it
    strains and tears more, for a relief that hardly agrees better. What that contender costs is still that of the
    shapes at their most alike; of two different maps the right one need not be the one whose limbs are in place.
    """
    if led.end_cost >= contender.end_cost:
        return contender
    worse = led.without_kernels > problem.parameters.led_astray * contender.without_kernels
    astray = not problem.reflection and worse and _are_different(problem, contender, led)
    return replace(led, in_place=contender.dense) if astray else led


def _settled(problem: MatchProblem, ranked: list[Contender], apart: float) -> Decision:
    """The cheapest contender, and how clear that is beside those ``apart`` from it."""
    close = close_contenders(problem, ranked)
    ends = settled(problem, close)
    order = sorted(range(len(close)), key=lambda i: ends[i].end_cost)
    for _ in range(problem.parameters.doubtful_rounds):  # what is near depends on what is best
        others = [c for c in ranked if not any(c is t for t in close)]
        doubtful = _doubtful(problem, others, close[order[0]], ends[order[0]], apart)
        if not doubtful:
            break
        close, ends = close + doubtful, ends + settled(problem, doubtful)
        order = sorted(range(len(close)), key=lambda i: ends[i].end_cost)
    best, preview = ends[order[0]], close[order[0]]
    problem.log.choose(best.number)
    # A rival that was taken further is compared there, the others as they were in the preview.
    rivals = [(ends[i].end_cost / best.end_cost, ends[i]) for i in order[1:] if _gap(problem, ends[i], best) > apart]
    others = [c for c in ranked if not any(c is t for t in close)]
    rivals += [(c.cost / preview.cost, c) for c in others if _gap(problem, c, best) > apart]
    margin, rival = min(rivals, key=lambda pair: pair[0], default=(np.inf, None))
    return Decision(
        best,
        margin=margin,
        runner_up=rival.mean_distortion if rival else np.inf,
        unhinted=min((ratio * best.penalty / c.penalty for ratio, c in rivals if problem.known), default=np.inf),
        contrary=min((ratio for ratio, c in rivals if _agrees_better(problem, c, best)), default=np.inf),
    )


def decided_among(problem: MatchProblem, before: Decision, others: list[Contender]) -> Decision:
    """The cheapest of a decision's map and of others that were taken to the end, and how clear that is now."""
    cheapest = min(others, key=lambda c: c.end_cost)
    best = cheapest if cheapest.end_cost < before.best.end_cost else before.best
    ratio = before.best.end_cost / best.end_cost
    apart = problem.parameters.different_mean
    rivals = [(c.end_cost / best.end_cost, c) for c in (before.best, *others) if _gap(problem, c, best) > apart]
    margin, rival = min(rivals, key=lambda pair: pair[0], default=(np.inf, None))
    contrary = min((r for r, c in rivals if _agrees_better(problem, c, best)), default=np.inf)
    unhinted = min((r * best.penalty / c.penalty for r, c in rivals if problem.known), default=np.inf)
    if _gap(problem, before.best, best) <= apart:  # its rivals are this one's
        contrary, unhinted = min(contrary, ratio * before.contrary), min(unhinted, ratio * before.unhinted)
    problem.log.choose(best.number)
    if ratio * before.margin < margin:
        return Decision(best, ratio * before.margin, before.runner_up, unhinted, contrary)
    return Decision(best, margin, rival.mean_distortion if rival else np.inf, unhinted, contrary)


def _agrees_better(problem: MatchProblem, rival: Contender, best: Contender) -> bool:
    """Whether what bulges and what is hollow agrees clearly better along a rival."""
    return 1 - rival.relief_agreement < problem.parameters.contrary_relief * (1 - best.relief_agreement)


def _doubtful(
    problem: MatchProblem, others: list[Contender], preview: Contender, best: Contender, apart: float
) -> list[Contender]:
    """Those of other maps that cost hardly more than the best in the preview, where costs are rough.

    Or not much more, if the relief agrees clearly better along them: chest and back cost as much but for that.
    """
    given = problem.parameters
    if problem.reflection:
        return []

    def is_near(c: Contender) -> bool:
        contrary = _agrees_better(problem, c, best)
        return c.cost < (given.doubtful_contrary_ratio if contrary else given.doubtful_ratio) * preview.cost

    near = [c for c in others if is_near(c) and _gap(problem, c, best) > apart]
    return near[: given.doubtful_count]


def _with_parts_turned(problem: MatchProblem, best: Contender) -> Contender:
    """The contender, or a cheaper one in which parts are turned."""
    given = problem.parameters
    last = best
    for _ in range(given.part_rounds):
        maps = [(best.number, p2p) for p2p in turned_parts(problem, last.dense)[: given.part_count]]
        ends = registered(problem, maps, given.preview + given.coarse_to_fine)
        # A part that was turned for nothing has turned back; of the others the one that fits best is gone on with.
        ends = [c for c in ends if _gap(problem, c, last) > given.part_turned_back]
        best = min(best, *ends, key=lambda c: c.cost) if ends else best
        if not ends or ends[0].cost > given.part_patience * best.cost:
            break
        last = ends[0]
    return best


def _differ(problem: MatchProblem, one: Candidate, other: Candidate) -> bool:
    return are_different(landmark_lower_bound(problem.y, one.p2p, other.p2p), problem.parameters)


def _are_different(problem: MatchProblem, one: Contender, other: Contender) -> bool:
    return are_different(landmark_lower_bound(problem.y, one.dense.p2p, other.dense.p2p), problem.parameters)


def _gap(problem: MatchProblem, one: Contender, other: Contender) -> float:
    """Mean distance between the images of two maps, in sqrt(area)."""
    return float(landmark_lower_bound(problem.y, one.dense.p2p, other.dense.p2p).mean())


def note_costs(problem: MatchProblem, c: Contender, **costs: float) -> None:
    """Say in the log what a contender costs, and why."""
    problem.log.note(
        c.number, mean_distortion=c.mean_distortion, strain=c.strain, torn=c.torn, folded=c.folded,
        hks_agreement=c.hks_agreement, relief_agreement=c.relief_agreement, **costs,
    )  # fmt: skip
