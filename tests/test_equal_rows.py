"""Equal rows of a table, against `numpy.unique`."""

from __future__ import annotations

import numpy as np
import pytest

from qgeo_filters.equal_rows import equal_rows, occurring


@pytest.mark.parametrize("dtype", [np.int32, np.int64, np.float64])
def test_rows_are_equal_as_numpy_says(dtype):
    rows = np.random.default_rng(0).integers(0, 4, (500, 3)).astype(dtype)
    number, first = equal_rows(rows)
    _, expected_first, expected = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(np.sort(first), np.sort(expected_first))
    np.testing.assert_array_equal(rows[first[number]], rows)
    assert len(np.unique(np.column_stack([number, expected.ravel()]), axis=0)) == len(first)


def test_minus_nought_is_nought_and_nan_is_nothing():
    number, first = equal_rows(np.array([[0.0, 1.0], [-0.0, 1.0], [np.nan, 1.0], [np.nan, 1.0]]))
    assert number[0] == number[1]
    assert len(set(number.tolist())) == 3
    assert len(first) == 3


def test_no_rows_are_no_groups():
    number, first = equal_rows(np.empty((0, 3)))
    assert len(number) == len(first) == 0
    assert occurring(np.empty((0, 3), np.int32), 4).size == 0


def test_indices_that_occur():
    np.testing.assert_array_equal(occurring(np.array([[3, 1], [1, 0]]), 5), [0, 1, 3])
