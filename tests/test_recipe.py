"""The conda recipe and the lowest versions that are tested are those of pyproject.toml."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

import qgeo_filters as qg

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE: dict[str, Any] = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
#: What conda calls otherwise.
CONDA = {"libigl": "igl", "matplotlib": "matplotlib-base"}


def parts(requirement: str) -> tuple[str, str]:
    """Name of a requirement, in one spelling, and the versions that it admits."""
    name, versions = re.fullmatch(r"([\w.-]+)\s*(.*)", requirement).groups()  # type: ignore[union-attr]
    return re.sub(r"[-_.]+", "-", name).lower(), versions


def test_the_recipe_has_the_versions_of_the_package() -> None:
    assert RECIPE["context"]["version"] == qg.__version__
    needed = dict(map(parts, PROJECT["dependencies"]))
    expected = {CONDA.get(name, name): versions for name, versions in needed.items()}
    run = dict(map(parts, RECIPE["requirements"]["run"]))
    python = run.pop("python").replace("${{ python_min }}", RECIPE["context"]["python_min"])
    assert python == PROJECT["requires-python"]
    assert run == expected


def test_the_recipe_has_the_commands_of_the_package() -> None:
    expected = [f"{name} = {target}" for name, target in PROJECT["scripts"].items()]
    assert RECIPE["build"]["python"]["entry_points"] == expected


def oldest() -> Any:
    """The script that tests the lowest versions."""
    spec = importlib.util.spec_from_file_location("oldest", ROOT / ".ci" / "oldest.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_dependency_has_a_lowest_version_that_is_tested() -> None:
    script = oldest()
    lines = script.constraints(PROJECT)
    pinned = {parts(line)[0] for line in lines}
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)
    assert {parts(one)[0] for one in PROJECT["dependencies"]} <= pinned
    assert "zarr" in pinned
    assert all((ROOT / test).is_file() for test in script.SMOKE)


@pytest.mark.parametrize(
    ("requirement", "expected"),
    [
        ("numpy>=2.0", "numpy==2.0"),
        ("PyYAML >= 6.0.4", "PyYAML==6.0.4"),
        ("ruff==0.17.6", "ruff==0.17.6"),
        ("qgeo-filters[all]", None),
        ("scipy-stubs", None),
    ],
)
def test_lowest_versions(requirement: str, expected: str | None) -> None:
    assert oldest().lowest(requirement) == expected
