"""TOSCA, remeshed and at its two resolutions, and other poses of equal vertex numbers."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation.datasets import Dataset, NoTruthError, PointMap, images_of, vertices_from_one
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import saved_arrays, whole_numbers


class ToscaRemeshed(Dataset):
    """TOSCA poses triangulated independently: ``remeshed/*.off``, ``ground_truth/*.npz``, ``symmetry/*.sym``.

    ``ground_truth/NAME.npz`` holds ``full_of_vertex`` (n,), the vertex of the full-resolution mesh for each vertex, and
    ``vertex_of_full``, the nearest vertex to each full-resolution one. ``symmetry/CATEGORY.sym`` holds the mirror
    image, from 1, of each full-resolution vertex.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        super().__init__(root, (Path(root) / "remeshed").glob("*.off"))

    def truth(self, x: str, y: str) -> PointMap:
        """True map, known at every vertex of x."""
        self._require_one_category(x, y)
        return self._through(self._table(x, "full_of_vertex"), y)

    def symmetry(self, name: str) -> PointMap:
        """True left/right map, known at every vertex."""
        file = self.root / "symmetry" / f"{self.category(name)}.sym"
        mirror = vertices_from_one(file)
        full = images_of(mirror, self._table(name, "full_of_vertex"), file)
        return self._through(full, name)

    def _through(self, full: IndexArray, y: str) -> PointMap:
        """Map to the vertices of y from those that are these on the full-resolution mesh."""
        return PointMap(np.arange(len(full)), images_of(self._table(y, "vertex_of_full"), full, self._file(y)))

    def _file(self, name: str) -> Path:
        return self.root / "ground_truth" / f"{name}.npz"

    def _table(self, name: str, key: str) -> IndexArray:
        file = self._file(name)
        if not file.is_file():
            raise NoTruthError(f"no ground truth for {name}: {file} is missing")
        with path_in_errors(file):
            tables = saved_arrays(file)
            if key not in tables:
                raise MeshError(f"no array {key}, only {', '.join(tables) or 'nothing'}")
            values = whole_numbers(tables[key], key)
            if values.ndim != 1 or (values < 0).any():
                raise MeshError(f"{key} must be vertices, counted from 0, in one dimension")
            return values


class IndexedDataset(Dataset):
    """Shapes of a category with vertex i at the same place on all: TOSCA at full resolution, FAUST's registrations.

    ``root`` holds the meshes themselves (``.off``, ``.ply``, ``.obj``, ``.vert`` with ``.tri``, ``.mat``), and
    optionally ``symmetry/CATEGORY.sym`` beside or below it.
    """

    SUFFIXES: tuple[str, ...] = (".off", ".ply", ".obj", ".vert", ".mat")

    def __init__(self, root: str | PathLike[str]) -> None:
        files = [file for file in Path(root).iterdir() if file.suffix.lower() in self.SUFFIXES]
        super().__init__(root, files)

    def truth(self, x: str, y: str) -> PointMap:
        """The identity."""
        self._require_one_category(x, y)
        sizes = self.read(x).n_vertices, self.read(y).n_vertices
        if sizes[0] != sizes[1]:
            raise NoTruthError(
                f"{x} and {y} have {sizes[0]} and {sizes[1]} vertices: they were triangulated independently, and "
                "equal indices mean nothing"
            )
        return PointMap(np.arange(sizes[0]), np.arange(sizes[0]))

    def symmetry(self, name: str) -> PointMap:
        """True left/right map."""
        for folder in (self.root / "symmetry", self.root.parent / "symmetry"):
            file = folder / f"{self.category(name)}.sym"
            if file.is_file():
                images = vertices_from_one(file)
                return PointMap(np.arange(len(images)), images)
        return super().symmetry(name)


class ToscaLowres(IndexedDataset):
    """TOSCA "nonrigid world" at 3400 vertices (``.vert`` and ``.tri``), the paper's meshes: no truth is known."""

    SUFFIXES: tuple[str, ...] = (".vert",)

    def truth(self, x: str, y: str) -> PointMap:
        """Raise NoTruthError: the meshes were decimated independently."""
        raise NoTruthError(f"no true map from {x} to {y} is known: the poses were decimated independently")
