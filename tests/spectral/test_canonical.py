"""Signs, multiplets and angles between subspaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from qgeo_filters.spectral.canonical import canonical_signs, group_multiplets, subspace_sine


@given(seed=st.integers(0, 10**6), flips=st.lists(st.booleans(), min_size=5, max_size=5))
@settings(max_examples=50)
def test_signs_do_not_depend_on_those_that_came_in(seed, flips):
    rng = np.random.default_rng(seed)
    functions, areas = rng.normal(size=(60, 5)) ** 3, rng.uniform(0.1, 1, 60)
    flipped = functions * np.where(flips, -1.0, 1.0)
    turned = flipped * canonical_signs(flipped, areas)
    np.testing.assert_array_equal(turned, functions * canonical_signs(functions, areas))


def test_third_moment_decides_whatever_the_numbering():
    rng = np.random.default_rng(0)
    areas = rng.uniform(0.1, 1, 200)
    skewed = np.exp(rng.normal(size=200)) - 1.5
    order = rng.permutation(200)
    assert canonical_signs(skewed[:, None], areas) == [1.0]
    assert canonical_signs(-skewed[order, None], areas[order]) == [-1.0]


def test_antisymmetric_function_goes_by_its_first_extreme():
    x = np.linspace(-1, 1, 21)
    both = np.column_stack([x, -x])
    turned = both * canonical_signs(both, np.ones(21))
    np.testing.assert_array_equal(turned[:, 0], turned[:, 1])
    assert turned[0, 0] > 0


def test_zero_and_no_columns():
    assert canonical_signs(np.zeros((4, 1)), np.ones(4)) == [1.0]
    assert canonical_signs(np.zeros((4, 0)), np.ones(4)).shape == (0,)


def test_multiplets():
    assert group_multiplets([10, -5.0, 4.99, -4.96, -4.9, 1]) == ((0,), (1, 3, 4), (2,), (5,))
    assert group_multiplets([0.0, 2, 2.01, 6]) == ((0,), (1, 2), (3,))
    assert group_multiplets([1, 1.05], gap=0.1) == ((0, 1),)
    assert group_multiplets([]) == ()


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30))
def test_multiplets_are_a_partition(values):
    groups = group_multiplets(values)
    assert sorted(index for group in groups for index in group) == list(range(len(values)))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.7, np.pi / 2])
def test_sine_of_the_largest_angle(angle):
    areas = np.array([4.0, 1, 0.25, 1])
    basis = np.eye(4) / np.sqrt(areas)[:, None]
    turned = np.column_stack([basis[:, 0], np.cos(angle) * basis[:, 1] + np.sin(angle) * basis[:, 2]])
    assert subspace_sine(basis[:, :2], turned, areas) == pytest.approx(np.sin(angle), rel=1e-6, abs=1e-15)
