"""Pipelines as YAML text: names of filters and their parameters, in order."""

from __future__ import annotations

import os
import reprlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import yaml

from qgeo_filters.errors import ParameterError, reason

FORMAT = 1

Step = tuple[str, Mapping[str, Any]]
"""Name of a filter, and its parameters by name."""


def to_yaml(steps: Iterable[Step]) -> str:
    """YAML text of these steps.

    Raises
    ------
    ParameterError
        For a parameter that text cannot hold (an array of many values, a function, a mesh): its name is given.
    """
    plain = [
        {name: {key: _plain(value, f"{name}.{key}") for key, value in parameters.items()}} for name, parameters in steps
    ]
    return yaml.safe_dump({"qgeo_pipeline": FORMAT, "steps": plain}, sort_keys=False)


def from_yaml(text: str) -> list[Step]:
    """Steps that a text holds; whether such filters exist is not looked at.

    Raises
    ------
    ParameterError
        For text that is not YAML or no pipeline.
    """
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, LookupError, RecursionError) as error:  # as 2001-13-45, !!int "" and [[[... are
        raise ParameterError(f"the pipeline is not valid YAML: {reason(error)}") from error
    if not isinstance(content, dict) or not isinstance(content.get("steps"), list):
        raise ParameterError("the pipeline must be a mapping with qgeo_pipeline: 1 and a list of steps")
    if content.get("qgeo_pipeline") != FORMAT:
        found = reprlib.repr(content.get("qgeo_pipeline"))
        raise ParameterError(f"the pipeline has format {found}, this version reads qgeo_pipeline: {FORMAT}")
    return [_step(position, entry) for position, entry in enumerate(content["steps"])]


def _plain(value: Any, name: str) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray) and value.ndim <= 1 and value.size <= 1000:
        value = value.tolist()
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, (list, tuple)):
        return [_plain(item, name) for item in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ParameterError(f"{name} is of type {type(value).__name__}, which a saved pipeline cannot hold")


def _step(position: int, entry: Any) -> Step:
    if isinstance(entry, str):
        entry = {entry: {}}
    if not isinstance(entry, dict) or len(entry) != 1:
        raise ParameterError(
            f"steps[{position}] must be one FilterName: {{parameter: value}}, got {reprlib.repr(entry)}"
        )
    name, parameters = next(iter(entry.items()))
    parameters = {} if parameters is None else parameters
    if not isinstance(parameters, dict) or not all(isinstance(key, str) for key in parameters):
        given = reprlib.repr(parameters)
        raise ParameterError(
            f"steps[{position}] ({reprlib.repr(name)}): parameters must be a mapping by name, got {given}"
        )
    return str(name), parameters
