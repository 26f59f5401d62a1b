"""The examples in the docstrings of public names run, and show what they say; every public name has one."""

from __future__ import annotations

import doctest
import inspect
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import qgeo_filters as qg
import qgeo_widgets as qw

#: What an example may take for granted.
GIVEN = {"qg": qg, "np": np}
PACKAGES = {"qgeo_filters": qg, "qgeo_widgets": qw}
#: Most of what these have reads data sets, which cannot be shown in a few lines.
MODULES = {"qgeo_filters.evaluation": qg.evaluation, "qgeo_filters.testing": qg.testing}


def public_objects(modules: Mapping[str, ModuleType]) -> dict[str, Any]:
    """Functions and classes that modules list in ``__all__``, or else define, by dotted name."""
    found = {}
    for root, module in modules.items():
        for name in getattr(module, "__all__", [name for name in vars(module) if not name.startswith("_")]):
            value = getattr(module, name)
            own = hasattr(module, "__all__") or getattr(value, "__module__", None) == root
            if own and (inspect.isroutine(value) or inspect.isclass(value)):
                found[f"{root}.{name}"] = value
    return found


PUBLIC = public_objects(PACKAGES)
OBJECTS = {**PUBLIC, **public_objects(MODULES)}


def examples_of(name: str) -> list[doctest.DocTest]:
    """Examples of a name and of the methods that it defines itself."""
    value = OBJECTS[name]
    found = doctest.DocTestFinder(exclude_empty=True).find(value, name, globs=dict(GIVEN))
    return [test for test in found if test.examples]


@pytest.mark.parametrize("name", sorted(name for name in OBJECTS if examples_of(name)))
def test_examples_run(name: str) -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    report: list[str] = []
    for test in examples_of(name):
        runner.run(test, out=report.append)
    assert not runner.failures, "".join(report)


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_has_an_example_that_runs(name: str) -> None:
    own = [test for test in examples_of(name) if test.name == name]
    assert own, f"{name} has no example: add a section Examples with a few lines that take a second at most"
    assert not any(doctest.SKIP in example.options for example in own[0].examples)
