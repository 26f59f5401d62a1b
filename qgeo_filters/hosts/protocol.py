"""What a library's meshes need to be taken and given back, and the register of all libraries that are known.

A host is one file with three functions, and a fourth for tests; `register_host` makes it known. The package's own
hosts come in by the same door, in ``hosts/__init__.py``.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.io.raw_mesh import RawMesh


class Host(Protocol):
    """How the meshes of one library become arrays, and come back in kind: a module or an object with these functions.

    A host may also have ``make(surface)``, a mesh of the library with the vertices, faces and attributes of a
    `Surface`; `testing.check_filter` then tries every filter on it. And ``lines(curves)``, the library's lines through
    the points of each curve, a list of arrays (k, 3): what `polylines` gives. And ``layers(mesh)``, the meshes that an
    object holds of which ``read`` takes one: each is a pose where poses are asked for.

    Examples
    --------
    >>> from qgeo_filters.hosts import trimesh
    >>> [hasattr(trimesh, name) for name in ("read", "write", "with_positions", "make")]
    [True, True, True, True]
    """

    def read(self, mesh: Any, repair: bool, /) -> RawMesh:
        """Arrays of a mesh, not checked, with its per-vertex attributes.

        Raises `MeshError` for what is no triangle mesh; with ``repair`` polygons are split (and noted).
        """

    def write(self, mesh: Any, attributes: Mapping[str, np.ndarray], /) -> Any:
        """Copy of the mesh, with all that it holds, and the attributes, of one row per vertex, added or replaced."""

    def with_positions(self, mesh: Any, vertices: FloatArray, /) -> Any:
        """Copy of the mesh with its vertices elsewhere; normals that it holds are computed anew."""


_REQUIRED = ("read", "write", "with_positions")
REGISTER: dict[str, Host | str] = {}


def register_host(module_root: str, host: Host | str) -> None:
    """Make meshes of a library known to `as_surface`, filters, functions, widgets and `testing.check_filter`.

    Parameters
    ----------
    module_root : str
        First part of the module in which the library's classes (or one of their base classes) are defined:
        ``"trimesh"`` for ``trimesh.base.Trimesh``. A host registered before under this name is replaced.
    host : module or object with ``read``, ``write`` and ``with_positions``, or str
        See `hosts.protocol.Host`. As a string, the name of the module that has the functions: it is imported
        when the first of the library's objects is met.

    Raises
    ------
    ParameterError
        A name with dots, or a host without the functions.

    Examples
    --------
    >>> qg.register_host("mymeshes", "my_package.qgeo_host")  # imported when such a mesh is met
    >>> qg.register_host("my.meshes", "my_package.qgeo_host")
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.ParameterError: module_root must be the first part of a module's name, got 'my.meshes'
    >>> from qgeo_filters.hosts.protocol import REGISTER
    >>> _ = REGISTER.pop("mymeshes")  # as it was
    """
    if not isinstance(module_root, str) or not module_root.isidentifier():
        raise ParameterError(f"module_root must be the first part of a module's name, got {module_root!r}")
    REGISTER[module_root] = host if isinstance(host, str) else _complete(module_root, host)


def registered_hosts() -> tuple[str, ...]:
    """Roots of the modules of all known libraries, in the order in which they were registered."""
    return tuple(REGISTER)


def load_host(module_root: str) -> Host:
    """Host of a known library, its module imported now if it was not."""
    host = REGISTER[module_root]
    if isinstance(host, str):
        host = _complete(module_root, importlib.import_module(host))
        REGISTER[module_root] = host
    return host


def host_of(obj: object) -> Host | None:
    """Host of the library that an object's class, or one of its base classes, comes from; None for all others."""
    for cls in type(obj).__mro__:
        root = cls.__module__.partition(".")[0]
        if root in REGISTER:
            return load_host(root)
    return None


def _complete(module_root: str, host: Any) -> Host:
    lacking = [name for name in _REQUIRED if not callable(getattr(host, name, None))]
    if lacking:
        raise ParameterError(f"the host of {module_root!r} has no function {', '.join(lacking)}")
    complete: Host = host
    return complete
