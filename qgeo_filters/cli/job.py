"""One job of the command line: reads meshes, measures its stages, and writes results as soon as they exist."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table as TerminalTable

from qgeo_filters import __version__
from qgeo_filters.atomic import atomic_write
from qgeo_filters.cli.options import Settings
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.report.html import Picture, Table, formatted, write_report
from qgeo_filters.surface import Surface

_PIPE_WIDTH = 120


class Job:
    """Results of one command on one mesh, or on several that belong together, in one folder.

    Each file is written whole or not at all, in the order in which results come: arrays and mesh first, then the
    pictures one by one, the report last. Files that an earlier job left in the folder are removed when the
    first result of this one is written, so that the folder never holds a mixture.
    """

    def __init__(self, command: str, settings: Settings, parameters: Mapping[str, Any]) -> None:
        self.command = command
        self.settings = settings
        self.parameters = dict(parameters)
        self.folder = writable_folder(settings.output)
        self.subject = ""
        self.meshes: list[dict[str, Any]] = []
        self.results: dict[str, Any] = {}
        self.seconds: dict[str, float] = {}
        self.files: list[str] = []
        self._pictures: list[Picture] = []
        self._notes = Console(stderr=True, quiet=settings.quiet, highlight=False, soft_wrap=True)

    @property
    def progress(self) -> bool:
        """Whether progress bars are wanted: on a terminal, unless quiet."""
        return not self.settings.quiet and sys.stderr.isatty()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Context that measures a stage, in wall-clock seconds, and says on a terminal what goes on."""
        started = time.perf_counter()
        if self.progress:
            self._notes.print(f"[dim]… {name}[/dim]")
        yield
        self.seconds[name] = round(time.perf_counter() - started, 3)

    # -- in -----------------------------------------------------------------------------------------

    def read(self, path: Path) -> Surface:
        """Surface of a file, repaired if asked to."""
        with self.stage("read"):
            changes: Sequence[str] = ()
            if self.settings.repair:
                repaired = repair_surface(path)
                surface, changes = repaired.surface, repaired.report
            else:
                surface = Surface.read(path)
        mesh = {"path": str(path), **description(surface)}
        if self.settings.repair:
            mesh["repaired"] = list(changes)
        self.meshes.append(mesh)
        return surface

    @property
    def names(self) -> list[str]:
        """Names of the meshes' files without folder and suffix, numbered where they repeat."""
        stems = [Path(mesh["path"]).stem or "mesh" for mesh in self.meshes]
        return numbered(stems)

    # -- out ----------------------------------------------------------------------------------------

    def save(self, results: Mapping[str, Any], arrays: Mapping[str, Any], *surfaces: Surface) -> None:
        """Write result.json, result.npz and the meshes that were read, with their attributes."""
        self._clear()
        self.results.update(results)
        with atomic_write(self.folder / "result.npz") as file:
            np.savez(file, **dict(arrays))
        self.files += ["result.json", "result.npz"]
        for name, surface in zip(self.names, surfaces, strict=True):
            surface.write(self.folder / f"{name}.ply")
            self.files.append(f"{name}.ply")
        self._write_json()

    def picture(self, name: str, caption: str, draw: Callable[[], Figure]) -> None:
        """Draw and write a picture, unless pictures are not wanted."""
        if not self.settings.pictures:
            return
        with self.stage(f"picture {name}"):
            picture = Picture(name, draw(), caption)
            with atomic_write(self.folder / f"{name}.png") as file:
                file.write(picture.png)
        self._pictures.append(picture)
        self.files.append(f"{name}.png")

    def text(self, name: str, content: str) -> None:
        """Write a text file beside the results."""
        with atomic_write(self.folder / name) as file:
            file.write(content.encode("utf-8"))
        self.files.append(name)

    def finish(self, tables: Sequence[Table] = ()) -> None:
        """Write the report and the final result.json, and say where everything is."""
        self.files.append("report.html")
        write_report(
            self.folder / "report.html",
            f"qgeo {self.command}: {self._subject()}",
            subtitle=self.subject or ", ".join(mesh["path"] for mesh in self.meshes),
            pictures=self._pictures,
            tables=[
                Table.of("Results", self._short_results()),
                *tables,
                Table.of("Parameters", self.parameters),
                *self._mesh_tables(),
                Table.of("Wall-clock seconds", self.seconds),
            ],
            footer=f"qgeo-filters {__version__}. The same numbers are in result.json, the arrays in result.npz.",
        )
        self._write_json()
        self._show(tables)

    def _show(self, tables: Sequence[Table]) -> None:
        if self.settings.json:
            sys.stdout.write((self.folder / "result.json").read_text(encoding="utf-8"))
            return
        # A file or a pipe has no width; the usual guess of 80 columns would cut tables short.
        width = None if sys.stdout.isatty() else _PIPE_WIDTH
        console = Console(quiet=self.settings.quiet, highlight=False, width=width)
        title = f"{self.command}  {self._subject()}"
        for table in (Table.of(title, self._short_results()), *tables):
            shown = TerminalTable(title=table.title, title_justify="left", show_header=bool(table.columns))
            for column in table.columns or ("", ""):
                shown.add_column(column)
            for row in table.rows:
                shown.add_row(*map(formatted, row))
            console.print(shown)
        console.print(f"{', '.join(self.files)} in {self.folder}", soft_wrap=True)

    def _subject(self) -> str:
        """What the job is about, for headings."""
        files = [Path(mesh["path"]).name for mesh in self.meshes]
        return self.subject or ", ".join(files[:4]) + (f" and {len(files) - 4} more" if len(files) > 4 else "")

    def _mesh_tables(self) -> list[Table]:
        tables = []
        for mesh in self.meshes:
            title = "Mesh" if len(self.meshes) == 1 else f"Mesh {mesh['path']}"
            tables.append(Table.of(title, {name: value for name, value in mesh.items() if name != "path"}))
        return tables

    def _short_results(self) -> dict[str, Any]:
        """Results but for long lists and records, which have a table of their own."""
        return {
            name: value
            for name, value in self.results.items()
            if not isinstance(value, list) or (len(value) <= 6 and not any(isinstance(item, dict) for item in value))
        }

    def _write_json(self) -> None:
        content = {
            "command": self.command,
            "qgeo_filters": __version__,
            "parameters": self.parameters,
            **({"mesh": self.meshes[0]} if len(self.meshes) == 1 else {"meshes": self.meshes}),
            "results": self.results,
            "seconds": self.seconds,
            "files": self.files,
        }
        with atomic_write(self.folder / "result.json") as file:
            file.write((json.dumps(plain(content), indent=2, ensure_ascii=False) + "\n").encode("utf-8"))

    def _clear(self) -> None:
        """Make the folder; remove what an earlier job listed in its result.json."""
        self.folder.mkdir(parents=True, exist_ok=True)
        try:
            earlier = json.loads((self.folder / "result.json").read_text(encoding="utf-8"))
            names = earlier["files"] if "qgeo_filters" in earlier else []
        except (FileNotFoundError, ValueError, TypeError, KeyError):
            return
        for name in names:
            if isinstance(name, str) and Path(name).name == name:
                (self.folder / name).unlink(missing_ok=True)


def writable_folder(folder: Path) -> Path:
    """The folder, if it can be made and written to; said before hours of computing, not after."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise NotADirectoryError(f"cannot write into {folder}: {place} is not a folder")
    if not os.access(place, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write into {folder}: {place} is read-only")
    return folder


def description(surface: Surface) -> dict[str, Any]:
    """Counts and sizes of a mesh."""
    pieces = surface.components[0] - surface.unreferenced_vertices.size
    return {
        "vertices": surface.n_vertices,
        "faces": surface.n_faces,
        "edges": len(surface.edges),
        "area": surface.area,
        "pieces": pieces,
        "boundary_loops": len(surface.boundary_loops),
        "genus": surface.genus,
        "manifold": surface.is_manifold,
    }


def plain(value: Any) -> Any:
    """The value in JSON's own types; numbers that are not finite as the strings "inf", "-inf", "nan"."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def numbered(names: Sequence[str]) -> list[str]:
    """The names, those that occur more than once with -1, -2, ... behind them."""
    return [
        name if names.count(name) == 1 else f"{name}-{names[:position].count(name) + 1}"
        for position, name in enumerate(names)
    ]
