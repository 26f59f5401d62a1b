"""Old names of parameters, for one more release: taken with a warning that says the new one."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

from qgeo_filters.errors import ParameterError

F = TypeVar("F", bound=Callable[..., Any])


def renamed_parameters(**new_of_old: str) -> Callable[[F], F]:
    """Decorator of a function whose keyword arguments were renamed: ``@renamed_parameters(weight="curvature_weight")``.

    Raises
    ------
    ParameterError
        When called with both the old and the new name.
    """

    def decorate(function: F) -> F:
        called = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]  # a class by its own name

        @functools.wraps(function)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            for old, new in new_of_old.items():
                if old in kwargs:
                    if new in kwargs:
                        raise ParameterError(f"{called}: {old} is the old name of {new}; give only {new}")
                    warnings.warn(
                        f"{called}: {old} is now called {new}; the old name goes with the next release",
                        DeprecationWarning,
                        stacklevel=2,
                    )
                    kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return wrapper  # type: ignore[return-value]

    return decorate
