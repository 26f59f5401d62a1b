"""Steps one after the other, by their names, and their parameters as those of the whole (scikit-learn's ``__``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, TypeVar

from qgeo_filters.errors import ParameterError
from qgeo_filters.filters.estimator import Estimator

C = TypeVar("C", bound="Composition[Any]")
Step = TypeVar("Step", bound=Estimator)


class Composition(Estimator, Generic[Step]):
    """What has steps: how they are named, found and given parameters; what they do together is for subclasses to say.

    Parameters
    ----------
    steps : sequence of Estimator
        A step may be a composition itself.
    """

    def __init__(self, steps: Sequence[Step] = ()) -> None:
        self.steps = steps

    @property
    def single_steps(self) -> list[Step]:
        """The steps in order; instead of a composition among them its own."""
        return [inner for step in self.steps for inner in single_steps(step)]

    @property
    def named_steps(self) -> dict[str, Step]:
        """The steps by class name; several of one class are numbered from 1, ``Paint-1`` and ``Paint-2``."""
        names = [type(step).__name__ for step in self.steps]
        numbered = [
            f"{name}-{names[: k + 1].count(name)}" if names.count(name) > 1 else name for k, name in enumerate(names)
        ]
        return dict(zip(numbered, self.steps, strict=True))

    def clone(self: C) -> C:
        """The same of cloned steps."""
        return type(self)([step.clone() for step in self.steps])

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The steps; with ``deep`` also each by its name, and their parameters as ``ClassName__parameter``."""
        params: dict[str, Any] = {"steps": self.steps}
        for name, step in self.named_steps.items() if deep else ():
            params[name] = step
            params |= {f"{name}__{key}": value for key, value in step.get_params().items()}
        return params

    def set_params(self: C, **params: Any) -> C:
        """The same with its steps, one of them, or some of their arguments replaced, in place.

        Raises
        ------
        ParameterError
            No such step, or no such argument of it.
        """
        if "steps" in params:
            self.steps = params["steps"]
        whole = {name: value for name, value in params.items() if name != "steps" and "__" not in name}
        for name, step in whole.items():
            self._require_step(name)
            self.steps = [step if known == name else other for known, other in self.named_steps.items()]
        for name, value in params.items():
            step_name, inner, key = name.partition("__")
            if inner:
                self._require_step(step_name).set_params(**{key: value})
        return self

    def _require_step(self, name: str) -> Step:
        if name not in self.named_steps:
            kind, known = type(self).__name__, ", ".join(self.named_steps)
            raise ParameterError(f"{kind} has no step {name!r}; it has {known or 'none'}")
        return self.named_steps[name]

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, key: int | str) -> Step:
        if isinstance(key, int):
            return self.steps[key]
        for step in self.single_steps:
            if type(step).__name__ == key:
                return step
        raise KeyError(f"no step {key!r}; the steps are {', '.join(type(step).__name__ for step in self.single_steps)}")


def single_steps(estimator: Any) -> list[Any]:
    """The steps of a composition, those of compositions within it too; of any other it alone."""
    return estimator.single_steps if isinstance(estimator, Composition) else [estimator]
