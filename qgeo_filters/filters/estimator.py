"""Parameters of filters, and fit and transform, as scikit-learn has them; scikit-learn itself is not needed."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, TypeVar

from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.arrays import is_path
from qgeo_filters.hosts.dispatch import is_host_mesh
from qgeo_filters.surface import Surface

E = TypeVar("E", bound="Estimator")


class Estimator:
    """What is called with a mesh and has parameters, as a step of scikit-learn's pipelines.

    Its parameters are those of its constructor, each stored under its own name.
    """

    renamed: ClassVar[Mapping[str, str]] = {}
    """New name of each parameter that had another: the old one is taken too, with a DeprecationWarning."""

    def __call__(self, mesh: Any) -> Any:
        """What is made of one mesh."""
        raise NotImplementedError

    # -- parameters ---------------------------------------------------------------------------------

    @classmethod
    def _parameter_names(cls) -> list[str]:
        return list(inspect.signature(cls).parameters)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Constructor arguments by name; ``deep`` adds those of a pipeline's steps, as ``ClassName__parameter``."""
        return {name: getattr(self, name) for name in self._parameter_names()}

    def set_params(self: E, **params: Any) -> E:
        """The filter with some arguments replaced, in place; unknown names raise ParameterError."""
        names = self._parameter_names()
        for name, value in params.items():
            if name in self.renamed:
                kind, old, name = type(self).__name__, name, self.renamed[name]
                warnings.warn(
                    f"{kind}: {old} is now called {name}; the old name goes with the next release",
                    DeprecationWarning,
                    stacklevel=2,
                )
            if name not in names:
                raise ParameterError(
                    f"{type(self).__name__} has no parameter {name!r}; it has {', '.join(names) or 'none'}"
                )
            setattr(self, name, value)
        return self

    def clone(self: E) -> E:
        """New filter of equal parameters, without results."""
        return type(self)(**self.get_params(deep=False))

    def __repr__(self) -> str:
        given = self.get_params(deep=False)
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in given.items())})"

    # -- steps of scikit-learn's pipelines ------------------------------------------------------------

    def fit(self: E, meshes: Any = None, y: Any = None) -> E:
        """The filter itself: there is nothing to be learnt."""
        return self

    def transform(self, meshes: Sequence[Any]) -> list[Any]:
        """What the filter makes of each mesh.

        Parameters
        ----------
        meshes : sequence of mesh objects, (V, F) or paths
            What scikit-learn calls X; a single mesh is called, ``filter(mesh)``.

        Raises
        ------
        ParameterError
            A single mesh.
        """
        if isinstance(meshes, (Surface, tuple)) or is_path(meshes) or is_host_mesh(meshes):
            raise ParameterError("transform takes a list of meshes: put a single one into a list, or call the filter")
        return [self(mesh) for mesh in meshes]

    def fit_transform(self, meshes: Sequence[Any], y: Any = None) -> list[Any]:
        """The same as `transform`."""
        return self.fit(meshes, y).transform(meshes)

    def __sklearn_tags__(self) -> Any:
        """What scikit-learn asks of a step; it is there when it does."""
        from sklearn.utils import Tags, TargetTags, TransformerTags

        return Tags(
            estimator_type="transformer",
            target_tags=TargetTags(required=False),
            transformer_tags=TransformerTags(preserves_dtype=[]),
            requires_fit=False,
            no_validation=True,
        )
