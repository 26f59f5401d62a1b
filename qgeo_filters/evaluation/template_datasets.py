"""Sets in which every shape knows its vertices at the points of one template: ``.vts`` files."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation.datasets import Dataset, NoTruthError, PointMap, images_of, vertices_from_one
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.matlab import variables
from qgeo_filters.io.number_files import whole_numbers

# Where the meshes of a set are looked for, the first of these that holds any.
_FOLDERS = ("off", "shapes", "shapes_test", "vtx_5k", ".")
_MATCHES = "smpl_matches"


class VtsDataset(Dataset):
    """FAUST, SCAPE, SHREC'19, SMAL and others remeshed: ``off/NAME.off`` (or beside) and ``corres/NAME.vts``.

    Line i of a ``.vts`` file is the vertex, from 1, at point i of a template, 0 where there is none; so two shapes are
    known to correspond at the template's points. Layout of Ren, Poulenard, Wonka, Ovsjanikov, "Continuous and
    orientation-preserving correspondences via functional maps", SIGGRAPH Asia 2018. Left and right: those of the
    template's points, from 1, in ``corres/template.sym``, or for each shape its vertices at the mirrored points in
    ``corres/NAME.sym.vts``. Instead of a ``.vts`` file there may be ``mat/NAME.mat`` with the vertices in
    ``smpl_matches``, as the humans of SHREC'19 have it. ``test_pairs.txt``, where it is, lists the pairs, two names in
    each line; ``handedness.txt`` a name and ``+`` or ``-``: the true map of two unlike ones reverses the orientation.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        folders = (Path(root) / name for name in _FOLDERS)
        super().__init__(root, next((found for folder in folders if (found := list(folder.glob("*.off")))), []))

    def category(self, name: str) -> str:
        """One category: all shapes share the template."""
        return self.root.name

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """The pairs of ``test_pairs.txt`` of which both meshes are here, or every two shapes."""
        file = self.root / "test_pairs.txt"
        if not file.is_file():
            yield from super().pairs(category)
            return
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            names = line.split()
            if len(names) not in (0, 2):
                raise MeshError(f"{file}: line {number}: expected two names, got {line[:60]!r}")
            if names and all(name in self.files for name in names):
                yield names[0], names[1]

    def truth(self, x: str, y: str) -> PointMap:
        """True map at the vertices of x that a point of the template names; the first point of several counts."""
        points, first = self._points(x, y)
        return PointMap(points, self._vertices(y)[first])

    def symmetry(self, name: str) -> PointMap:
        """True left/right map, where that of the template or of the shape is known."""
        vertices = self._vertices(name)
        own, file = self._mirror_file(name), self.root / "corres" / "template.sym"
        if own.is_file():
            images = self._matching(vertices, vertices_from_one(own, missing=True), f"{name}.vts", own.name)
        elif file.is_file():
            mirror = vertices_from_one(file)
            images = images_of(self._matching(mirror, vertices, "template.sym", f"{name}.vts"), mirror, file)
        else:
            return super().symmetry(name)
        known = np.flatnonzero((vertices >= 0) & (images >= 0))
        points, first = np.unique(vertices[known], return_index=True)
        return PointMap(points, images[known[first]])

    def reflected_images(self, x: str, y: str) -> IndexArray:
        """Mirrored true image of each point of ``truth(x, y)``."""
        own = self._mirror_file(y)
        if not own.is_file():
            return super().reflected_images(x, y)
        right = self._vertices(y)
        mirrored = self._matching(right, vertices_from_one(own, missing=True), f"{y}.vts", own.name)
        _, first = self._points(x, y)
        return np.where(mirrored >= 0, mirrored, right)[first]

    def reversing(self, x: str, y: str) -> bool:
        """Whether ``handedness.txt`` has the two shapes apart; no pair is without that file."""
        file = self.root / "handedness.txt"
        if not file.is_file():
            return False
        signs: dict[str, str] = {}
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            words = line.split()
            if words and (len(words) != 2 or words[1] not in ("+", "-")):
                raise MeshError(f"{file}: line {number}: expected a name and + or -, got {line[:60]!r}")
            signs |= {words[0]: words[1]} if words else {}
        unknown = [name for name in (x, y) if name not in signs]
        if unknown:
            raise MeshError(f"{file} does not say of which hand {unknown[0]} is")
        return signs[x] != signs[y]

    def _points(self, x: str, y: str) -> tuple[IndexArray, IndexArray]:
        """Vertices of x, each once, that have a true image, and the point of the template that says so."""
        left = self._vertices(x)
        right = self._matching(left, self._vertices(y), f"{x}.vts", f"{y}.vts")
        known = np.flatnonzero((left >= 0) & (right >= 0))
        points, first = np.unique(left[known], return_index=True)
        return points, known[first]

    def _vertices(self, name: str) -> IndexArray:
        matlab = self.root / "mat" / f"{name}.mat"
        if matlab.is_file():
            return _vertices_of_matlab(matlab)
        return vertices_from_one(self.root / "corres" / f"{name}.vts", missing=True)

    def _mirror_file(self, name: str) -> Path:
        return self.root / "corres" / f"{name}.sym.vts"

    @staticmethod
    def _matching(one: IndexArray, other: IndexArray, first: str, second: str) -> IndexArray:
        """The second list, if it is as long as the first."""
        if len(one) != len(other):
            raise MeshError(f"{first} has {len(one)} points and {second} has {len(other)}; expected one template")
        return other


def _vertices_of_matlab(file: Path) -> IndexArray:
    """Vertices, from 0, at the points of the template, -1 where there is none, of a MATLAB file."""
    with path_in_errors(file):
        content = variables(file.read_bytes())
        matches = content.get(_MATCHES)
        if not isinstance(matches, np.ndarray):
            raise MeshError(f"no array {_MATCHES}, only {', '.join(content) or 'nothing'}")
        values = whole_numbers(matches.ravel(), _MATCHES)
        if (values < 0).any():
            raise MeshError(f"{_MATCHES} must hold vertices, counted from 1, or 0 for none, got {values.min()}")
    return values - 1


class SplitDataset(VtsDataset):
    """The shapes of a set that the field tests on, and the pairs that it takes of them.

    Parameters
    ----------
    root : path
    first : str, optional
        Shapes from this one on are the test set; all by default.
    ordered : bool
        Whether both directions of each pair count.
    """

    def __init__(self, root: str | PathLike[str], first: str | None = None, *, ordered: bool = True) -> None:
        super().__init__(root)
        names = list(self.files)
        if first in self.files:
            self.files = {name: self.files[name] for name in names[names.index(first) :]}
        self.ordered = ordered

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """Those of ``test_pairs.txt``, or else every two shapes, in both directions if these count."""
        if (self.root / "test_pairs.txt").is_file() or not self.ordered:
            yield from super().pairs(category)
        else:
            yield from itertools.permutations(self.names(category), 2)


class Dt4d(VtsDataset):
    """DeformingThings4D-Matching: ``off/CLASS/NAME.off``, ``corres/CLASS/NAME.vts``, pairs within a class and across.

    ``corres/cross_category_corres/ONE_OTHER.vts``, where it is, says for each point of the template of one class that
    of the other, from 1. Magnet and Ovsjanikov, "DWKS", 3DV 2021, and its successors. A name that several classes have
    becomes ``CLASS.NAME``.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        files = list((Path(root) / "off").glob("*/*.off"))
        self._classes = Counter(file.stem for file in files)
        Dataset.__init__(self, root, files)

    def _name(self, file: Path) -> str:
        return file.stem if self._classes[file.stem] == 1 else f"{file.parent.name}.{file.stem}"

    def category(self, name: str) -> str:
        """The folder of the shape."""
        return self.files[name].parent.name

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """Every two shapes of a class, the earlier first."""
        yield from Dataset.pairs(self, category)

    def truth(self, x: str, y: str) -> PointMap:
        """True map at the points of the template, or, of different classes, through the map between their templates."""
        one, other = self.category(x), self.category(y)
        if one == other:
            return super().truth(x, y)
        file = self.root / "corres" / "cross_category_corres" / f"{one}_{other}.vts"
        if not file.is_file():
            raise NoTruthError(f"no true map from {x} to {y} is known: {file} is missing")
        left, through, right = self._vertices(x), vertices_from_one(file, missing=True), self._vertices(y)
        self._matching(left, through, f"{x}.vts", file.name)
        known = np.flatnonzero((left >= 0) & (through >= 0))
        points, first = np.unique(left[known], return_index=True)
        images = images_of(right, through[known[first]], file)
        return PointMap(points[images >= 0], images[images >= 0])

    def _vertices(self, name: str) -> IndexArray:
        return vertices_from_one(self._beside(name, ".vts"), missing=True)

    def _mirror_file(self, name: str) -> Path:
        return self._beside(name, ".sym.vts")

    def _beside(self, name: str, suffix: str) -> Path:
        return self.root / "corres" / self.category(name) / f"{self.files[name].stem}{suffix}"
