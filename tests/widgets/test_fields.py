"""Colours and their legends: what is equal looks equal, what diverges is centred, what is missing is grey."""

from __future__ import annotations

import re

import numpy as np
import pytest

from qgeo_filters.report.colors import MISSING
from qgeo_widgets.fields import ColorField, ScalarField, number_field, region_field


def ticks(html: str) -> list[tuple[float, float]]:
    """Place in per cent and value of each tick of a colour bar."""
    found = re.findall(r"left:([\d.]+)%.*?</span>([−\d.e+]+)</span>", html)
    return [(float(place), float(text.replace("−", "-"))) for place, text in found]


def test_ticks_stand_where_their_values_are():
    field = ScalarField([np.linspace(2.0, 7.0, 11)], "x")
    for place, value in ticks(field.legend(None)):
        assert place == pytest.approx(100 * (value - 2.0) / 5.0, abs=0.01)
    for place, value in ticks(field.legend((4.0, 5.0))):
        assert place == pytest.approx(100 * (value - 4.0), abs=0.01)
    assert len(ticks(field.legend(None))) >= 3


def test_signed_scale_is_centred_on_zero_over_both_panes():
    field = number_field([np.array([-1.0, 0.0, 0.5]), np.array([0.0, 4.0])], "f")
    assert field.signed
    assert field.bounds == (-4.0, 4.0)
    first, second = field.colors(None)
    np.testing.assert_array_equal(first[1], second[0])
    assert np.ptp(first[1]) < 0.02  # zero has no hue
    assert dict(ticks(field.legend(None)))[50.0] == 0.0


def test_one_scale_for_both_panes():
    one, other = ScalarField([np.array([0.0, 1.0]), np.array([1.0, 2.0])], "d").colors(None)
    np.testing.assert_array_equal(one[1], other[0])


def test_missing_values_are_grey_and_named():
    field = ScalarField([np.array([0.0, np.inf, 1.0])], "d")
    np.testing.assert_allclose(field.colors(None)[0][1], MISSING)
    assert "no value" in field.legend(None)
    assert field.bounds == (0.0, 1.0)


def test_a_constant_and_nothing_at_all_have_a_legend():
    constant = ScalarField([np.full(4, 3.5)], "c")
    assert "3.5" in constant.legend(None)
    nothing = ScalarField([np.full(4, np.nan)], "n")
    assert nothing.bounds is None
    np.testing.assert_allclose(nothing.colors(None)[0], np.tile(MISSING, (4, 1)))


def test_regions_of_one_number_have_one_color_in_both_panes():
    field = region_field([np.array([0, 1, 2, -1]), np.array([2, 0, -1])], "regions")
    one, other = field.colors(None)
    np.testing.assert_array_equal(one[2], other[0])
    np.testing.assert_array_equal(one[0], other[1])
    np.testing.assert_allclose(one[3], 0.62)
    assert len(np.unique(one, axis=0)) == 4
    assert field.legend(None).count("display:inline-block;width:11px") == 4


def test_legends_escape_what_users_name():
    for field in (ScalarField([np.arange(3.0)], "<b>&"), ColorField([np.zeros((3, 3))], "<b>&")):
        assert "&lt;b&gt;&amp;" in field.legend(None)
