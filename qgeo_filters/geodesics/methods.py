"""The table of methods for geodesic distances: every argument ``method`` takes a name from it."""

from __future__ import annotations

from collections.abc import Callable

from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.dgg.graph import graph_of
from qgeo_filters.geodesics.dijkstra import EdgeDistances
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.geodesics.mmp.exact import WindowPropagation

#: From a metric, a bound on the relative error and a number of threads to a solver that keeps what it prepares.
Method = Callable[[LiftedMetric, float, int | None], DistanceSolver]

#: Methods by name, the default first.
METHODS: dict[str, Method] = {
    "graph": graph_of,  # shortest paths in the discrete geodesic graph: near-exact and by far the fastest
    "exact": WindowPropagation.of,  # Mitchell, Mount and Papadimitriou
    "edges": EdgeDistances.of,  # Dijkstra: for comparison, several per cent too long
}


def register_method(name: str, method: Method) -> None:
    """Make a method of one's own known by a name, to all functions, filters and commands of this process.

    Parameters
    ----------
    name : str
        Not taken yet.
    method : callable
        ``(metric, accuracy, workers)`` to a `DistanceSolver`. Methods whose error has another bound, or none, ignore
        the accuracy.

    Raises
    ------
    ParameterError
        The name is taken.

    Examples
    --------
    >>> from qgeo_filters.geodesics.methods import METHODS
    >>> qg.register_method("mine", METHODS["edges"])
    >>> surface = qg.testing.sample_surface()
    >>> qg.distances(surface, 0, method="mine").shape
    (1, 162)
    >>> _ = METHODS.pop("mine")
    """
    if name in METHODS:
        raise ParameterError(f"there is a method {name!r} already; choose another name")
    METHODS[name] = method


def method_named(name: str) -> Method:
    """The method of this name, or `ParameterError` that lists all."""
    if not isinstance(name, str) or name not in METHODS:
        raise ParameterError(f"method must be one of {', '.join(map(repr, METHODS))}, got {name!r}")
    return METHODS[name]
