"""Sets with a file for each pair of shapes, or for each part of a whole."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation.datasets import Dataset, NoTruthError, PointMap, natural_key, vertices_from_one
from qgeo_filters.evaluation.template_datasets import VtsDataset
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import number_table, whole_numbers


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
        """The pairs of the benchmark of which both meshes are here."""
        yield from (pair for pair in self._maps if all(name in self.files for name in pair))

    def truth(self, x: str, y: str) -> PointMap:
        """True map of a pair of the benchmark."""
        if (x, y) not in self._maps:
            raise NoTruthError(f"the benchmark has no pair ({x}, {y})")
        images = vertices_from_one(self._maps[x, y])
        return PointMap(np.arange(len(images)), images)


class PartialDataset(Dataset):
    """Parts, each with a map onto a whole: SHREC'16 (cuts or holes), and PFARM.

    SHREC'16: ``null/off/NAME.off`` are the wholes, ``KIND/off/KIND_NAME_shape_K.off`` the parts, and
    ``KIND/corres/KIND_NAME_shape_K.vts`` the vertex of the whole, from 1, for each of the part (Cosmo et al.,
    "SHREC'16: Partial matching of deformable shapes"; in these files for DPFM). PFARM: meshes side by side,
    ``maps/PART_WHOLE.map`` the vertex of the whole, from 0.

    Parameters
    ----------
    root : path
    kind : str, optional
        Folder of the parts in SHREC'16's layout, "cuts" or "holes"; PFARM's without.
    """

    def __init__(self, root: str | PathLike[str], kind: str | None = None) -> None:
        root, self.kind = Path(root), kind
        folders = [root] if kind is None else [root / "null" / "off", root / kind / "off"]
        super().__init__(root, [file for folder in folders for file in folder.glob("*.off")])
        self._wholes = self._paired(list(self.files))

    def category(self, name: str) -> str:
        """One category."""
        return self.root.name if self.kind is None else self.kind

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """Each part with its whole."""
        yield from self._wholes.items()

    def truth(self, x: str, y: str) -> PointMap:
        """True map from a part to its whole; vertices without an image are left out."""
        if self._wholes.get(x) != y:
            raise NoTruthError(f"no true map from {x} to {y} is known")
        images = self._images(x, y)
        return PointMap(np.flatnonzero(images >= 0), images[images >= 0])

    def _images(self, part: str, whole: str) -> IndexArray:
        if self.kind is not None:
            return vertices_from_one(self.root / self.kind / "corres" / f"{part}.vts", missing=True)
        file = self.root / "maps" / f"{part}_{whole}.map"
        with path_in_errors(file):
            images = whole_numbers(number_table(file).ravel(), "vertex")
            if (images < -1).any():
                raise MeshError("expected vertices, counted from 0, or -1 for none")
        return images

    def _paired(self, names: list[str]) -> dict[str, str]:
        """Whole of each part that has a map."""
        wholes = {}
        for name in names:
            if self.kind is not None:
                if name.startswith(f"{self.kind}_"):
                    wholes[name] = name.removeprefix(f"{self.kind}_").split("_shape_")[0]
                continue
            for file in (self.root / "maps").glob(f"{name}_*.map"):
                wholes[name] = file.stem.removeprefix(f"{name}_")
        missing = sorted({whole for whole in wholes.values() if whole not in self.files})
        if missing:
            raise FileNotFoundError(f"{self.root}: the whole {missing[0]} is missing")
        return wholes


class TopKids(Dataset):
    """TOPKIDS: a child whose parts are glued together, onto the child at rest.

    ``off/kid00.off`` is at rest; ``corres/kidKK_ref.txt`` holds its vertex, from 1, for each of ``off/kidKK.off``
    (Laehner et al., "SHREC'16: Matching of deformable shapes with topological noise"). Where there is ``null.off``,
    that is at rest, and the files are those of a `VtsDataset`.
    """

    def __init__(self, root: str | PathLike[str]) -> None:
        root = Path(root)
        templated = root / "null.off"
        self._templated = VtsDataset(root) if templated.is_file() else None
        super().__init__(root, root.glob("*.off") if self._templated else (root / "off").glob("*.off"))
        self.rest = "null" if self._templated else "kid00"
        if self.rest not in self.files:
            raise FileNotFoundError(f"{self.root}: the shape at rest, off/{self.rest}.off, is missing")

    def category(self, name: str) -> str:
        """One category."""
        return self.root.name

    def pairs(self, category: str | None = None) -> Iterator[tuple[str, str]]:
        """Each shape with the one at rest."""
        yield from ((name, self.rest) for name in self.files if name != self.rest)

    def truth(self, x: str, y: str) -> PointMap:
        """True map to the shape at rest; vertices without an image are left out."""
        if y != self.rest:
            raise NoTruthError(f"true maps are known to {self.rest} only, not to {y}")
        if self._templated:
            return self._templated.truth(x, y)
        images = vertices_from_one(self.root / "corres" / f"{x}_ref.txt", missing=True)
        return PointMap(np.flatnonzero(images >= 0), images[images >= 0])

    def symmetry(self, name: str) -> PointMap:
        """True left/right map, where the files give it."""
        return self._templated.symmetry(name) if self._templated else super().symmetry(name)

    def reflected_images(self, x: str, y: str) -> IndexArray:
        """Mirrored true image of each point of ``truth(x, y)``."""
        return self._templated.reflected_images(x, y) if self._templated else super().reflected_images(x, y)
