"""Poses with known correspondence, from the folder layouts of the public data sets."""

from __future__ import annotations

import itertools
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError, QgeoError
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import number_table, saved_arrays, whole_numbers
from qgeo_filters.surface import Surface


class NoTruthError(QgeoError, LookupError):
    """A true map that the data set does not have: the message says which, and what file is missing."""


@dataclass(frozen=True, eq=False)
class PointMap:
    """Known images of some vertices.

    Attributes
    ----------
    points : (m,) int
        Vertices of X.
    images : (m,) int
        Vertex of Y for each of them.
    """

    points: IndexArray
    images: IndexArray


class Dataset(ABC):
    """Shapes in categories, and the true maps within a category.

    Attributes
    ----------
    root : Path
    files : dict of str to Path
        Mesh of each shape, by category and then by number.
    """

    def __init__(self, root: str | PathLike[str], files: Iterable[Path]) -> None:
        self.root = Path(root)
        self.files = {file.stem: file for file in sorted(files, key=lambda file: natural_key(file.stem))}
        if not self.files:
            raise FileNotFoundError(f"no meshes of {type(self).__name__} under {self.root}")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self.root)!r}: {len(self.files)} shapes)"

    def category(self, name: str) -> str:
        """Category of a shape: its name without the number, unless the data set has one only."""
        return re.sub(r"\d+$", "", name)

    @property
    def categories(self) -> tuple[str, ...]:
        """Categories in order."""
        return tuple(dict.fromkeys(self.category(name) for name in self.files))

    def names(self, category: str | None = None) -> list[str]:
        """Shapes of a category, or all."""
        return [name for name in self.files if category is None or self.category(name) == category]

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """Every two shapes of one category, the earlier first."""
        for one in self.categories if category is None else (category,):
            yield from itertools.combinations(self.names(one), 2)

    def read(self, name: str) -> Surface:
        """The mesh of a shape."""
        return Surface.read(self.files[name])

    @abstractmethod
    def truth(self, x: str, y: str) -> PointMap:
        """True map from shape x to shape y of its category.

        Raises
        ------
        NoTruthError
            No truth is known for this pair.
        """

    def symmetry(self, name: str) -> PointMap:
        """True left/right map of a shape; NoTruthError where none is known."""
        raise NoTruthError(f"{type(self).__name__} knows no left/right map of {name}")

    def _require_one_category(self, x: str, y: str) -> None:
        if self.category(x) != self.category(y):
            raise NoTruthError(f"{x} and {y} are of different categories: no true map between them is known")


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
        mirror = _indices(file)
        full = _images(mirror, self._table(name, "full_of_vertex"), file)
        return self._through(full, name)

    def _through(self, full: IndexArray, y: str) -> PointMap:
        """Map to the vertices of y from those that are these on the full-resolution mesh."""
        return PointMap(np.arange(len(full)), _images(self._table(y, "vertex_of_full"), full, self._file(y)))

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
                images = _indices(file)
                return PointMap(np.arange(len(images)), images)
        return super().symmetry(name)


class ToscaLowres(IndexedDataset):
    """TOSCA "nonrigid world" at 3400 vertices (``.vert`` and ``.tri``), the paper's meshes: no truth is known."""

    SUFFIXES: tuple[str, ...] = (".vert",)

    def truth(self, x: str, y: str) -> PointMap:
        """Raise NoTruthError: the meshes were decimated independently."""
        raise NoTruthError(f"no true map from {x} to {y} is known: the poses were decimated independently")


class VtsDataset(Dataset):
    """Remeshed FAUST, SCAPE (and SHREC'19) with ``.vts`` files: ``off/NAME.off`` and ``corres/NAME.vts``.

    Line i of a ``.vts`` file is the vertex, from 1, at point i of a template; so two shapes are known to correspond at
    the template's points. Layout of Ren, Poulenard, Wonka, Ovsjanikov, "Continuous and orientation-preserving
    correspondences via functional maps", SIGGRAPH Asia 2018. A left/right map of the template, from 1, may be in
    ``corres/template.sym``.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        super().__init__(root, (Path(root) / "off").glob("*.off"))

    def category(self, name: str) -> str:
        """One category: all shapes share the template."""
        return self.root.name

    def truth(self, x: str, y: str) -> PointMap:
        """True map at the vertices of x that a point of the template names; the first point of several counts."""
        left, right = self._vertices(x), self._vertices(y)
        if len(left) != len(right):
            raise MeshError(f"{x}.vts has {len(left)} points and {y}.vts has {len(right)}; expected one template")
        points, first = np.unique(left, return_index=True)
        return PointMap(points, right[first])

    def symmetry(self, name: str) -> PointMap:
        """True left/right map, where ``corres/template.sym`` gives that of the template."""
        file = self.root / "corres" / "template.sym"
        if not file.is_file():
            return super().symmetry(name)
        vertices = self._vertices(name)
        mirror = _indices(file)
        if len(mirror) != len(vertices):
            raise MeshError(
                f"{file} has {len(mirror)} points and {name}.vts has {len(vertices)}; expected one template"
            )
        points, first = np.unique(vertices, return_index=True)
        return PointMap(points, _images(vertices, mirror[first], file))

    def _vertices(self, name: str) -> IndexArray:
        return _indices(self.root / "corres" / f"{name}.vts")


class Shrec19(Dataset):
    """SHREC'19 humans with one file for each pair: ``off/N.off`` and ``groundtruth/N_M.map``, vertices from 1.

    Melzi, Marin, Rodola et al., "SHREC'19: Matching humans with different connectivity", 3DOR 2019.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        super().__init__(root, (Path(root) / "off").glob("*.off"))

    def category(self, name: str) -> str:
        """One category."""
        return self.root.name

    @cached_property
    def _maps(self) -> dict[tuple[str, str], Path]:
        files = sorted((self.root / "groundtruth").glob("*_*.map"), key=lambda file: natural_key(file.stem))
        return {(file.stem.split("_")[0], file.stem.split("_")[1]): file for file in files}

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """The pairs of the benchmark."""
        yield from self._maps

    def truth(self, x: str, y: str) -> PointMap:
        """True map of a pair of the benchmark."""
        if (x, y) not in self._maps:
            raise NoTruthError(f"the benchmark has no pair ({x}, {y})")
        images = _indices(self._maps[x, y])
        return PointMap(np.arange(len(images)), images)


def natural_key(name: str) -> tuple[tuple[str, int], ...]:
    """Sorting key that puts cat2 before cat10."""
    return tuple((text, int(number or -1)) for text, number in re.findall(r"(\D*)(\d*)", name)[:-1])


def read_vts(path: str | PathLike[str]) -> IndexArray:
    """Vertices, from 0, at the points of the template, from a ``.vts`` file (one number from 1 in each line)."""
    return _indices(Path(path))


def _indices(file: Path) -> IndexArray:
    """Numbers from 1 in a text file, as indices from 0."""
    if not file.is_file():
        raise NoTruthError(f"{file} is missing")
    with path_in_errors(file):
        table = number_table(file)
        if 1 not in table.shape:
            raise MeshError(f"expected one vertex, counted from 1, in each line, got a table of shape {table.shape}")
        values = whole_numbers(table.ravel(), "vertex")
        bad = np.flatnonzero(values < 1)
        if bad.size:
            raise MeshError(
                f"expected one vertex, counted from 1, in each line, got {values[bad[0]]} ({bad.size} such)"
            )
    return values - 1


def _images(of: IndexArray, at: IndexArray, file: Path) -> IndexArray:
    """Images of some vertices under the map of a file; MeshError for a vertex that it does not know."""
    outside = np.flatnonzero(at >= len(of))
    if outside.size:
        raise MeshError(
            f"{file}: no image of vertex {at[outside[0]]}, only of {len(of)} vertices, numbered from 0 "
            f"({outside.size} such {'vertex' if outside.size == 1 else 'vertices'})"
        )
    return of[at]
