"""Which place of a part is chosen: several are found, the cheapest come to rest, and that of least strain wins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import bent, creature

from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.partial.landmark_search import least_costs
from qgeo_filters.matching.partial.part_choice import PartChoice, PlacedPart
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.surface import Surface

SETTLED = 2


@pytest.fixture(scope="module")
def choice() -> PartChoice:
    """One side of a body, bent, on the whole: it fits nearly on the other side, too. Two places are settled."""
    body = Surface(*creature())
    part, _ = body.submesh(body.vertices[:, 0] > 0)
    label = part.components[1]
    part, _ = part.submesh(label == np.bincount(label).argmax())
    given, unit = replace(PartialParameters(), settled=SETTLED), float(np.sqrt(body.area))
    x = PartShape(Surface(bent(part.vertices, 0.2), part.faces), unit, 1500, given.part_points, given)
    return PartChoice(x, PartShape(body, unit, 2000, given.whole_points, given), MatchLog())


@pytest.fixture(scope="module")
def places(choice: PartChoice) -> list[PlacedPart]:
    return choice.places()


def test_the_cheapest_places_come_first(places: list[PlacedPart]) -> None:
    costs = [p.cost for p in places]
    assert len(costs) > SETTLED
    assert costs == sorted(costs)


def test_places_that_settle_strain_less_and_the_rest_stay(choice: PartChoice, places: list[PlacedPart]) -> None:
    settled = choice.settled(places)
    assert sorted(p.number for p in settled) == sorted(p.number for p in places)
    before = {p.number: p for p in places}
    moved = [p for p in settled if p is not before[p.number]]
    assert {p.number for p in moved} >= {p.number for p in places[:SETTLED]}
    assert len(moved) <= SETTLED + 1  # and the first that is different
    for place in moved:
        assert place.cost < 1.02 * before[place.number].cost
    wrong = moved[1]  # the right one has nowhere to go
    assert wrong.strain < 0.95 * before[wrong.number].strain


def test_a_cost_is_the_product_of_powers(choice: PartChoice, places: list[PlacedPart]) -> None:
    """Neither torn edges nor distances count: a right place tears what is finer, and keeps distances worse."""
    limits = choice.given
    for place in places:
        strain, folded = max(place.strain, limits.least_strain), place.folded + limits.least_folded
        expected = strain * np.sqrt(folded) * (place.unlikeness + limits.least_unlikeness)
        assert place.cost == pytest.approx(expected)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(0, 5), min_size=1, max_size=40), st.integers(1, 50))
def test_least_costs_are_those_of_a_stable_sort(values: list[int], count: int) -> None:
    costs = np.array(values, dtype=float)
    np.testing.assert_array_equal(least_costs(costs, count), np.argsort(costs, kind="stable")[:count])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cut-2--victoria12", "cut-1--20-michael5"])
def test_parts_of_people(data_dir: Path, name: str) -> None:
    """A hand of 6 % of a body, which cannot be sure, and most of a person, on another one."""
    folder = data_dir / "harder" / "pfarm"
    if not folder.is_dir():
        pytest.skip(f"cuts of people not found in {folder}")
    whole = "smpl-base-neutro"
    part, body = (Surface.read(folder / f"{stem}.off") for stem in (name, whole))
    truth = np.loadtxt(folder / f"maps/{name}_{whole}.map").astype(np.int64)
    found = match(part, body, partial=True, normalize=False, repair="force")
    known = (found.p2p >= 0) & (truth >= 0)
    assert geodesic_error(found.p2p[known], truth[known], body).mean() < 0.06
    assert not found.confident or part.area > 0.1 * body.area
