"""Bodies whose limbs are of other lengths: ends of limbs are matched as the symmetries allow, and the cost decides."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapes import limbed

from qgeo_filters.evaluation import BENCHMARKS, geodesic_error
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.initialization.limb_maps import LimbEnds, limb_maps, symmetric_matchings
from qgeo_filters.matching.limb_matching import with_limbs_matched
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.search import Found
from qgeo_filters.matching.selection.cost import Contender, measured
from qgeo_filters.matching.selection.decision import Decision, decided_among, led_by_kernels
from qgeo_filters.matching.smooth_shells import register
from qgeo_filters.matching.symmetry import reflection_of
from qgeo_filters.surface import Surface

#: A head, hands, feet, all a little to the front.
DIRECTIONS = ((0.0, 0.2, 1.0), (1.0, 0.3, 0.4), (-1.0, 0.3, 0.4), (0.6, 0.25, -1.0), (-0.6, 0.25, -1.0))


@functools.cache
def body(arms: float, legs: float) -> Surface:
    return Surface(*limbed(DIRECTIONS, (0.5, arms, arms, legs, legs), 3))


@functools.cache
def problem() -> MatchProblem:
    return MatchProblem.of(body(0.8, 1.5), body(1.4, 0.7))


def turned() -> np.ndarray:
    """Hands to feet and feet to hands: the body upside down, seen from behind."""
    vertices = body(0.8, 1.5).vertices
    unit = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    upside_down = unit * [-1, 1, -1]
    return np.linalg.norm(upside_down[:, None] - unit[None], axis=2).argmin(axis=1)


def contender(of: MatchProblem, p2p: np.ndarray) -> Contender:
    number = of.log.propose("a test", 0.1, 1.0)
    return measured(of, register(of, p2p, Schedule.of(of, of.parameters.coarse_to_fine)), number)


def found(of: MatchProblem, p2p: np.ndarray, margin: float = 1.2, distortion: float = 0.1) -> Found:
    return Found(Decision(replace(contender(of, p2p), mean_distortion=distortion), margin, 0.1), False)


def error(of: MatchProblem, p2p: np.ndarray) -> float:
    return float(geodesic_error(p2p, np.arange(of.x.n_vertices), of.y.surface).mean())


def symmetries(of: MatchProblem) -> tuple[np.ndarray, np.ndarray]:
    mirrors = [reflection_of(shape, of.parameters) for shape in (of.x, of.y)]
    assert mirrors[0] is not None
    assert mirrors[1] is not None
    return mirrors[0], mirrors[1]


def test_ends_are_those_of_limbs_and_know_their_mirror_images() -> None:
    of = problem()
    for shape, mirror in zip((of.x, of.y), symmetries(of), strict=True):
        ends = LimbEnds.of(shape, mirror, of.parameters)
        unit = np.array(DIRECTIONS) / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
        vertices = shape.unit.vertices[ends.vertices]
        limb = (vertices / np.linalg.norm(vertices, axis=1, keepdims=True) @ unit.T).argmax(axis=1)
        assert sorted(limb) == [0, 1, 2, 3, 4]
        np.testing.assert_array_equal(limb[ends.partners], np.array([0, 2, 1, 4, 3])[limb])


@pytest.mark.parametrize(
    ("partners_x", "partners_y", "count", "size"),
    [
        ([1, 0, 3, 2, 4], [1, 0, 3, 2, 4], 8, 5),  # which pair, and which of the two, and the head
        ([1, 0, 3, 2, 4, 5], [1, 0, 3, 2, 4], 16, 5),  # one of two ends on the axis is left out
        ([1, 0, 3, 2], [1, 0, 3, 2], 8, 4),
        ([1, 0, 3, 2, 4], [1, 0, 2, 3, 4], 0, 0),  # one pair beside three ends on the axis
        ([1, 0, 3, 2, -1], [1, 0, 3, 2, -1], 8, 5),
        ([0, 1, 2], [0, 1, 2], 0, 0),  # too few
    ],
)
def test_matchings_are_those_that_commute_with_the_symmetries(
    partners_x: list[int], partners_y: list[int], count: int, size: int
) -> None:
    found = symmetric_matchings(np.array(partners_x), np.array(partners_y), 4)
    assert found.shape == (count, len(partners_x))
    for matching in found:
        assert (matching >= 0).sum() == size
        assert len(set(matching[matching >= 0])) == size
        for i, j in enumerate(matching):
            if j >= 0 and partners_x[i] >= 0 and partners_y[j] >= 0:
                assert matching[partners_x[i]] == partners_y[j]


def test_one_of_the_maps_is_right_though_distances_differ() -> None:
    of = problem()
    maps = limb_maps(of, *symmetries(of))
    assert 4 <= len(maps) <= of.parameters.limb_hypotheses
    to = of.y.surface
    errors = [geodesic_error(h.p2p, h.points, to).mean() for h in maps]  # the same mesh: the truth is the number
    assert min(errors) < 0.15
    assert maps[int(np.argmin(errors))].mean_distortion > of.parameters.hardly_isometric
    assert [h.mean_distortion for h in maps] == sorted(h.mean_distortion for h in maps)


def test_a_wrong_map_gives_way_to_the_right_one() -> None:
    of = problem()
    wrong = found(of, turned())
    assert error(of, wrong.decision.best.dense.p2p) > 0.3
    better = with_limbs_matched(of, wrong)
    assert error(of, better.decision.best.dense.p2p) < 0.1
    assert 1 < better.decision.margin < np.inf
    chosen = of.log.chosen
    assert chosen is not None
    assert chosen.number == better.decision.best.number
    assert chosen.end_cost == better.decision.best.end_cost
    assert chosen.preview_cost is not None


@pytest.mark.slow
@pytest.mark.parametrize("finer", ["X", "Y"])
def test_shapes_may_have_other_numbers_of_vertices(finer: str) -> None:
    """Both ways, as where the first one leaves a doubt: below 2000 vertices there are no proxies of one size."""
    small = Surface(*limbed(DIRECTIONS, (0.5, 1.4, 1.4, 0.7, 0.7), 2))
    large = body(0.8, 1.5)
    doubting = MatchingParameters(hardly_isometric=0.0, limb_margin=1e300)
    of = MatchProblem.of(*((large, small) if finer == "X" else (small, large)), doubting)
    directions = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in (of.x.surface.vertices, of.y.surface.vertices)]
    identity = np.linalg.norm(directions[0][:, None] - directions[1][None], axis=2).argmin(axis=1)
    wrong = found(of, np.roll(identity, 30))
    better = with_limbs_matched(of, wrong)
    best = better.decision.best
    assert best.dense.p2p.shape == (of.x.n_vertices,)
    assert best.dense.inverse.shape == (of.y.n_vertices,)
    assert best.end_cost < wrong.decision.best.end_cost


@pytest.mark.slow
def test_the_hand_that_was_found_is_kept() -> None:
    of = MatchProblem.of(body(0.8, 1.5), Surface(body(1.4, 0.7).vertices * [-1, 1, 1], body(1.4, 0.7).faces[:, ::-1]))
    asked = of.with_mirrored_y()
    better = with_limbs_matched(of, replace(found(asked, turned()), mirrored=True))
    assert better.mirrored
    assert error(of, better.decision.best.dense.p2p) < 0.1


def test_a_right_map_stays_and_its_margin_can_only_shrink() -> None:
    of = problem()
    right = found(of, np.arange(of.x.n_vertices), margin=2.0)
    after = with_limbs_matched(of, right)
    assert error(of, after.decision.best.dense.p2p) < 0.1
    assert after.decision.best.end_cost <= right.decision.best.end_cost


def test_nothing_is_sought_where_distances_are_kept_or_the_map_is_clear() -> None:
    of, given = problem(), problem().parameters
    kept = found(of, turned(), distortion=given.hardly_isometric)
    assert with_limbs_matched(of, kept) is kept
    clear = found(of, turned(), margin=given.limb_margin, distortion=given.near_isometric)
    assert with_limbs_matched(of, clear) is clear


def test_what_is_far_from_isometric_is_not_clear_by_its_margin() -> None:
    """A gorilla onto a woman, hands onto feet at a margin of 3.1; such a map would not be called sure in any case."""
    of, given = problem(), problem().parameters
    far = found(of, turned(), margin=1e300, distortion=1.01 * given.near_isometric)
    assert error(of, with_limbs_matched(of, far).decision.best.dense.p2p) < 0.1


@pytest.mark.slow
def test_nothing_is_sought_without_a_symmetry() -> None:
    crooked = Surface(*limbed(DIRECTIONS[:4], (0.5, 0.3, 1.2, 0.9), 3))
    of = MatchProblem.of(crooked, crooked)
    assert reflection_of(of.x, of.parameters) is None
    some = found(of, np.arange(crooked.n_vertices))
    assert with_limbs_matched(of, some) is some


class TestDecidedAmong:
    """What a decision is once other maps have been taken to the end."""

    @pytest.fixture
    def maps(self) -> tuple[Contender, Contender]:
        of = problem()
        right, wrong = contender(of, np.arange(of.x.n_vertices)), contender(of, turned())
        right = replace(right, end_cost=1.0, relief_agreement=0.9)
        return right, replace(wrong, end_cost=3.0, relief_agreement=0.5)

    def test_the_cheapest_is_the_best_and_the_former_one_its_rival(self, maps: tuple[Contender, Contender]) -> None:
        right, wrong = maps
        decision = decided_among(problem(), Decision(wrong, 1.5, 0.2), [right])
        assert decision.best is right
        assert decision.margin == 3.0
        assert decision.runner_up == wrong.mean_distortion
        assert decision.contrary == np.inf  # what bulges agrees better along the one that was chosen

    def test_of_the_same_map_rivals_are_the_same(self, maps: tuple[Contender, Contender]) -> None:
        right, _ = maps
        dearer = replace(right, end_cost=1.5)
        decision = decided_among(problem(), Decision(dearer, 2.0, 0.2, contrary=4.0), [right])
        assert (decision.best, decision.margin, decision.runner_up) == (right, 3.0, 0.2)
        assert decision.contrary == 6.0

    def test_a_dearer_one_is_a_rival(self, maps: tuple[Contender, Contender]) -> None:
        right, wrong = maps
        agreeing = replace(wrong, relief_agreement=0.99)
        decision = decided_among(problem(), Decision(right, np.inf, np.inf), [agreeing])
        assert (decision.best, decision.margin, decision.contrary) == (right, 3.0, 3.0)
        assert decided_among(problem(), Decision(right, 2.0, 0.1), [wrong]).margin == 2.0


class TestLedByKernels:
    """Which map is gone on with after heat kernels had their say, and which is finished."""

    @pytest.fixture
    def maps(self) -> tuple[Contender, Contender]:
        of = problem()
        before, led = contender(of, np.arange(of.x.n_vertices)), contender(of, turned())
        return replace(before, without_kernels=1.0, end_cost=3.0), replace(led, without_kernels=2.0, end_cost=1.0)

    def test_a_part_that_was_led_elsewhere_and_fits_worse_there_is_finished_where_it_was(
        self, maps: tuple[Contender, Contender]
    ) -> None:
        before, led = maps
        taken = led_by_kernels(problem(), before, led)
        assert (taken.dense, taken.end_cost, taken.hks_agreement) == (led.dense, 1.0, led.hks_agreement)
        assert taken.to_finish is before.dense

    def test_a_part_that_fits_about_as_well_elsewhere_belongs_there(self, maps: tuple[Contender, Contender]) -> None:
        before, led = maps
        taken = led_by_kernels(problem(), before, replace(led, without_kernels=1.2))
        assert taken.to_finish is led.dense

    def test_what_has_hardly_moved_is_taken_as_it_was_led(self, maps: tuple[Contender, Contender]) -> None:
        _, led = maps
        assert led_by_kernels(problem(), replace(led, without_kernels=1.0, end_cost=3.0), led).to_finish is led.dense

    def test_what_costs_more_at_the_end_is_not_taken(self, maps: tuple[Contender, Contender]) -> None:
        before, led = maps
        assert led_by_kernels(problem(), before, replace(led, end_cost=3.5)) is before

    def test_a_reflection_relates_limbs_that_are_alike(self, maps: tuple[Contender, Contender]) -> None:
        before, led = maps
        of = MatchProblem.of_reflection(problem().x, problem().parameters)
        assert led_by_kernels(of, before, led).to_finish is led.dense


@pytest.mark.slow
@pytest.mark.thorough
def test_the_tail_of_a_wolf_goes_onto_that_of_a_lion(data_dir: Path) -> None:
    """It went onto a hind leg, which is as stout as it is: .037 in the mean, a thirtieth of the surface .6 away."""
    folder = data_dir / "harder" / "smal_r"
    if not folder.is_dir():
        pytest.skip(f"no such folder: {folder}")
    animals = BENCHMARKS["smal_r"].read(folder)
    wolf, lion = "wolf_alph3", "lion_yawn"
    found = match(animals.read(wolf), animals.read(lion))
    truth = animals.truth(wolf, lion)
    errors = geodesic_error(found.p2p[truth.points], truth.images, animals.read(lion))
    assert errors.mean() < 0.025
    assert (errors > 0.2).mean() < 0.005
    assert found.confident
    assert found.hks_agreement < MatchingParameters().match_alike  # the least that is asked for of other maps
