"""What the gallery shows of an example: each matplotlib figure that a cell ends with."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

RESOLUTION = 110  # dots per inch


def figure_scraper(block: tuple, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Text of the pictures of one cell, written where Sphinx-Gallery wants them.

    The functions of `qgeo_filters.report` make figures without pyplot, which has a list of its own; a cell that shows
    one ends with it, as in a notebook.
    """
    shown = block_vars["example_globals"].get("___")  # where Sphinx-Gallery keeps the last value that a cell ended with
    if not isinstance(shown, Figure) or shown is block_vars.get("shown"):
        return ""
    block_vars["shown"] = shown
    path = next(block_vars["image_path_iterator"])
    shown.savefig(path, format="png", dpi=RESOLUTION, bbox_inches="tight")
    return figure_rst([path], gallery_conf["src_dir"])
