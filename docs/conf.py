"""How Sphinx builds the pages in this folder: ``make docs``. Nothing is asked of the network."""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "docs"), str(ROOT), str(ROOT / "widgets")]
os.environ.setdefault("OPEN3D_DISABLE_WEB_VISUALIZER", "true")

from house_picture import write_house_picture  # noqa: E402
from repository_text import requested, with_repository_text  # noqa: E402

import qgeo_filters  # noqa: E402

SOURCE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]["Source"]

project = "qgeo-filters"
author = "The qgeo-filters developers"
version = release = qgeo_filters.__version__
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx-mathjax-offline",
    "numpydoc",
    "myst_parser",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "examples", "**/*.ipynb", "**/*.py", "**/*.zip"]
templates_path = ["_templates"]
default_role = "py:obj"  # a name in single backticks is a link where there is such a name

# Signatures without types: each docstring has them, with shapes and units.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = True
autosummary_imported_members = False
numpydoc_show_class_members = False  # the template lists them, each with its text
numpydoc_class_members_toctree = False

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence"]
myst_heading_anchors = 4
myst_dmath_double_inline = True

html_theme = "pydata_sphinx_theme"
html_title = f"qgeo-filters {release}"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_theme_options = {
    "icon_links": [{"name": "Source", "url": SOURCE, "icon": "fa-brands fa-github"}],
    "show_prev_next": False,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
    "search_as_you_type": True,
}
html_sidebars = {page.stem: [] for page in (ROOT / "docs").glob("*.md")}  # sections are those of gallery and reference
html_show_sourcelink = False
copyright = "the qgeo-filters developers, MIT licence"

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "image_scrapers": ("gallery_pictures.figure_scraper",),
    "capture_repr": ("_repr_html_", "__repr__"),
    "ignore_repr_types": r"matplotlib\.",
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "write_computation_times": False,
    "download_all_examples": False,
    "show_signature": False,
    "plot_gallery": "True",
    "doc_module": ("qgeo_filters", "qgeo_widgets"),
    "backreferences_dir": None,
    "reset_modules": ("matplotlib", "gallery_seconds.watch"),
    "reset_modules_order": "both",
}


def _taken_in(app, name, source) -> None:  # type: ignore[no-untyped-def]
    """A page with what it asks for, and made anew when one of those files changes."""
    for file in requested(source[0]):
        app.env.note_dependency(str(ROOT / file), docname=name)
    source[0] = with_repository_text(source[0], SOURCE)


def setup(app) -> None:  # type: ignore[no-untyped-def]
    """Texts of the repository come in where a page asks for them, and the house is drawn."""
    app.connect("source-read", _taken_in)
    app.connect("builder-inited", lambda app: write_house_picture(Path(app.srcdir) / "generated" / "house.svg"))
