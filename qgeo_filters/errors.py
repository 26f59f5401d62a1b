"""Exceptions that the package raises on purpose, each with one clear sentence."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

_LONGEST = 600  # characters of a reason


class QgeoError(Exception):
    """Whatever the caller can mend: a mesh, a parameter or a package that is missing; all others are bugs.

    Examples
    --------
    >>> try:
    ...     qg.distances(qg.testing.sample_surface(), 1000)
    ... except qg.QgeoError as error:
    ...     print(error)
    sources[0] is vertex 1000, but there are 162 vertices, numbered from 0 (1 such index)
    """


class ParameterError(QgeoError, ValueError):
    """An argument that is out of range, of a wrong shape or at odds with another: the message says which.

    Examples
    --------
    >>> qg.distance_spectrum(qg.testing.sample_surface(), k=0)
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.ParameterError: k must be between 1 and the number of vertices, 162, got 0
    """


class MeshError(QgeoError, ValueError):
    """A mesh that cannot be used: the message names what is wrong, where and how often.

    Examples
    --------
    >>> qg.as_surface(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]))
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.MeshError: faces[0] refers to vertex 3, but there are 3 vertices, numbered from 0 (1 ...
    """


class NonManifoldError(MeshError):
    """A mesh whose edges or vertices are not those of a surface.

    Examples
    --------
    >>> fan = qg.Surface([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    >>> qg.distances(fan, 0)
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.NonManifoldError: the geodesic distance needs a manifold mesh, but edge (0, 1) has 3 ...
    """


class DisconnectedError(MeshError):
    """A mesh in several pieces where one piece is needed.

    Examples
    --------
    >>> apart = qg.Surface([[x, y, 0] for x in (0, 5) for y in (0, 1)] + [[1, 0, 0], [6, 0, 0]], [[0, 4, 1], [2, 5, 3]])
    >>> qg.laplacian_spectrum(apart, 2, repair=False)
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.DisconnectedError: the spectrum of the Laplacian needs a mesh in one piece, but there ...
    """


class TooLargeError(QgeoError, MemoryError):
    """A result that does not fit into memory, said before it is begun: how large it is, and what takes less.

    Examples
    --------
    >>> issubclass(qg.TooLargeError, qg.QgeoError)
    True
    """


class WorkersLostError(QgeoError, RuntimeError):
    """Worker processes or a cluster that went away in the middle of their work; what was finished is kept.

    Examples
    --------
    >>> issubclass(qg.WorkersLostError, (qg.QgeoError, RuntimeError))
    True
    """


class MissingPackageError(QgeoError, ImportError):
    """An optional package that is not installed: the message holds the ``pip install`` that brings it.

    Examples
    --------
    >>> from qgeo_filters.errors import require_package
    >>> require_package("no_such_package", "meshlab", "a PyMeshLab mesh")
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.MissingPackageError: a PyMeshLab mesh needs no_such_package, which is not installed: ...
    """


@contextmanager
def concerning(name: str) -> Iterator[None]:
    """Context in which the message of a `QgeoError` begins with what it is about: which of several shapes, say."""
    try:
        yield
    except QgeoError as error:
        raise type(error)(f"{name}: {error}") from error


@contextmanager
def of_file(name: str) -> Iterator[None]:
    """Context in which an error of the system that names no file names this one."""
    try:
        yield
    except OSError as error:
        if error.errno is not None and error.filename is None:
            error.filename = name
        raise


def reason(error: BaseException) -> str:
    """What an exception says, in one line; its type where it says nothing (`MemoryError`, `EOFError`).

    Where it quotes a file at length the middle is left out.
    """
    line = one_line(str(error)) or type(error).__name__
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def one_line(text: str) -> str:
    """The text with its lines joined; spaces within a line stay, as they may be those of a file's name."""
    return " ".join(stripped for line in text.splitlines() if (stripped := line.strip()))


def require_package(module: str, extra: str, purpose: str) -> ModuleType:
    """Imported optional module.

    Parameters
    ----------
    module : str
        Name as in an import statement.
    extra : str
        The extra of this package that brings it.
    purpose : str
        What needs it, the subject of the error's sentence.

    Raises
    ------
    MissingPackageError
        If it is not installed, or installed and broken (then the system's own message is quoted).
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"{purpose} needs {module}, which is not installed: pip install 'qgeo-filters[{extra}]'"
        ) from error
    except ImportError as error:
        raise MissingPackageError(
            f"{purpose} needs {module}, which is installed but does not load: {reason(error)}"
        ) from error
