"""Conformance suite that every filter passes, for the package's own filters and for anyone who writes one.

>>> qg.testing.check_filter(MyFilter(k=3))  # doctest: +SKIP
"""

from __future__ import annotations

import importlib.util
import inspect
import pickle
from typing import Any
from unittest.mock import patch

import numpy as np

from qgeo_filters.caching import cache
from qgeo_filters.errors import ParameterError, QgeoError
from qgeo_filters.filters.base import Filter, Pipeline
from qgeo_filters.filters.registry import REGISTRY
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.hosts.protocol import load_host, registered_hosts
from qgeo_filters.surface import Surface


def sample_surface() -> Surface:
    """A closed, lopsided surface of 162 vertices without any symmetry, for tests.

    Examples
    --------
    >>> qg.testing.sample_surface()
    Surface(162 vertices, 320 faces)
    """
    golden = (1 + 5**0.5) / 2
    corners = [[s * 1.0, t * golden, 0.0] for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(corner, shift) for shift in range(3) for corner in corners])
    gaps = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    close = np.abs(gaps - 2) < 1e-9
    faces = [
        [i, j, k] for i in range(12) for j in range(i) for k in range(j) if close[i, j] and close[j, k] and close[k, i]
    ]
    for _ in range(2):
        vertices, faces = _refined(vertices, faces)
    triangles = np.array(faces)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    x, y, z = (vertices / np.linalg.norm(vertices, axis=1, keepdims=True)).T
    radius = 1 + 0.25 * x + 0.2 * x * y - 0.15 * z**3 + 0.3 * y**2 * z
    return Surface(np.column_stack([1.4 * x, y, 0.8 * z]) * radius[:, None], triangles)


def _refined(vertices: np.ndarray, faces: Any) -> tuple[np.ndarray, list[list[int]]]:
    surface = Surface(vertices, faces)
    middle = surface.face_edges + surface.n_vertices
    split = [np.column_stack([surface.faces[:, k], middle[:, k], middle[:, (k + 2) % 3]]) for k in range(3)]
    points = np.concatenate([vertices, vertices[surface.edges].mean(axis=1)])
    radius = np.linalg.norm(vertices[0])
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.concatenate([*split, middle]).tolist()


def check_filter(filter: Filter, surface: Surface | None = None) -> None:
    """Nothing, if the filter keeps the contract of `Filter`; AssertionError with a sentence otherwise.

    Parameters
    ----------
    filter : Filter
    surface : Surface, optional
        A mesh that the filter can take; `sample_surface` by default.

    Notes
    -----
    Checked: the constructor takes keywords only, each with a default, and only stores; ``repr``, ``get_params``,
    ``set_params`` and ``clone`` agree; calling changes neither the filter's parameters nor its input (read-only
    arrays are given); the same input gives the same output bit for bit; exactly the attributes of `outputs` are
    added, one row per vertex, finite or ``inf``; composition, pickling and YAML keep the filter; every installed
    host gets its own kind back with the same values; a mesh that is no surface is either taken or refused with a
    `QgeoError`.

    Examples
    --------
    >>> qg.testing.check_filter(qg.DifferentialCoordinates())
    """
    surface = surface or sample_surface()
    for check in (_parameters, _purity, _declared_outputs, _composition, _serialisation, _hosts, _refusal):
        check(filter.clone(), surface)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    return a is b or a == b


def _require(condition: object, message: str) -> None:
    """Nothing, or AssertionError; an ``assert`` would be skipped by ``python -O``."""
    if not condition:
        raise AssertionError(message)


def _parameters(filter: Filter, surface: Surface) -> None:
    kind = type(filter).__name__
    params = filter.get_params()
    for position, (name, parameter) in enumerate(inspect.signature(type(filter)).parameters.items()):
        _require(parameter.default is not inspect.Parameter.empty, f"{kind}: parameter {name} has no default")
        _require(
            parameter.kind is inspect.Parameter.KEYWORD_ONLY or position == 0 or isinstance(filter, Pipeline),
            f"{kind}: parameter {name} can be given by position; put * behind the first, which says what it is about",
        )
    extra = set(vars(filter)) - set(params)
    _require(not extra, f"{kind}: the constructor sets more than its parameters: {sorted(extra)}")
    copy = filter.clone()
    _require(copy is not filter, f"{kind}: clone returns the filter itself")
    for name, value in params.items():
        same = _same(copy.get_params()[name], value) or isinstance(filter, Pipeline)
        _require(same, f"{kind}: clone changes {name}")
    _require(filter.set_params(**params) is filter, f"{kind}: set_params must return the filter")
    try:
        filter.set_params(surely_no_parameter=1)
    except ParameterError as error:
        _require("surely_no_parameter" in str(error), f"{kind}: the error must name the unknown parameter")
    else:
        raise AssertionError(f"{kind}: set_params takes an unknown name")
    _require(
        repr(filter).startswith((kind, "Pipeline")) or kind == "Pipeline", f"{kind}: repr must begin with the name"
    )
    for name in params if kind != "Pipeline" else ():
        _require(f"{name}=" in repr(filter), f"{kind}: repr does not show {name}")


def _purity(filter: Filter, surface: Surface) -> None:
    kind = type(filter).__name__
    params = dict(filter.get_params())
    vertices, faces = surface.vertices.copy(), surface.faces.copy()
    before = {name: values.copy() for name, values in surface.attributes.items()}
    first = filter.apply(surface)
    with patch.object(cache, "get", lambda key, compute: compute()):  # the second result is not the first, kept
        second = filter.clone().apply(Surface(vertices, faces, before))
    _require(np.array_equal(surface.vertices, vertices), f"{kind}: the input's vertices were changed")
    _require(np.array_equal(surface.faces, faces), f"{kind}: the input's faces were changed")
    _require(set(surface.attributes) == set(before), f"{kind}: attributes were added to the input itself")
    for name, values in first.attributes.items():
        _require(
            np.array_equal(values, second.attributes[name], equal_nan=values.dtype.kind == "f"),
            f"{kind}: two calls disagree on {name}",
        )
    for name, value in filter.get_params().items():
        _require(value is params[name], f"{kind}: the call changed the parameter {name}")


def _declared_outputs(filter: Filter, surface: Surface) -> None:
    kind = type(filter).__name__
    early = set(filter.outputs)
    result = filter.compute(surface)
    _require(early <= set(filter.outputs), f"{kind}: outputs forgets {early - set(filter.outputs)} after the call")
    _require(set(result) == set(filter.outputs), f"{kind}: outputs declares {set(filter.outputs)}, made {set(result)}")
    for name, values in result.items():
        _require(len(values) == surface.n_vertices, f"{kind}: {name} has {len(values)} rows")
        announced = "NaN" in filter.outputs[name]
        holds = bool(np.isnan(np.asarray(values, dtype=float)).any())
        _require(announced or not holds, f"{kind}: {name} holds NaN, of which outputs says nothing")
    _require(filter.index_outputs <= set(filter.outputs), f"{kind}: index_outputs names what outputs does not")


def _composition(filter: Filter, surface: Surface) -> None:
    from qgeo_filters.filters.differential import DifferentialCoordinates

    pipeline = filter | DifferentialCoordinates()
    _require(isinstance(pipeline, Pipeline), f"{type(filter).__name__}: | must give a Pipeline")
    together = pipeline.apply(surface).attributes
    for name in [*filter.outputs, "qgeo_delta"]:
        _require(name in together, f"{type(filter).__name__}: {name} is lost in a pipeline")


def _serialisation(filter: Filter, surface: Surface) -> None:
    kind = type(filter).__name__
    _require(repr(pickle.loads(pickle.dumps(filter))) == repr(filter), f"{kind}: pickling changes the filter")
    pipeline = filter if isinstance(filter, Pipeline) else Pipeline([filter])
    if any(type(step).__name__ not in REGISTRY for step in pipeline.steps):
        return  # not `registered`: saved pipelines do not know it
    try:
        text = pipeline.to_yaml()
    except ParameterError:
        return  # a parameter that text cannot hold, said in one sentence
    _require(Pipeline.from_yaml(text).to_yaml() == text, f"{kind}: YAML changes the filter")


def _hosts(filter: Filter, surface: Surface) -> None:
    kind = type(filter).__name__
    expected = filter.apply(surface).attributes
    for module in registered_hosts():
        if importlib.util.find_spec(module) is None:
            continue
        make = getattr(load_host(module), "make", None)
        if make is None:
            continue
        mesh = make(surface)
        result = filter(mesh)
        _require(type(result) is type(mesh), f"{kind}: {module} gave {type(mesh)} and got {type(result)}")
        found = as_surface(result).attributes
        for name in filter.outputs:
            _require(name in found, f"{kind}: {name} does not reach {module}")
            # Hosts hold coordinates in single or double precision, and colours in eight bits a channel.
            a, b = np.asarray(found[name], float), np.asarray(expected[name], float)
            finite = np.isfinite(b)
            scale = np.abs(b[finite]).max(initial=1e-300)
            _require(
                np.allclose(a.reshape(b.shape)[finite], b[finite], atol=2.5e-3 * scale),
                f"{kind}: {name} differs in {module}",
            )


def _refusal(filter: Filter, surface: Surface) -> None:
    fan = Surface([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    try:
        filter(fan)
    except QgeoError as error:
        _require(str(error), f"{type(filter).__name__}: refuses without a sentence")
    except Exception as error:
        kind = type(filter).__name__
        raise AssertionError(f"{kind}: refuses a mesh with {type(error).__name__}, no QgeoError") from error
