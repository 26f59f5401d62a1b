"""``qgeo info --system``: what a report of a bug should say of the machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import sys

from qgeo_filters import __version__
from qgeo_filters.cli.kept import kept_folder
from qgeo_filters.memory import available_memory
from qgeo_filters.parallel import worker_count

_DISTRIBUTION = "qgeo-filters"
# What bounds or binds threads, and where kernels and meshes are kept.
_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "NUMBA_CACHE_DIR",
    "QGEO_CACHE_DIR",
)


def system_information() -> str:
    """Versions of Python, of this package and of all that it may use, cores, free memory: a line each."""
    free = available_memory()
    lines = [
        f"qgeo-filters: {__version__}",
        f"python: {sys.version.split()[0]} ({platform.python_implementation()})",
        f"platform: {platform.platform()}, {platform.machine()}",
        f"cores: {worker_count()}",
        f"free memory: {'not known' if free is None else f'{free / 1e9:.1f} GB'}",
        f"results kept in: {kept_folder() or 'nothing'}",
        *(f"{name}: {os.environ[name]}" for name in _VARIABLES if name in os.environ),
        *(f"{name}: {_version(name) or 'not installed'}" for name in dependencies()),
    ]
    return "\n".join(lines)


def dependencies() -> list[str]:
    """Names of the packages that this one may use: those it needs, and those of its extras, but for the tests'."""
    found: dict[str, None] = {}
    for requirement in importlib.metadata.requires(_DISTRIBUTION) or ():
        extras = set(re.findall(r"extra == ['\"]([\w-]+)['\"]", requirement))
        name = re.match(r"[\w.-]+", requirement)
        if name and name[0] != _DISTRIBUTION and not extras & {"test", "all"}:
            found.setdefault(name[0])
    return list(found)


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None
