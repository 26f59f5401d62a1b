"""Filter and Pipeline: objects that take a mesh of any host and return the same kind with more attributes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import RepairOption
from qgeo_filters.atomic import atomic_write
from qgeo_filters.caching import cache
from qgeo_filters.errors import MeshError, ParameterError, reason
from qgeo_filters.filters import yaml_text
from qgeo_filters.filters.changes import Changes
from qgeo_filters.filters.composition import Composition, single_steps
from qgeo_filters.filters.estimator import Estimator
from qgeo_filters.filters.registry import filter_by_name
from qgeo_filters.filters.repaired import (
    carried_back,
    least_repair,
    parameters_on,
    repaired_values,
    repaired_vertices,
)
from qgeo_filters.hosts.dispatch import as_surface, is_host_mesh, repaired_by, write_back
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.parallel import default_workers
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_repair


class Filter(Estimator):
    """One step from a mesh to the same mesh with more named per-vertex attributes.

    A filter that moves vertices overrides `apply` and returns the surface elsewhere.

    A subclass takes keyword arguments only, each with a default, stores each unchanged under its own name and does
    nothing else in its constructor (scikit-learn's convention), lists in `outputs` the attributes that it adds, and
    implements `compute`. Results that are not per vertex are left on the filter, under a name that ends
    in an underscore, until the next call.

    Examples
    --------
    >>> class EdgeLength(qg.Filter):
    ...     outputs = {"edge_length": "(n,), length: mean of the edges around the vertex"}
    ...
    ...     def compute(self, surface, progress=False):
    ...         total, count = np.zeros(surface.n_vertices), np.zeros(surface.n_vertices)
    ...         for end in surface.edges.T:
    ...             np.add.at(total, end, surface.edge_lengths)
    ...             np.add.at(count, end, 1)
    ...         return {"edge_length": total / count}
    >>> EdgeLength()(qg.testing.sample_surface()).attributes["edge_length"].shape
    (162,)
    """

    outputs: ClassVar[Mapping[str, str]] = {}
    """Attributes that the filter adds: name -> shape, unit and meaning. Reading it costs nothing and never fails."""

    index_outputs: ClassVar[frozenset[str]] = frozenset()
    """Those of `outputs` whose values are vertex indices of the same mesh."""

    index_parameters: ClassVar[frozenset[str]] = frozenset()
    """Those constructor arguments that are vertices of the mesh, one or several."""

    value_parameters: ClassVar[frozenset[str]] = frozenset()
    """Those constructor arguments that may be values of the mesh's vertices, shape (n, ...)."""

    pointwise: ClassVar[bool] = False
    """Whether what a vertex gets does not depend on its neighbours, so that a mesh need not be welded."""

    repair_: Repair | None = None
    """What the last call repaired, None if it worked on the mesh as it was."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "renamed" in vars(cls):
            setattr(cls, "__init__", renamed_parameters(**cls.renamed)(cls.__init__))  # noqa: B010, mypy

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """A filter of this kind, alone or after others, that can be applied to the surface: what tests try."""
        return cls()

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Attributes of the surface, by name; what a subclass implements."""
        raise NotImplementedError(f"{type(self).__name__} must implement compute")

    def apply(self, surface: Surface, progress: bool = False) -> Surface:
        """Surface with the filter's attributes added."""
        return surface.with_attributes(self.compute(surface, progress))

    def __call__(
        self, mesh: Any, *, repair: RepairOption = "auto", progress: bool = False, workers: int | None = None
    ) -> Any:
        """Mesh of the same kind with the filter's attributes; the input is not changed.

        Parameters
        ----------
        mesh : mesh object, (V, F) or path
            Whatever `as_surface` takes: a mesh of Open3D, PyMeshLab, PyVista, vedo, trimesh or meshio, a `Surface`. A
            legacy Open3D mesh comes back as the tensor kind, a ``(V, F)`` pair and a path as a `Surface`.
        repair : bool, "auto", "force" or "wrap"
            With "auto", work on a repaired copy where the mesh is not welded or the filter refuses it as it is; pieces
            are removed only where the filter needs one piece, and up to a tenth of the area. With True, in any case
            and in one piece; where more than a hundredth of the area would have to go, only with "force". Attributes
            are carried back to the vertices of the input (NaN, or -1 for indices, where a vertex had to go);
            ``repair_`` says what was changed. With "wrap", on a closed surface around it, see `wrap_surface`. Where not
            even a `Surface` can hold the input (a pair or file with indices out of range, say), a `Surface` of the same
            vertices is returned without the faces that it cannot hold.
        progress : bool
            Show progress bars.
        workers : int, optional
            Number of threads, at least 1; by default all cores that this process may use. Results do not depend on it.

        Raises
        ------
        MeshError
            For a mesh that the filter cannot take; the message names what is wrong, where and how often.
        """
        for step in (self, *single_steps(self)):
            step.repair_ = None
        with cache.held(), default_workers(workers):
            if not checked_repair(repair):
                surface = as_surface(mesh)
                return Changes.between(surface, self.apply(surface, progress)).made_on(mesh, surface)
            if repair == "auto":
                back = self._mended(mesh, progress)
                if self.repair_ is None:
                    return back.made_on(mesh, as_surface(mesh))
            else:
                back = self._on(repaired_by(mesh, repair), progress)
            assert self.repair_ is not None
        return self._written(mesh, self.repair_.given, back)

    def _mended(self, mesh: Any, progress: bool) -> Changes:
        """What the filter does to a mesh as it is, or, where it cannot take it, to a repaired copy."""
        refusal = None
        try:
            surface = as_surface(mesh)
            if self.pointwise or not surface.unwelded_vertices.size:
                return Changes.between(surface, self.apply(surface, progress))
        except MeshError as error:
            refusal = error
        return least_repair(mesh, lambda repair: self._on(repair, progress), refusal)

    def _on(self, repair: Repair, progress: bool) -> Changes:
        """What the filter does to the repaired mesh, on the original vertices; one that is gone stays where it is."""
        self.repair_ = repair
        with parameters_on(repair, single_steps(self)):
            made = Changes.between(repair.surface, self.apply(repair.surface, progress))
        added = self.on_given(repair, made.added)
        return Changes(added, None if made.shift is None else np.nan_to_num(repair.map_back(made.shift)))

    def repaired_parameters(self, repair: Repair) -> dict[str, Any]:
        """Constructor arguments for the repaired mesh, of those that hold vertices of the mesh or values there."""
        vertices = {name: repaired_vertices(repair, name, getattr(self, name)) for name in self.index_parameters}
        return vertices | {name: repaired_values(repair, getattr(self, name)) for name in self.value_parameters}

    def on_given(self, repair: Repair, added: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Attributes at the original vertices, from those that were added at the repaired ones.

        A subclass that knows them better than what a wrap, with its fewer vertices, says overrides this.
        """
        return {name: carried_back(repair, values, name in self.index_outputs) for name, values in added.items()}

    def _written(self, mesh: Any, given: Surface, back: Changes) -> Any:
        """The mesh after the changes; where no `Surface` can hold it, what can be held."""
        try:
            return back.made_on(mesh, as_surface(mesh))
        except MeshError:
            if is_host_mesh(mesh) and back.shift is None:
                return write_back(mesh, None, back.added)
            return back.made_on(given, given)

    # -- composition --------------------------------------------------------------------------------

    def __or__(self, other: Filter) -> Pipeline:
        if not isinstance(other, Filter):
            return NotImplemented
        return Pipeline([*single_steps(self), *single_steps(other)])


class Pipeline(Composition[Filter], Filter):
    """Filters applied one after the other, each seeing the attributes of those before it.

    Parameters
    ----------
    steps : sequence of Filter
        Also made by ``a | b | c``; a step may be a pipeline. ``pipeline[i]`` and ``pipeline["ClassName"]`` give a
        step, which holds the results that are not per vertex.

    Notes
    -----
    The mesh is converted once at either end, and an expensive stage (scalar, distances, spectrum) that
    several steps need is computed once. As in scikit-learn, ``pipeline.set_params(Paint__colormap="magma")`` reaches
    into the steps; filters and pipelines are steps of its own pipelines, with lists of meshes for X.

    Examples
    --------
    >>> pipe = qg.DifferentialCoordinates() | qg.SurfaceScalar(clip=None)
    >>> out = pipe(qg.testing.sample_surface())
    >>> sorted(out.attributes)
    ['qgeo_delta', 'qgeo_scalar']
    >>> pipe["SurfaceScalar"].clip is None, len(pipe.steps)
    (True, 2)
    >>> print(pipe)
    DifferentialCoordinates(weights='uniform') | SurfaceScalar(scalar='mean_curvature', clip=None, smoothing=0.0)
    """

    @property
    def outputs(self) -> Mapping[str, str]:  # type: ignore[override]
        """Attributes that all steps add."""
        return {name: text for step in self.steps for name, text in step.outputs.items()}

    @property
    def index_outputs(self) -> frozenset[str]:  # type: ignore[override]
        """Those attributes that hold vertex indices."""
        return frozenset().union(*(step.index_outputs for step in self.steps))

    @property
    def pointwise(self) -> bool:  # type: ignore[override]
        """Whether no step looks at neighbours."""
        return all(step.pointwise for step in self.steps)

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Attributes that all steps add or replace."""
        after = self.apply(surface, progress)
        return {name: after.attributes[name] for name in after.attributes if name in self.outputs}

    def apply(self, surface: Surface, progress: bool = False) -> Surface:
        """Surface after the last step."""
        for step in self.steps:
            surface = step.apply(surface, progress)
        return surface

    def on_given(self, repair: Repair, added: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Attributes at the original vertices, each by the last step that adds it."""
        found = super().on_given(repair, {name: added[name] for name in added if name not in self.outputs})
        for step in self.steps:
            found |= step.on_given(repair, {name: added[name] for name in added if name in step.outputs})
        return found

    def __repr__(self) -> str:
        return " | ".join(map(repr, self.steps)) if len(self.steps) > 1 else f"Pipeline({list(self.steps)!r})"

    # -- YAML ---------------------------------------------------------------------------------------

    def to_yaml(self) -> str:
        """The pipeline as YAML text; pipelines within it are written as their steps.

        Raises
        ------
        ParameterError
            For a parameter that text cannot hold (an array, a function, a mesh): its name is given.
        """
        return yaml_text.to_yaml((type(step).__name__, step.get_params()) for step in self.single_steps)

    @classmethod
    def from_yaml(cls, text: str) -> Pipeline:
        """Pipeline from YAML text: ``qgeo_pipeline: 1`` and ``steps``, a list of ``FilterName: {parameter: value}``.

        Raises
        ------
        ParameterError
            For text that is not YAML or no pipeline, an unknown filter or an unknown parameter.
        """
        steps = []
        for position, (name, parameters) in enumerate(yaml_text.from_yaml(text)):
            try:
                steps.append(filter_by_name(name, parameters))
            except ParameterError as error:
                raise ParameterError(f"steps[{position}]: {error}") from error
        return cls(steps)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as YAML, atomically."""
        with atomic_write(path) as file:
            file.write(self.to_yaml().encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Pipeline:
        """Pipeline from a YAML file, see `from_yaml`; the message of an error starts with the path."""
        try:
            return cls.from_yaml(Path(path).read_text(encoding="utf-8-sig"))
        except (ParameterError, UnicodeDecodeError) as error:
            raise ParameterError(f"{os.fspath(path)}: {reason(error)}") from error
