"""Old names of parameters."""

from __future__ import annotations

import pytest

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters.errors import ParameterError


@renamed_parameters(weight="curvature_weight")
def lifted(surface: object, curvature_weight: float = 0.01) -> float:
    """Some docstring."""
    return curvature_weight


def test_the_old_name_is_taken_with_a_warning_at_the_caller() -> None:
    with pytest.warns(DeprecationWarning, match="weight is now called curvature_weight") as caught:
        assert lifted(None, weight=0.5) == 0.5
    assert caught[0].filename == __file__


def test_the_new_name_and_positions_are_silent(recwarn: pytest.WarningsRecorder) -> None:
    assert lifted(None, 0.5) == lifted(None, curvature_weight=0.5) == 0.5
    assert lifted.__doc__ == "Some docstring."
    assert not recwarn.list


def test_both_names_are_refused() -> None:
    with pytest.raises(ParameterError, match="give only curvature_weight"):
        lifted(None, weight=0.5, curvature_weight=0.1)
