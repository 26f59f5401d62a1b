"""Poses with known correspondence, from the folder layouts of the public data sets."""

from __future__ import annotations

import itertools
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError, QgeoError
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import number_table, whole_numbers
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
        self.files: dict[str, Path] = {}
        for name, file in sorted(((self._name(file), file) for file in files), key=lambda one: natural_key(one[0])):
            same = self.files.setdefault(name, file)
            if same is not file:
                raise MeshError(f"{' and '.join(sorted(map(str, (same, file))))} are both {name}: leave one there")
        if not self.files:
            raise FileNotFoundError(f"no meshes of {type(self).__name__} under {self.root}")

    def _name(self, file: Path) -> str:
        """What a shape is called."""
        return file.stem

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

    def reflected_images(self, x: str, y: str) -> IndexArray:
        """Mirrored true image of each point of ``truth(x, y)``; NoTruthError where no left/right map is known."""
        truth, mirror = self.truth(x, y), self.symmetry(y)
        images = np.arange(truth.images.max() + 1)  # the true image itself, where its mirror image is not known
        known = mirror.points < len(images)
        images[mirror.points[known]] = mirror.images[known]
        return images[truth.images]

    def reversing(self, x: str, y: str) -> bool:
        """Whether the true map reverses the orientation: from a left tooth to a right one."""
        return False

    def _require_one_category(self, x: str, y: str) -> None:
        if self.category(x) != self.category(y):
            raise NoTruthError(f"{x} and {y} are of different categories: no true map between them is known")


def natural_key(name: str) -> tuple[tuple[str, int], ...]:
    """Sorting key that puts cat2 before cat10."""
    return tuple((text, int(number or -1)) for text, number in re.findall(r"(\D*)(\d*)", name)[:-1])


def read_vts(path: str | PathLike[str], *, missing: bool = False) -> IndexArray:
    """Vertices, from 0, at the points of the template, from a ``.vts`` file (one number from 1 in each line).

    Parameters
    ----------
    path : path
    missing : bool
        Whether 0 stands for a point without a vertex, which is -1 then; refused if not.
    """
    return vertices_from_one(Path(path), missing=missing)


def vertices_from_one(file: Path, *, missing: bool = False) -> IndexArray:
    """Numbers from 1 in a text file, as indices from 0; where there may be ``missing`` ones, 0 as -1."""
    if not file.is_file():
        raise NoTruthError(f"{file} is missing")
    with path_in_errors(file):
        table = number_table(file)
        if 1 not in table.shape:
            raise MeshError(f"expected one vertex, counted from 1, in each line, got a table of shape {table.shape}")
        values = whole_numbers(table.ravel(), "vertex")
        bad = np.flatnonzero(values < (0 if missing else 1))
        if bad.size:
            raise MeshError(
                f"expected one vertex, counted from 1, in each line, got {values[bad[0]]} ({bad.size} such)"
            )
    return values - 1


def images_of(of: IndexArray, at: IndexArray, file: Path) -> IndexArray:
    """Images of some vertices under the map of a file; MeshError for a vertex that it does not know."""
    outside = np.flatnonzero(at >= len(of))
    if outside.size:
        raise MeshError(
            f"{file}: no image of vertex {at[outside[0]]}, only of {len(of)} vertices, numbered from 0 "
            f"({outside.size} such {'vertex' if outside.size == 1 else 'vertices'})"
        )
    return of[at]
