"""A chain of filters that is a filter itself, and its form as YAML."""

from __future__ import annotations

import importlib
import os
import pkgutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from qgeo_filters import filters
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters.base import REGISTRY, Filter
from qgeo_filters.surface import Surface

FORMAT = 1


class Pipeline(Filter):
    """Filters applied one after the other, each seeing the attributes of those before it.

    Parameters
    ----------
    steps : sequence of Filter
        Also made by ``a | b | c``. ``pipeline[i]`` and ``pipeline["ClassName"]`` give a step, which holds
        the results that are not per vertex.

    Notes
    -----
    The mesh is converted once at either end, and an expensive stage (scalar, distances, spectrum) that
    several steps need is computed once.
    """

    def __init__(self, steps: Sequence[Filter] = ()) -> None:
        self.steps = steps

    @property
    def outputs(self) -> Mapping[str, str]:  # type: ignore[override]
        """Attributes that all steps add."""
        return {name: text for step in self.steps for name, text in step.outputs.items()}

    @property
    def index_outputs(self) -> frozenset[str]:  # type: ignore[override]
        """Those attributes that hold vertex indices."""
        return frozenset().union(*(step.index_outputs for step in self.steps))

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Attributes that all steps add or replace."""
        after = self.apply(surface, progress)
        return {name: after.attributes[name] for name in after.attributes if name in self.outputs}

    def apply(self, surface: Surface, progress: bool = False) -> Surface:
        """Surface after the last step."""
        for step in self.steps:
            surface = step.apply(surface, progress)
        return surface

    def clone(self) -> Pipeline:
        """New pipeline of cloned steps."""
        return Pipeline([step.clone() for step in self.steps])

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, key: int | str) -> Filter:
        if isinstance(key, int):
            return self.steps[key]
        for step in self.steps:
            if type(step).__name__ == key:
                return step
        raise KeyError(f"no step {key!r}; the steps are {', '.join(type(step).__name__ for step in self.steps)}")

    def __repr__(self) -> str:
        return " | ".join(map(repr, self.steps)) if len(self.steps) > 1 else f"Pipeline({list(self.steps)!r})"

    # -- YAML ---------------------------------------------------------------------------------------

    def to_yaml(self) -> str:
        """The pipeline as YAML text.

        Raises
        ------
        ValueError
            For a parameter that text cannot hold (an array, a function, a mesh): its name is given.
        """
        steps = [
            {
                type(step).__name__: {
                    name: _plain(value, f"{type(step).__name__}.{name}") for name, value in step.get_params().items()
                }
            }
            for step in self.steps
        ]
        return yaml.safe_dump({"qgeo_pipeline": FORMAT, "steps": steps}, sort_keys=False)

    @classmethod
    def from_yaml(cls, text: str) -> Pipeline:
        """Pipeline from YAML text: ``qgeo_pipeline: 1`` and ``steps``, a list of ``FilterName: {parameter: value}``.

        Raises
        ------
        ValueError
            For text that is not YAML or no pipeline, an unknown filter or an unknown parameter.
        """
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError as error:
            raise ParameterError(f"the pipeline is not valid YAML: {' '.join(str(error).split())}") from error
        if not isinstance(content, dict) or not isinstance(content.get("steps"), list):
            raise ParameterError("the pipeline must be a mapping with qgeo_pipeline: 1 and a list of steps")
        if content.get("qgeo_pipeline") != FORMAT:
            raise ParameterError(
                f"the pipeline has format {content.get('qgeo_pipeline')!r}, this version reads qgeo_pipeline: {FORMAT}"
            )
        return cls([_step(position, entry) for position, entry in enumerate(content["steps"])])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as YAML, atomically."""
        with atomic_write(path) as file:
            file.write(self.to_yaml().encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Pipeline:
        """Pipeline from a YAML file, see `from_yaml`."""
        return cls.from_yaml(Path(path).read_text(encoding="utf-8"))


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


def _step(position: int, entry: Any) -> Filter:
    if isinstance(entry, str):
        entry = {entry: {}}
    if not isinstance(entry, dict) or len(entry) != 1:
        raise ParameterError(f"steps[{position}] must be one FilterName: {{parameter: value}}, got {entry!r}")
    name, params = next(iter(entry.items()))
    for module in pkgutil.iter_modules(filters.__path__, f"{filters.__name__}."):
        importlib.import_module(module.name)  # a filter is known once its module is loaded
    if name not in REGISTRY:
        raise ParameterError(
            f"steps[{position}] names the unknown filter {name!r}; known are {', '.join(sorted(REGISTRY))}"
        )
    params = params or {}
    if not isinstance(params, dict):
        raise ParameterError(f"steps[{position}] ({name}): parameters must be a mapping, got {params!r}")
    defaults = REGISTRY[name]().get_params()
    names = list(defaults)
    unknown = [key for key in params if key not in names]
    if unknown:
        raise ParameterError(
            f"steps[{position}]: {name} has no parameter {unknown[0]!r}; it has {', '.join(names) or 'none'}"
        )
    for key, value in params.items():
        if isinstance(value, list) and isinstance(defaults[key], tuple):  # YAML has no tuples
            params = {**params, key: tuple(value)}
    return REGISTRY[name](**params)
