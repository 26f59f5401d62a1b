"""The list of landmarks below two shapes, and the buttons that add to it and match again with it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import ipywidgets
import traitlets

from qgeo_widgets import controls
from qgeo_widgets.rendering.disposal import close_tree

Color = tuple[float, float, float]

# Told apart from each other and from the picks, also by those who see red as green.
_COLORS: tuple[Color, ...] = (
    (0.00, 0.45, 0.70), (0.00, 0.62, 0.45), (0.80, 0.47, 0.65), (0.34, 0.71, 0.91), (0.45, 0.30, 0.60), (0.3, 0.3, 0.3),
)  # fmt: skip
#: Of how far its image is from a landmark that the map is then said to miss, in sqrt(area).
_MISSED = 0.1


def landmark_color(number: int) -> Color:
    """Colour of a landmark, by its place in the list."""
    return _COLORS[number % len(_COLORS)]


def landmark_table(pairs: Sequence[tuple[int, int]]) -> str:
    """CSV of pairs of vertices, with a first line of names."""
    return "".join(f"{i},{j}\n" for i, j in [("x_vertex", "y_vertex"), *pairs])


class LandmarkList(ipywidgets.VBox):
    """A row for each landmark, with a button that removes it.

    Attributes
    ----------
    landmarks : list of (int, int)
        Vertex of X and vertex of Y.
    busy : bool
        Whether a map is sought; the button that starts it is then off.
    """

    landmarks: traitlets.List[tuple[int, int]] = traitlets.List(traitlets.Tuple(traitlets.Int(), traitlets.Int()))
    busy = traitlets.Bool(False)

    def __init__(
        self,
        use: Callable[[], None],
        match_again: Callable[[], None],
        load: Callable[[Path, Sequence[str]], None],
    ) -> None:
        self.use = controls.button("use as landmark", "the point picked on X belongs where the one picked on Y is")
        self.again = controls.button("match again", "seek the map with these landmarks")
        self.use.on_click(lambda _: use())
        self.again.on_click(lambda _: match_again())
        self._load = load
        self.files = ipywidgets.FileUpload(
            description="load",
            multiple=True,
            tooltip="a CSV of pairs of vertices, or two files of landmarks: on X, and on Y",
            layout={"width": "auto"},
        )
        self.files.observe(self._uploaded, "value")
        self._save = ipywidgets.HTML()
        self._state = ipywidgets.HTML()
        self._rows = ipywidgets.VBox(layout={"overflow": "visible"})
        self._errors: dict[tuple[int, int], float] = {}
        super().__init__(
            [controls.row(self.use, self.again, self.files, self._save, self._state), self._rows],
            layout={"overflow": "visible"},
        )

    def report(self, errors: Sequence[float]) -> None:
        """Show beside each landmark how far from it its image is, in sqrt(area)."""
        self._errors = dict(zip(self.landmarks, errors, strict=False))
        self._show()

    @traitlets.observe("landmarks")
    def _changed(self, change: Any) -> None:
        self._show()

    @traitlets.observe("busy")
    def _busy_changed(self, change: Any) -> None:
        self.again.disabled = self.busy
        count = len(self.landmarks)
        with_what = f" with {count} landmark{'s' if count > 1 else ''}" if count else ""
        self._state.value = f"matching again{with_what} …" if self.busy else ""

    def _remove(self, pair: tuple[int, int], _: Any) -> None:
        self.landmarks = [other for other in self.landmarks if other != pair]

    def _uploaded(self, change: Any) -> None:
        """Files were chosen in the browser: X first, in the order of their names."""
        uploads = sorted(change["new"], key=lambda upload: str(upload["name"]))
        if not uploads:
            return
        with TemporaryDirectory() as folder:
            names = [f"{number}-{Path(str(upload['name'])).name}" for number, upload in enumerate(uploads)]
            for name, upload in zip(names, uploads, strict=True):
                (Path(folder) / name).write_bytes(bytes(upload["content"]))
            self._load(Path(folder), names)
        self.files.value = ()

    def _show(self) -> None:
        data = base64.b64encode(landmark_table(self.landmarks).encode()).decode()
        link = f'<a download="landmarks.csv" href="data:text/csv;base64,{data}">save landmarks.csv</a>'
        self._save.value = link if self.landmarks else ""
        old, self._rows.children = self._rows.children, [self._row(*entry) for entry in enumerate(self.landmarks)]
        for row in old:
            close_tree(row)

    def _row(self, number: int, pair: tuple[int, int]) -> ipywidgets.HBox:
        remove = controls.button("remove", "this landmark is no longer used")
        remove.on_click(partial(self._remove, pair))
        return controls.row(ipywidgets.HTML(self._text(number, pair)), remove)

    def _text(self, number: int, pair: tuple[int, int]) -> str:
        color = "#" + "".join(f"{round(255 * channel):02x}" for channel in landmark_color(number))
        text = f"vertex {pair[0]} of X, vertex {pair[1]} of Y"
        if pair in self._errors:
            missed = " (missed)" if self._errors[pair] > _MISSED else ""
            text += f": the map comes within {self._errors[pair]:.3f} √area{missed}"
        return f'<span style="color:{color}">●</span> {text}'
