"""Which of the backends draws: our own browser module, or pythreejs."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MissingPackageError, ParameterError
from qgeo_widgets.rendering.matrix_pane import MatrixPane
from qgeo_widgets.rendering.viewer import Viewer

Backend = Literal["webgl", "pythreejs"]

#: Package, and module and class of viewer and matrix.
_BACKENDS: dict[str, tuple[str, tuple[str, str], tuple[str, str]]] = {
    "webgl": ("anywidget", ("webgl_viewer", "WebglViewer"), ("webgl_matrix", "WebglMatrix")),
    "pythreejs": ("pythreejs", ("pythreejs_viewer", "PythreejsViewer"), ("pythreejs_matrix", "PythreejsMatrix")),
}
_chosen: list[str] = ["webgl"]


def choose_backend(name: Backend | None = None) -> str:
    """Choose a backend, and say which is chosen; see `qgeo_widgets.backend`."""
    if name is not None:
        if name not in _BACKENDS:
            raise ParameterError(f"there is no backend {name!r}; choose one of: {', '.join(_BACKENDS)}")
        _of(name, 1)
        _chosen[0] = name
    return _chosen[0]


def most_shapes() -> int:
    """How many shapes a viewer of the chosen backend can show."""
    return int(_of(_chosen[0], 1).MOST_SHAPES)


def new_viewer(*args: Any, **kwargs: Any) -> Viewer:
    """A `Viewer` of the chosen backend."""
    viewer: Viewer = _of(_chosen[0], 1)(*args, **kwargs)
    return viewer


def new_matrix_pane(image: npt.NDArray[np.uint8], size: int) -> MatrixPane:
    """A `MatrixPane` of the chosen backend."""
    pane: MatrixPane = _of(_chosen[0], 2)(image, size)
    return pane


def _of(name: str, part: Literal[1, 2]) -> Any:
    """Class of a backend."""
    backend_of = _BACKENDS[name]
    try:
        import_module(backend_of[0])
    except ImportError as error:
        raise MissingPackageError(
            f'the backend {name!r} needs {backend_of[0]}: pip install "qgeo-filters[jupyter]"'
        ) from error
    module, kind = backend_of[part]
    return getattr(import_module(f"qgeo_widgets.rendering.{module}"), kind)
