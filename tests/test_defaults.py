"""A word has one default, whether a function, a filter, a command or a widget takes it."""

from __future__ import annotations

import inspect
import typing
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import typer

import qgeo_filters as qg
from qgeo_filters import defaults
from qgeo_filters.cli import app
from qgeo_filters.filters.base import Filter

# Parameters whose default is a choice that one would have to look up.
WORDS = (
    "accuracy",
    "curvature_weight",
    "k",
    "k0",
    "mass",
    "normalize",
    "reading",
    "scalar",
    "smoothing",
)


def doors() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Everything that a user calls, by name."""
    for name in qg.__all__:
        value = getattr(qg, name)
        if inspect.isroutine(value) or (inspect.isclass(value) and issubclass(value, Filter)):
            yield name, value
    for command in app.registered_commands:
        assert command.callback is not None
        yield f"qgeo {command.callback.__name__}", command.callback
    qw = pytest.importorskip("qgeo_widgets")
    for name in qw.__all__:
        yield f"qw.{name}", getattr(qw, name)


def default_of(parameter: inspect.Parameter) -> Any:
    """Default of a parameter; an empty one for a parameter without, or with one that stands for another."""
    value = parameter.default
    if isinstance(value, typer.models.OptionInfo):
        value = value.default
    return inspect.Parameter.empty if value is None else value


@pytest.mark.parametrize("word", WORDS)
def test_a_word_has_one_default(word: str) -> None:
    found: defaultdict[Any, list[str]] = defaultdict(list)
    for name, door in doors():
        parameter = inspect.signature(door).parameters.get(word)
        if parameter is not None and default_of(parameter) is not inspect.Parameter.empty:
            found[default_of(parameter)].append(name)
    assert len(found) <= 1, dict(found)


def test_overloads_show_the_defaults_that_hold() -> None:
    """Editors show the signatures of overloads, not the one that runs."""
    seen = set()
    for name, door in doors():
        holds = inspect.signature(door).parameters
        for overload in typing.get_overloads(inspect.unwrap(door)):
            seen.add(name)
            shown = inspect.signature(overload).parameters
            assert list(shown) == list(holds), name
            for key, parameter in shown.items():
                assert parameter.default in (holds[key].default, inspect.Parameter.empty), (name, key)
    assert "match" in seen


def test_commands_and_widgets_take_the_shared_defaults() -> None:
    weights = {
        name: inspect.signature(door).parameters["curvature_weight"].default
        for name, door in doors()
        if "curvature_weight" in inspect.signature(door).parameters
    }
    assert {"qgeo path", "qgeo distances", "qw.compare", "qw.geodesics", "SelfSymmetry"} <= set(weights)
    assert set(weights.values()) - {None} == {defaults.CURVATURE_WEIGHT}
    k0 = {name: inspect.signature(door).parameters.get("k0") for name, door in doors()}
    assert {name for name, one in k0.items() if one is not None} >= {"qgeo symmetry", "SelfSymmetry"}


def test_sliders_begin_at_the_shared_defaults() -> None:
    from qgeo_widgets.geodesics_widget import GeodesicsWidget
    from qgeo_widgets.symmetry_widget import SymmetryWidget

    assert SymmetryWidget.k0.default_value == SymmetryWidget.k0.max == defaults.SYMMETRY_K0
    assert GeodesicsWidget.curvature_weight.default_value == defaults.CURVATURE_WEIGHT
