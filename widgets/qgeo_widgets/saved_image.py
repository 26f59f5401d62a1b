"""The picture that a notebook keeps of a widget, for where it is read without a kernel; unseen beside the widget."""

from __future__ import annotations

from IPython.display import display

from qgeo_widgets.offscreen import data_url

LIVE = "qgeo-live-"


def display_with_image(widget_bundle: dict[str, object], identity: str, name: str, png: bytes) -> None:
    """Two outputs: the widget, and a picture that the style sheet hides while the widget is in the page.

    A front end that knows widgets chooses the widget among several forms of one output, also where there is no kernel
    and it can only say "model not found": the picture must be an output of its own. Nor is it shown twice by hosts
    without widgets, which find a name alone in the first.

    Parameters
    ----------
    widget_bundle : dict
        What the widget's own output consists of.
    identity : str
        Of the widget, whose element in the page has the class ``LIVE + identity``.
    name : str
    png : bytes
        The picture.
    """
    url = data_url(png)
    plain = {"image/png", "text/plain"}
    view = {kind: data for kind, data in widget_bundle.items() if kind not in plain}
    display({**view, "text/plain": name}, raw=True)
    image = (
        f"<style>body:has(.{LIVE}{identity}) .qgeo-saved-{identity} {{ display: none; }}</style>"
        f'<div class="qgeo-saved-{identity}"><img alt="{name}, as it was when the cell was run" src="{url}" '
        'style="max-width:100%"></div>'
    )
    # The bare picture is for what takes no HTML, LaTeX for one.
    display({"text/html": image, "image/png": png, "text/plain": ""}, raw=True)
