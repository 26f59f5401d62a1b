"""One job of the command line: reads meshes, measures its stages, and writes results as soon as they exist."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table as TerminalTable

from qgeo_filters import __version__
from qgeo_filters.caching import cache
from qgeo_filters.cli.default_folder import default_folder
from qgeo_filters.cli.errors import to_standard_output
from qgeo_filters.cli.job_meshes import JobMeshes
from qgeo_filters.cli.job_text import plain
from qgeo_filters.cli.options import Settings
from qgeo_filters.cli.outputs import LISTING, OutputFolder
from qgeo_filters.cli.stage_display import StageDisplay, expected_seconds, keep_times
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.glossary import meaning
from qgeo_filters.report.html import Meaning, Picture, Table, formatted, write_report
from qgeo_filters.report.shown import Shown
from qgeo_filters.surface import Surface

_PIPE_WIDTH = 120
_SIDE_BY_SIDE = 3  # meshes in one table of the report
# Names of files and attributes are printed as they are: [these] would be taken for markup, :this: for a picture.
_PLAIN: dict[str, Any] = {"highlight": False, "markup": False, "emoji": False}


class Job(JobMeshes):
    """Results of one command on one mesh, or on several that belong together, in one folder.

    Each file is written whole or not at all, in the order in which results come: arrays and mesh first, then the
    pictures one by one, the report last. `OutputFolder` says which files may be replaced.

    Parameters
    ----------
    command : str
    settings : Settings
    parameters : mapping of str to anything
        What the report says of how results were made.
    meshes : sequence of Path
        Files of the meshes.
    names : sequence of str
        What the command, and messages of its functions, call the meshes, such as X and Y; nothing by default.
    inputs : iterable of Path
        What else is read.
    pictures, texts : iterable of str
        Names of the pictures and of the other files that may be made, the pictures' without suffix.
    meshes_made : iterable of str
        Names, without suffix, of the meshes that `write_meshes` writes beside those that were read; or what gives one.
    about : sequence of str, optional
        What the results are of, for the name of the folder; the meshes by default.
    """

    def __init__(
        self,
        command: str,
        settings: Settings,
        parameters: Mapping[str, Any],
        meshes: Sequence[Path] = (),
        *,
        names: Sequence[str] = (),
        inputs: Iterable[Path] = (),
        pictures: Iterable[str] = (),
        texts: Iterable[str] = (),
        meshes_made: Iterable[str | Callable[[Job], str]] = (),
        about: Sequence[str] | None = None,
    ) -> None:
        super().__init__(settings, meshes, names)
        self.command = command
        self.parameters = dict(parameters)
        self.subject = ""
        self.results: dict[str, Any] = {}
        self.seconds: dict[str, float] = {}
        self._pictures: list[Picture] = []
        self._notes = Console(stderr=True, quiet=settings.quiet, soft_wrap=True, **_PLAIN)
        self._display = StageDisplay(self._notes, self.shows_progress)
        drawn = pictures if settings.pictures else ()
        files = {"result.npz", "report.html", *texts, *(f"{name}.png" for name in drawn)}
        made = [name if isinstance(name, str) else name(self) for name in meshes_made]
        files |= {file for name in made for file in self.mesh_files(name)}
        of_meshes = {file for name in self.names for file in self.mesh_files(name)}
        if taken := sorted(of_meshes & files):
            raise ParameterError(
                f"a mesh would be written as {taken[0]}, which is another result: give it another name"
            )
        files |= of_meshes
        folder = settings.output
        if folder is None:
            folder = default_folder(command, [path.stem for path in self.paths] if about is None else about, self.paths)
        self._outputs = OutputFolder(folder, files, (*self.paths, *inputs), self._content)
        self.folder = self._outputs.folder

    @property
    def shows_progress(self) -> bool:
        """Whether a terminal is to show what goes on: not if quiet."""
        return not self.settings.quiet and sys.stderr.isatty()

    @contextmanager
    def stage(self, name: str, mesh: int | None = None) -> Iterator[None]:
        """Context that measures a stage, in wall-clock seconds, and shows on a terminal how far it is.

        Stages of one name, such as those of several meshes, are one: their seconds are added up. Errors are those of a
        mesh as in `about`.
        """
        started = time.perf_counter()
        size = sum(mesh["vertices"] for mesh in self.meshes)
        before = self.seconds.get(name, 0.0)
        expected = expected_seconds(cache.directory, self.command, name, size)
        left = None if expected is None else max(expected - before, 0.0)
        with self._display.stage(name, left), self.about(mesh):
            yield
        self.seconds[name] = round(before + time.perf_counter() - started, 3)

    # -- out ----------------------------------------------------------------------------------------

    def mesh_files(self, name: str) -> list[str]:
        """Files as which a mesh is written: PLY first, and what else was asked for."""
        return [f"{name}.{suffix}" for suffix in ("ply", *(self.settings.also or ()))]

    def save(
        self,
        results: Mapping[str, Any],
        arrays: Mapping[str, Any],
        *surfaces: Surface,
        shown: Sequence[Shown | None] = (),
        vertices: Iterable[str] = (),
    ) -> None:
        """Write result.json, result.npz and the meshes that were read, with their attributes, on the files' vertices.

        Parameters
        ----------
        results, arrays : mapping
        surfaces : Surface
            One for each mesh that was read, or none.
        shown : sequence of Shown or None
            The colours and the main number of each.
        vertices : iterable of str
            Names of the attributes that hold vertices of the mesh.
        """
        self.results.update(results)
        with self._outputs.writing("result.npz") as temporary, temporary.open("wb") as file:
            np.savez(file, **dict(arrays))
        for note in self._outputs.left:
            self._notes.print(f"qgeo: {note}")
        written = []
        for mesh, surface in enumerate(surfaces):
            given, look = self._of_file(surface, mesh, vertices), shown[mesh] if shown else None
            if look is not None:
                given = (look if given is surface else look.carried(partial(self.on_given, mesh=mesh))).on(given)
            written.append(given)
        if written:
            self.write_meshes(dict(zip(self.names, written, strict=True)))

    def write_meshes(self, surfaces: Mapping[str, Surface]) -> None:
        """Write meshes by name, in all forms that were asked for; PLY first, which keeps every attribute."""
        for suffix in ("ply", *(self.settings.also or ())):
            for name, surface in surfaces.items():
                with self._outputs.writing(f"{name}.{suffix}") as temporary, warnings.catch_warnings():
                    # PLY stands beside them.
                    warnings.filterwarnings("ignore", ".* holds no (such )?attributes, dropped", UserWarning)
                    surface.write(temporary)

    def picture(self, name: str, caption: str, draw: Callable[[], Figure]) -> None:
        """Draw and write a picture, unless pictures are not wanted."""
        if not self.settings.pictures:
            return
        with self.stage(f"picture {name}"), warnings.catch_warnings():
            # A script that the font lacks comes as boxes; who can read the name knows why.
            warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
            picture = Picture(name, draw(), caption)
            with self._outputs.writing(f"{name}.png") as temporary:
                temporary.write_bytes(picture.png)
        self._pictures.append(picture)

    @contextmanager
    def file(self, name: str) -> Iterator[Path]:
        """Context that gives a path to write to, for a file beside the results."""
        with self._outputs.writing(name) as temporary:
            yield temporary

    def text(self, name: str, content: str) -> None:
        """Write a text file beside the results."""
        with self.file(name) as temporary:
            temporary.write_bytes(content.encode("utf-8", errors="backslashreplace"))

    def finish(self, tables: Sequence[Table] = ()) -> None:
        """Write the report and the final result.json, and say where everything is."""
        with self._outputs.writing("report.html") as temporary:
            write_report(
                temporary,
                f"qgeo {self.command}: {self._subject()}",
                subtitle="" if self.subject else ", ".join(mesh["path"] for mesh in self.meshes),
                pictures=self._pictures,
                tables=[
                    Table.explained("Results", self._short_results(), self.command),
                    *tables,
                    *self._left_out(),
                    *self._mesh_tables(),
                    Table.of("Parameters", self.parameters),
                    Table.of("Wall-clock seconds", self.seconds),
                ],
                footer=f"qgeo-filters {__version__}. The same numbers are in result.json, the arrays in result.npz.",
            )
        self._outputs.list_files()
        keep_times(cache.directory, self.command, self.seconds, sum(mesh["vertices"] for mesh in self.meshes))
        self._show(tables)

    def _show(self, tables: Sequence[Table]) -> None:
        with to_standard_output():
            self._print(tables)

    def _print(self, tables: Sequence[Table]) -> None:
        if self.settings.json:
            sys.stdout.write((self.folder / LISTING).read_text(encoding="utf-8"))
            return
        # A file or a pipe has no width; the usual guess of 80 columns would cut tables short.
        width = None if sys.stdout.isatty() else _PIPE_WIDTH
        console = Console(quiet=self.settings.quiet, width=width, **_PLAIN)
        title = f"{self.command}  {self._subject()}"
        for table in (Table.of(title, self._short_results()), *tables, *self._left_out()):
            shown = TerminalTable(title=table.title, title_justify="left", show_header=bool(table.columns))
            for column in table.columns or ("", ""):
                shown.add_column(column)
            for row in table.rows:
                shown.add_row(*map(formatted, row))
            console.print(shown)
        for mesh in self.meshes:
            for sentence in mesh.get("repaired", ()):
                console.print(f"repaired {Path(mesh['path']).name}: {sentence}", soft_wrap=True)
        console.print(f"{', '.join(self._outputs.files)} in {self.folder}", soft_wrap=True)

    def _subject(self) -> str:
        """What the job is about, for headings."""
        files = [Path(mesh["path"]).name for mesh in self.meshes]
        return self.subject or ", ".join(files[:4]) + (f" and {len(files) - 4} more" if len(files) > 4 else "")

    def _mesh_tables(self) -> list[Table]:
        """What the meshes are like: one explained, or several side by side."""
        of_all = [{name: value for name, value in mesh.items() if name != "path"} for mesh in self.meshes]
        if len(of_all) == 1:
            return [Table.explained("Mesh", of_all[0])]
        if len(of_all) > _SIDE_BY_SIDE:
            return [Table.of(f"Mesh {mesh['path']}", row) for mesh, row in zip(self.meshes, of_all, strict=True)]
        names = list(dict.fromkeys(name for mesh in of_all for name in mesh))
        rows = [(name, *(mesh.get(name) for mesh in of_all), Meaning(meaning(name))) for name in names]
        return [Table("Meshes", rows, ("", *(Path(mesh["path"]).name for mesh in self.meshes), ""))] if rows else []

    def _left_out(self) -> list[Table]:
        """The files that could not be used, and why, where there are some."""
        rows = [(one["path"], one["why"]) for one in self.results.get("left_out", ())]
        return [Table("Left out", rows, ("file", "why"), meaning("left_out"))] if rows else []

    def _short_results(self) -> dict[str, Any]:
        """Results but for long lists and records, which have a table of their own."""
        return {
            name: value
            for name, value in self.results.items()
            if not isinstance(value, list) or (len(value) <= 6 and not any(isinstance(item, dict) for item in value))
        }

    def _content(self) -> dict[str, Any]:
        """Content of result.json but for the list of files."""
        content = {
            "command": self.command,
            "qgeo_filters": __version__,
            "parameters": self.parameters,
            **({"mesh": self.meshes[0]} if len(self.meshes) == 1 else {"meshes": self.meshes}),
            "results": self.results,
            "seconds": self.seconds,
        }
        return dict(plain(content))
