"""What a pane shows where the browser has no WebGL: a sentence, a picture, and a button that draws it anew."""

from __future__ import annotations

import ipywidgets

# Hidden by the style sheet alone as soon as there is a canvas: the kernel cannot know what the browser can do.
STYLE = """<style>
.qgeo-pane { position: relative; overflow: hidden; border: 1px solid #d4d7dd; border-radius: 6px; }
.qgeo-pane .qgeo-no-webgl { position: absolute; inset: 0; padding: 8px; overflow: hidden; background: #f7f7f8;
  color: #333; opacity: 0; animation: qgeo-late 0s linear 4s forwards; }
@keyframes qgeo-late { to { opacity: 1; } }
.qgeo-pane:has(.jupyter-threejs canvas) .qgeo-no-webgl, .qgeo-pane:has(.jupyter-threejs img) .qgeo-no-webgl {
  display: none; }
.qgeo-no-webgl p { margin: 0 0 6px; line-height: 1.35; }
.qgeo-no-webgl img { display: block; max-width: 100%; max-height: calc(100% - 3.2em); margin: auto; }
</style>"""

_SENTENCE = "This browser shows no WebGL, so this is a still picture. The controls work; then draw it anew."


class FallbackImage(ipywidgets.VBox):
    """Sentence, button and picture over the place of a canvas, seen only while there is no canvas."""

    def __init__(self) -> None:
        self.redraw = ipywidgets.Button(description="draw anew", layout={"width": "auto"})
        self._picture = ipywidgets.HTML()
        super().__init__([ipywidgets.HTML(f"<p>{_SENTENCE}</p>"), self.redraw, self._picture])
        self.add_class("qgeo-no-webgl")

    def show(self, url: str) -> None:
        """Show the picture at a (data) URL."""
        self._picture.value = f'<img alt="the shape, drawn in software" src="{url}">'
