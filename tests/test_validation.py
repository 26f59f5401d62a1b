"""Checks of numbers of things; those of meshes are in test_surface_validation."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.errors import ParameterError
from qgeo_filters.testing import sample_surface
from qgeo_filters.validation import checked_count


@pytest.mark.parametrize("value", [1, 7, np.int64(3), np.uint8(5)])
def test_numbers_in_range_come_out_as_ints(value: int) -> None:
    assert type(checked_count(value, 1, 7, "k")) is int
    assert checked_count(value, 1, 7, "k") == value


@pytest.mark.parametrize("value", [0, 8, -1, True, np.True_, 2.0, np.float64(3), "3", None, [2], np.nan])
def test_all_else_is_refused(value: object) -> None:
    with pytest.raises(ParameterError, match=r"^k must be between 1 and the 7 dwarfs, got "):
        checked_count(value, 1, 7, "k", "the 7 dwarfs")  # type: ignore[arg-type]


def test_without_upper_bound() -> None:
    assert checked_count(10**12, 1, None, "passes") == 10**12
    with pytest.raises(ParameterError, match=r"^passes must be a whole number, at least 1, got 0$"):
        checked_count(0, 1, None, "passes")


def test_booleans_and_fractions_are_no_numbers_of_eigenpairs() -> None:
    """Before, True was one eigenpair, and a spectrum truncated to 1.5 failed inside NumPy."""
    surface = sample_surface()
    for k in (True, 2.5):
        with pytest.raises(ParameterError, match="k must be between 1 and the number of vertices"):
            qg.laplacian_spectrum(surface, k)  # type: ignore[arg-type]
    spectrum = qg.laplacian_spectrum(surface, 4)
    for k in (True, 1.5, 0, 5):
        with pytest.raises(ParameterError, match="k must be between 1 and the 4 eigenpairs of this spectrum, got"):
            spectrum.truncated(k)  # type: ignore[arg-type]
