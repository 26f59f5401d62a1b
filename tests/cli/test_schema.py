"""The schema of result.json: every command has a part in it, and it refuses what is not so.

That the files of all commands are as it says is held by the fixture ``loaded``, through which their tests read them.
"""

from __future__ import annotations

import copy
import importlib.resources
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import typer.main
from typer.testing import Result

from qgeo_filters.cli import app

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, Any]]]

SCHEMA = json.loads((importlib.resources.files("qgeo_filters.cli") / "result.schema.json").read_text("utf-8"))
#: Commands without a result.json.
WITHOUT = {"fetch", "warmup", "collection"}


def test_each_command_has_a_part() -> None:
    commands = set(typer.main.get_group(app).commands) - WITHOUT  # type: ignore[attr-defined]
    parts = {case["if"]["properties"]["command"]["const"] for case in SCHEMA["allOf"]}
    assert commands == parts
    assert parts <= set(SCHEMA["properties"]["command"]["enum"])
    assert parts <= set(SCHEMA["$defs"])


def test_numbers_that_are_not_finite_are_words(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("match", "blob.off", "mirror.off", "--no-pictures", "-o", "out").exit_code == 0
    content, _ = loaded(Path("out"))
    for value in ("inf", "nan", 2.5, 3):
        content["results"]["runner_up"] = value
        jsonschema.validate(content, SCHEMA)
    content["results"]["runner_up"] = "much"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, SCHEMA)


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content["results"].pop("area"),
        lambda content: content["results"].update(area="large"),
        lambda content: content["results"].update(new=1),
        lambda content: content.update(command="other"),
        lambda content: content.update(meshes=[content["mesh"]]),
        lambda content: content["mesh"].pop("path"),
        lambda content: content["sha256"].update({"result.npz": "0"}),
        lambda content: content["files"].remove("result.json"),
        lambda content: content.update(extra={}),
    ],
)
def test_what_is_not_so_is_refused(qgeo: Qgeo, loaded: Loaded, change: Callable[[dict[str, Any]], object]) -> None:
    assert qgeo("info", "blob.off", "--no-pictures", "-o", "out").exit_code == 0
    content = copy.deepcopy(loaded(Path("out"))[0])
    jsonschema.validate(content, SCHEMA)
    change(content)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, SCHEMA)
