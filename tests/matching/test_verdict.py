"""When a map is called sure, from its numbers alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.verdict import verdict

GIVEN = MatchingParameters()
#: A map that leaves nothing to be wished.
CLEAR = {"score": 0.02, "turned": 0.75, "alike": 0.98, "margin": 4.0, "contrary": np.inf}


def test_a_clear_map_is_sure() -> None:
    sure, said = verdict(GIVEN, **CLEAR)
    assert sure
    assert "costs 4.0 times as much" in said
    assert verdict(GIVEN, **CLEAR | {"margin": np.inf})[1].endswith("there is no other map")


@pytest.mark.parametrize(
    ("worse", "said"),
    [
        ({"score": 0.13}, "not near-isometric"),
        ({"turned": -0.2}, "parts may be mirrored"),
        ({"alike": 0.8}, "parts of different shape"),
        ({"score": 0.11, "margin": 1.9}, "hardly isometric"),
        ({"score": 0.065, "margin": 1.9, "alike": 0.92}, "hardly isometric"),
        ({"margin": 1.2}, "looks alike in more than one way"),
        ({"margin": 1.44, "contrary": 1.44}, "agrees better along it"),
    ],
)
def test_any_doubt_is_said(worse: dict[str, float], said: str) -> None:
    sure, explanation = verdict(GIVEN, **CLEAR | worse)
    assert not sure
    assert said in explanation


def test_a_map_of_better_relief_must_cost_clearly_more() -> None:
    assert verdict(GIVEN, **CLEAR | {"contrary": 2.1})[0]
    assert verdict(replace(GIVEN, contrary_margin=1.3), **CLEAR | {"margin": 1.44, "contrary": 1.44})[0]


def test_poses_of_one_shape_may_be_hardly_isometric() -> None:
    assert verdict(GIVEN, **CLEAR | {"score": 0.065, "margin": 1.35, "alike": 0.97})[0]


def test_what_is_less_alike_must_be_much_clearer() -> None:
    assert not verdict(GIVEN, **CLEAR | {"alike": 0.84, "margin": 4.9})[0]
    assert verdict(GIVEN, **CLEAR | {"alike": 0.84, "margin": 5.1})[0]
    assert not verdict(GIVEN, **CLEAR | {"alike": 0.81, "margin": 50.0})[0]
    assert not verdict(GIVEN, **CLEAR | {"alike": 0.84, "margin": np.inf})[0]  # none was found: that is not clear


def test_surfaces_that_have_grown_together_may_be_less_alike() -> None:
    assert not verdict(GIVEN, **CLEAR | {"alike": 0.84})[0]
    assert verdict(GIVEN, **CLEAR | {"alike": 0.84}, grown=True)[0]
    assert not verdict(GIVEN, **CLEAR | {"alike": 0.75}, grown=True)[0]
