"""A shape and one that has grown together: by distances that may only be shorter, a wrong map gives way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from grown_body import LIMBS, body, grown, prepared_body, prepared_grown

from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.matching.known_parts import KnownParts
from qgeo_filters.matching.match_log import CHOSEN
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.partial.distance_bounds import distance_bounds
from qgeo_filters.matching.partial.half_turns import half_turns
from qgeo_filters.matching.partial.part_choice import images_apart
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.placement import Placement
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.search import Found, chosen_map
from qgeo_filters.matching.selection.cost import measured
from qgeo_filters.matching.selection.decision import Decision
from qgeo_filters.matching.smooth_shells import register
from qgeo_filters.matching.topological_noise import robust_to_shortcuts
from qgeo_filters.surface import Surface


def shapes(with_handle: bool) -> tuple[PreparedShape, PreparedShape]:
    """Both, the one with a handle first or last."""
    return (prepared_grown(), prepared_body()) if with_handle else (prepared_body(), prepared_grown())


def problem(with_handle: bool) -> MatchProblem:
    return MatchProblem.of(*shapes(with_handle))


def turned_about(axis: int) -> np.ndarray:
    """Vertex of the body that is nearest after half a turn about an axis: limbs go to other limbs."""
    vertices = body().vertices
    signs = np.where(np.arange(3) == axis, 1, -1)
    return np.linalg.norm((vertices * signs)[:, None] - vertices[None], axis=2).argmin(axis=1)


def found(of: MatchProblem, p2p: np.ndarray, margin: float) -> Found:
    number = of.log.propose("a test", 0.1, 1.0)
    of.log.choose(number)
    dense = register(of, p2p, Schedule.of(of, of.parameters.coarse_to_fine))
    return Found(Decision(measured(of, dense, number), margin, 0.1), False)


def tips() -> list[int]:
    """Ends of the two limbs that have grown together."""
    return [int((body().vertices @ np.array(limb)).argmax()) for limb in LIMBS[:2]]


def with_landmarks(with_handle: bool, *pairs: tuple[int, int]) -> MatchProblem:
    return MatchProblem.of(*shapes(with_handle), landmarks=pairs)


def error(of: MatchProblem, p2p: np.ndarray) -> float:
    return float(geodesic_error(p2p, np.arange(of.x.n_vertices), of.y.surface).mean())


@pytest.mark.parametrize(("with_handle", "axis"), [(True, 0), (False, 2)])
def test_a_wrong_map_gives_way_to_the_right_one(with_handle: bool, axis: int) -> None:
    given = problem(with_handle)
    wrong = found(given, turned_about(axis), 1.2)
    assert error(given, wrong.decision.best.dense.p2p) > 0.2
    better = robust_to_shortcuts(given, wrong)
    assert error(given, better.decision.best.dense.p2p) < 0.03
    assert error(given, better.decision.best.dense.inverse) < 0.03
    chosen = given.log.chosen
    assert chosen is not None
    assert (chosen.number, chosen.fate) == (better.decision.best.number, CHOSEN)
    # The rival is the map that it was given, or another one.
    assert 1 < better.decision.margin < np.inf


@pytest.mark.slow
@pytest.mark.parametrize("with_handle", [True, False])
def test_the_wrong_way_up_is_found_out_though_nothing_else_is_proposed(
    with_handle: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = problem(with_handle)
    clean = given.y if with_handle else given.x
    turned = half_turns(clean.unit.vertices, clean.areas)[2]
    monkeypatch.setattr(Placement, "proposed", lambda _: [])
    better = robust_to_shortcuts(given, found(given, turned, 1.2))
    assert error(given, turned) > 0.2
    assert error(given, better.decision.best.dense.p2p) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("with_handle", [True, False])
def test_a_right_map_stays_and_its_margin_can_only_shrink(with_handle: bool) -> None:
    given = problem(with_handle)
    right = found(given, np.arange(body().n_vertices), 1.5)
    after = robust_to_shortcuts(given, right)
    assert after.decision.best is right.decision.best
    assert after.decision.margin <= right.decision.margin


@pytest.mark.slow
def test_nothing_is_sought_where_the_map_is_clear_or_the_shapes_have_as_many_handles() -> None:
    given = problem(True)
    seen = found(given, np.arange(body().n_vertices), given.parameters.grown_margin).decision
    alike_enough = replace(seen.best, hks_agreement=given.parameters.grown_clear)
    clear = Found(replace(seen, best=alike_enough), False)
    assert robust_to_shortcuts(given, clear) is clear
    below = replace(seen.best, hks_agreement=given.parameters.grown_clear - 0.01)
    assert robust_to_shortcuts(given, Found(replace(seen, best=below), False)).decision is not seen
    alike = MatchProblem.of(prepared_body(), prepared_body())
    wrong = found(alike, turned_about(0), 1.0)
    assert robust_to_shortcuts(alike, wrong) is wrong


def test_where_surfaces_may_have_grown_together_distances_may_be_shorter_but_not_longer() -> None:
    shape = PartShape(body(), 1.0, body().n_vertices, 40, PartialParameters())
    least, most = distance_bounds(shape, 40)
    np.testing.assert_array_equal(least, most)
    reached = shape.with_shortcuts(0.3)
    shorter, same = distance_bounds(reached, 40)
    np.testing.assert_array_equal(same, most)
    np.testing.assert_allclose(shorter, np.minimum(most, 0.6))
    assert shape.rim.min() > 100  # unchanged
    np.testing.assert_array_equal(reached.fps, shape.fps)


def test_a_boundary_nearer_than_a_shortcut_counts_as_before() -> None:
    half = body().submesh(body().vertices[:, 2] > -0.1)[0]
    shape = PartShape(half, 1.0, half.n_vertices, 40, PartialParameters())
    reached = shape.with_shortcuts(0.2)
    np.testing.assert_array_equal(reached.rim, np.minimum(shape.rim, 0.2))
    assert reached.rim.min() == 0


@pytest.mark.slow
def test_the_search_keeps_to_the_hand_that_was_found() -> None:
    """Matched as a mirror image of Y, the better map is one onto that image, too."""
    mirrored = Surface(grown().vertices * [-1, 1, 1], grown().faces[:, ::-1])
    given = MatchProblem.of(prepared_body(), mirrored)
    turned = given.with_mirrored_y()
    wrong = replace(found(turned, turned_about(2), 1.2), mirrored=True)
    better = robust_to_shortcuts(given, wrong)
    assert better.mirrored
    assert error(given, better.decision.best.dense.p2p) < 0.03


@pytest.mark.slow
def test_what_hints_did_to_the_choice_is_known_of_places_too() -> None:
    end = int((body().vertices @ [0.0, -1.0, 0.3]).argmax())
    given = with_landmarks(False, (end, end))
    # Turned places may agree with the landmark.
    chosen = replace(PartialParameters.of_grown_surfaces(), turned=0)
    better = robust_to_shortcuts(given, found(given, turned_about(2), 1.2), chosen)
    assert error(given, better.decision.best.dense.p2p) < 0.03
    assert better.decision.unhinted < better.decision.margin  # its rivals contradict the landmark, which is right


def hand_on_leg(merged: int) -> KnownParts:
    """A landmark on a hand, beside it the wrist, then the body, and a leg that the hand has grown onto on X."""
    on_merged, apart = (np.array([row], dtype=np.float32) for row in ([0, 0.08, 0.5, 0.06], [0, 0.08, 0.5, 1.1]))
    if merged < 0:
        on_merged, apart = apart, on_merged
    of = MatchingParameters()
    return KnownParts(np.zeros((1, 2), np.int64), np.zeros(0, np.int64), on_merged, apart, of, merged)


@pytest.mark.parametrize("merged", [1, -1])
def test_a_leg_that_a_hand_has_grown_onto_does_not_contradict_a_landmark_on_the_hand(merged: int) -> None:
    points, known = np.arange(4), hand_on_leg(merged)
    assert known.errors(points, points) == 0
    assert known.penalties(points, points) == 1
    assert not known.contradicted(points).any()
    # Hand and leg exchanged, and all of X on the body of Y.
    swapped, shrunk = np.array([3, 2, 1, 0]), np.full(4, 2)
    errors = known.errors(points, np.stack([points, swapped, shrunk]))[:, 0]
    # Means of .01 and .37; nothing of X is nearer to the hand than .5, or the hand goes .45 and the wrist .37 too far.
    np.testing.assert_allclose(errors, [0, 0.19, 0.4 if merged > 0 else 0.41], atol=1e-6)
    assert known.contradicted(swapped).all()
    assert known.contradicted(shrunk).all()
    there = known.swapped()
    assert there.merged == -merged
    assert there.errors(points, points) == 0


def test_registration_feels_a_landmark_only_beside_it_where_surfaces_have_grown_together() -> None:
    """So that the leg is not drawn to the hand: its profile on both surfaces differs by less than a few edges."""
    for merged in (1, -1):
        one, other = hand_on_leg(merged).profiles
        assert np.abs(one - other).max() < 0.05
    usual = replace(hand_on_leg(1), merged=0)
    assert np.abs(usual.profiles[0] - usual.profiles[1]).max() > 0.15
    assert usual.errors(np.arange(4), np.arange(4)) > 0.3


@pytest.mark.parametrize("with_handle", [True, False])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_landmarks_where_surfaces_have_grown_together_speak_against_wrong_maps(with_handle: bool, axis: int) -> None:
    one, other = tips()
    given = with_landmarks(with_handle, (one, one), (other, other))
    assert given.known is not None
    wrong = turned_about(axis)
    assert given.known.contradicted(wrong).any()
    assert given.penalties(np.arange(len(wrong)), wrong) > 5
    # Several maps at once, and the problem turned round.
    both = given.penalties(np.arange(len(wrong)), np.stack([np.arange(len(wrong)), wrong]))
    assert both[0] == 1
    assert both[1] == given.penalties(np.arange(len(wrong)), wrong)
    assert given.swapped().known.merged == -given.known.merged


@pytest.mark.slow
def test_places_that_are_found_without_hints_are_proposed_too() -> None:
    one, other = tips()
    given = with_landmarks(False, (one, other))  # the wrong limb
    hinted, free = (Placement(of, PartialParameters.of_grown_surfaces()) for of in (given, given.with_known(None)))
    proposed = [p2p for _, p2p in hinted.proposed()]
    same = PartialParameters().same
    for _, p2p in free.proposed():
        assert min(images_apart(hinted.y, p2p, known) for known in proposed) <= same
    exact = hinted.at_points(np.arange(body().n_vertices))
    assert min(images_apart(hinted.y, exact, p2p) for p2p in proposed) < 0.03


def test_what_is_found_without_hints_competes_where_surfaces_have_grown_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The search that the landmark leads astray gives way to the other one, as long as that agrees with it."""
    end = tips()[0]
    given = with_landmarks(True, (end, end))
    straight, astray = (found(given, p2p, 2.0) for p2p in (np.arange(body().n_vertices), turned_about(2)))
    monkeypatch.setattr("qgeo_filters.matching.search.searched", lambda of, _: astray if of.known else straight)
    chosen = chosen_map(given)
    assert chosen.decision.best.number == straight.decision.best.number
    assert given.log.chosen is not None
    assert given.log.chosen.number == straight.decision.best.number
    monkeypatch.setattr("qgeo_filters.matching.search.searched", lambda of, _: straight if of.known else astray)
    assert chosen_map(given) is straight
