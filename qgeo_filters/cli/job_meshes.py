"""The meshes of a job: read, repaired, described, and what is said or known of their vertices."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters.cli.in_turn import Batch
from qgeo_filters.cli.job_text import numbered
from qgeo_filters.cli.options import Settings
from qgeo_filters.errors import MeshError, QgeoError, TooLargeError, of_file, reason
from qgeo_filters.filters.repaired import carried_back, repaired_vertices
from qgeo_filters.hosts.dispatch import as_given, surface_and_repair
from qgeo_filters.hosts.given_images import images_on_given
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.repair.triangle_soup import Pieces
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices


class JobMeshes(ABC):
    """Meshes that belong together in one command.

    Parameters
    ----------
    settings : Settings
    meshes : sequence of Path
        Their files.
    names : sequence of str
        What the command, and messages of its functions, call the meshes, such as X and Y; nothing by default.

    Attributes
    ----------
    paths : tuple of Path
    meshes : list of dict
        What is said of each mesh that was read.
    repairs : list of Repair or None
    """

    def __init__(self, settings: Settings, meshes: Sequence[Path], names: Sequence[str]) -> None:
        self.settings = settings
        self.paths = tuple(meshes)
        self.meshes: list[dict[str, Any]] = []
        self.repairs: list[Repair | None] = []
        self._names = tuple(names)
        self._stems = numbered([path.stem or "mesh" for path in self.paths])
        self._surfaces: list[Surface] = []

    @abstractmethod
    def stage(self, name: str, mesh: int | None = None) -> AbstractContextManager[None]:
        """Context that measures a stage; errors are those of a mesh as in `about`."""

    @contextmanager
    def about(self, mesh: int | None = None) -> Iterator[None]:
        """Context in which what is wrong with a mesh, or too much, is said with its file: this one's or the only one's.

        Without a number, in a job on several meshes, it is said with the file of the mesh that the message begins with.
        """
        index = 0 if mesh is None and len(self.paths) == 1 else mesh
        try:
            yield
        except QgeoError as error:
            said = str(error)
            if index is None:
                index = next((i for i, name in enumerate(self._names) if said.startswith(f"{name}: ")), None)
            elif not isinstance(error, (MeshError, TooLargeError)):
                raise
            if index is None:
                raise
            for known in (self.paths[index], *self._names[index : index + 1]):
                said = said.removeprefix(f"{known}: ")
            raise type(error)(f"{self._called(index)}: {said}") from error
        except MemoryError as error:
            if index is None:
                raise
            size = f" of {self.meshes[index]['vertices']} vertices" if len(self.meshes) > index else ""
            raise MemoryError(f"{self._called(index)}{size}: {reason(error)}") from error

    def _called(self, mesh: int) -> str:
        """The file of a mesh, behind what the command calls it."""
        path = str(self.paths[mesh])
        return f"{self._names[mesh]} ({path})" if self._names else path

    def read(self, pieces: Pieces = "largest") -> list[Surface]:
        """Surfaces of the files, repaired if they must or are asked to be, in one piece or in all of them."""
        for index in range(len(self.paths)):
            self._read(index, pieces)
        return self._surfaces

    def read_good(self, batch: Batch, needed: Collection[int]) -> tuple[list[Surface], list[int]]:
        """Surfaces and indices of the files that can be read, which from then on are the job's; the others are named.

        Parameters
        ----------
        batch : Batch
            Names them.
        needed : collection of int
            Files without which there is nothing to do: what is wrong with one of them is raised.
        """
        good = []
        for index, path in enumerate(self.paths):
            with nullcontext() if index in needed else batch.trying(path):
                self._read(index, "largest")
                good.append(index)
        self._only(good)
        return self._surfaces, good

    def keep_good(self, batch: Batch, needed: Collection[int], task: Callable[[int], None]) -> list[int]:
        """Indices of the meshes that were read and that a task does not refuse, which from then on are the job's.

        Parameters
        ----------
        batch, needed
            As in `read_good`.
        task : callable
            Takes the index of a mesh.
        """
        good = []
        for index, path in enumerate(self.paths):
            with self.about(index) if index in needed else batch.trying(path):
                task(index)
                good.append(index)
        self._only(good)
        self.meshes = [self.meshes[index] for index in good]
        self.repairs = [self.repairs[index] for index in good]
        self._surfaces = [self._surfaces[index] for index in good]
        return good

    def _only(self, good: Sequence[int]) -> None:
        self.paths = tuple(self.paths[index] for index in good)
        self._names = self._names[: len(good)]  # what functions call them, who see no others
        self._stems = [self._stems[index] for index in good]

    def _read(self, index: int, pieces: Pieces) -> None:
        path = self.paths[index]
        with self.stage("read", index), of_file(str(path)):
            given, repair = surface_and_repair(path, self.settings.repair, pieces)
        surface = given if repair is None else repair.surface
        self.repairs.append(repair)
        self._describe(path, given, surface, repair.report if repair else ())

    def read_given(self) -> list[Surface]:
        """Surfaces of the files with all of their vertices, for what repairs them itself and says so by `repaired`."""
        for index, path in enumerate(self.paths):
            with self.stage("read", index), of_file(str(path)):
                given, notes = as_given(path, self.settings.repair)
            self.repairs.append(None)
            self._describe(path, given, given, notes)
        return self._surfaces

    def _describe(self, path: Path, given: Surface, surface: Surface, changes: Sequence[str]) -> None:
        mesh = {"path": str(path), **description(surface)}
        if self.settings.repair is not False and (changes or self.settings.repair != "auto"):
            mesh["repaired"] = list(changes)
        if surface.n_vertices != given.n_vertices:
            mesh["vertices_of_the_file"] = given.n_vertices
        self.meshes.append(mesh)
        self._surfaces.append(surface)

    def repaired(self, mesh: int, sentences: Sequence[str]) -> None:
        """Say what was repaired of a mesh after it was read."""
        if sentences:
            self.meshes[mesh]["repaired"] = [*self.meshes[mesh].get("repaired", ()), *sentences]

    def given_vertices(self, mesh: int = 0) -> int:
        """Number of vertices of the file."""
        repair = self.repairs[mesh]
        return self._surfaces[mesh].n_vertices if repair is None else repair.given.n_vertices

    def vertices(self, given: Sequence[int], what: str, mesh: int = 0) -> list[int]:
        """Vertices of the surface that was read, for vertices of the file.

        Raises
        ------
        ParameterError, MeshError
            Out of range, or gone in the repair.
        """
        known = checked_indices(np.array(given, dtype=np.int64), self.given_vertices(mesh), what)
        repair = self.repairs[mesh]
        return list((known if repair is None else repaired_vertices(repair, what, known)).tolist())

    def images_on_given(self, images: np.ndarray, of: int, on: int) -> np.ndarray:
        """Map of a mesh onto another, both as they were read, between the vertices of the files."""
        return images_on_given(images, self.repairs[of], self.repairs[on], self._surfaces[on])

    def on_given(self, values: np.ndarray, mesh: int = 0, *, axis: int = 0, vertices: bool = False) -> np.ndarray:
        """Values at the vertices of the file, from those of the surface that was read; NaN or -1 where one is gone.

        Parameters
        ----------
        values : array of one entry along ``axis`` for each vertex of the surface
        mesh, axis : int
        vertices : bool
            Whether the values are vertices of the mesh themselves.
        """
        repair = self.repairs[mesh]
        if repair is None:
            return values
        return np.moveaxis(carried_back(repair, np.moveaxis(np.asarray(values), axis, 0), vertices), 0, axis)

    @property
    def names(self) -> list[str]:
        """Names of the meshes' files without folder and suffix, numbered where they repeat."""
        return list(self._stems)

    def _of_file(self, surface: Surface, mesh: int, vertices: Iterable[str]) -> Surface:
        """The mesh with the vertices of the file, and its attributes there."""
        repair = self.repairs[mesh]
        if repair is None or surface.faces is not repair.surface.faces:
            return surface
        known = repair.surface.attributes
        added = {name: values for name, values in surface.attributes.items() if known.get(name) is not values}
        return repair.given.with_attributes(
            {name: carried_back(repair, values, name in vertices) for name, values in added.items()}
        )


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
