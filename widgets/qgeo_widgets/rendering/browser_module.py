"""The browser module that draws, and its style: built from ``widgets/renderer`` and shipped in ``static``."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

#: What a page or a notebook calls of it.
NAME = "qgeoRenderer"


@cache
def script() -> str:
    """Text of the module, which sets ``qgeoRenderer``."""
    return _static("renderer.js")


@cache
def style() -> str:
    """Text of its style sheet."""
    return _static("renderer.css")


@cache
def licence() -> str:
    """Licence of three.js, which the module holds."""
    return _static("three.LICENSE")


@cache
def matrix_module() -> str:
    """Text of the module that draws matrices, as anywidget takes it."""
    return _static("matrix.js")


@cache
def as_anywidget() -> str:
    """The same as anywidget takes it: a module whose default has ``render``."""
    return f"{script()}\nexport default {{render: {NAME}.render}};\n"


def _static(name: str) -> str:
    return (files("qgeo_widgets") / "static" / name).read_text(encoding="utf-8")
