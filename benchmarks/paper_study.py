"""The poses, metrics and stored results that the paper's tables and figures are made of.

Everything that takes time is kept in the output folder under a name that says what it is, and is not computed again: a
run that was stopped goes on where it was.
"""

from __future__ import annotations

import itertools
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters.atomic import atomic_path, atomic_write
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.evaluation.runner import PairStore
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.report.html import Table
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface

TUNING = ("cat", "dog", "centaur")
#: Eigenfunctions that are paired, as in the paper, and those beyond among which the last ones may find partners.
FUNCTIONS, SPARE = 20, 5
#: What stands for the paper's metric where one must, as the paper states neither: weight and scalar of the lowest
#: C_XY on the tuning categories (paper_metric.py).
GUIDED, SCALAR = 0.01, "mean_curvature"

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True)
class Claim:
    """What the paper says, what it prints for it, what is measured here, and whether it holds on this data."""

    text: str
    printed: str
    measured: str
    verdict: str


@dataclass(frozen=True)
class Part:
    """One table or figure of the paper, made again."""

    title: str
    claims: list[Claim] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    pictures: list[tuple[str, str]] = field(default_factory=list)  # name of the file, caption


class Store:
    """Results in a folder, each computed once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def value(self, key: str, compute: Callable[[], Any]) -> Any:
        """Numbers and words, from ``KEY.json``."""
        path = self._path(f"{key}.json")
        if not path.exists():
            text = json.dumps(_timed(key, compute), indent=1)
            with atomic_write(path) as file:
                file.write(text.encode())
        return json.loads(path.read_text())

    def arrays(self, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """Arrays by name, from ``KEY.npz``."""
        path = self._path(f"{key}.npz")
        if not path.exists():
            found = _timed(key, compute)
            with atomic_path(path) as temporary:
                np.savez(temporary, **found)
        with np.load(path) as stored:
            return dict(stored)

    def _path(self, name: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


class Study:
    """Some poses of each category of TOSCA, with their spectra and true maps.

    Parameters
    ----------
    root : Path
        Holds ``remeshed``, ``ground_truth``, ``symmetry`` and, for Table 1, ``lowres``.
    out : Path
        Results are stored in ``out/stored``, pictures in ``out/figures``.
    categories : sequence of str
    poses : int
        Of each category, evenly spread over its numbers.
    weights : sequence of float
        Of mean curvature in the metric; 0 is the Cartesian one.
    scalars, scalar_weights
        Further scalars, and the weights for them, on the tuning categories.
    matches : Path, optional
        Where maps found by `match` are kept, such as the store of ``benchmarks/matching.py``; by default in ``out``.
    """

    def __init__(
        self,
        root: Path,
        out: Path,
        categories: tuple[str, ...],
        poses: int,
        weights: tuple[float, ...],
        scalars: tuple[str, ...] = (),
        scalar_weights: tuple[float, ...] = (),
        matches: Path | None = None,
    ) -> None:
        self.root, self.figures = root, out / "figures"
        self.data = ToscaRemeshed(root)
        self.store = Store(out / "stored")
        self.matches = PairStore(matches or out / "stored" / "matches")
        self.categories, self.poses = categories, poses
        self.weights, self.scalars, self.scalar_weights = weights, scalars, scalar_weights
        #: Those at which poses are still alike.
        self.gentle = tuple(weight for weight in weights if weight <= 0.05)
        self.figures.mkdir(parents=True, exist_ok=True)
        self.surface = cache(self._surface)
        self.distances = lru_cache(2)(self._distances)

    def names(self, category: str, poses: int | None = None) -> list[str]:
        """The chosen poses of a category."""
        every = self.data.names(category)
        count = min(poses or self.poses, len(every))
        return [every[i] for i in np.unique(np.linspace(0, len(every) - 1, count).round().astype(int))]

    def pairs(self, category: str) -> list[tuple[str, str]]:
        """Every two of them."""
        return list(itertools.combinations(self.names(category), 2))

    def truth(self, x: str, y: str) -> np.ndarray:
        """Vertex of y for each of x."""
        return self.data.truth(x, y).images

    def mirror(self, name: str) -> np.ndarray:
        """Vertex of the other side for each vertex."""
        return self.data.symmetry(name).images

    def spectrum(self, name: str, weight: float, scalar: str = SCALAR) -> Spectrum:
        """The first eigenpairs of a pose in a metric."""
        surface = self.surface(name)

        def compute() -> Arrays:
            metric = lifted_metric(surface, scalar, weight)
            spectrum = distance_spectrum(surface, FUNCTIONS + SPARE, metric)
            return {"eigenvalues": spectrum.eigenvalues, "eigenfunctions": spectrum.eigenfunctions}

        label = metric_label(weight, scalar)
        stored = self.store.arrays(f"spectra/{name}-{label}", compute)
        return Spectrum.of(stored["eigenvalues"], stored["eigenfunctions"], surface.vertex_areas)

    def _surface(self, name: str) -> Surface:
        return self.data.read(name)

    def _distances(self, name: str) -> np.ndarray:
        return distance_matrix(self.surface(name))


def metric_label(weight: float, scalar: str = SCALAR) -> str:
    """Name of a metric in file names and tables."""
    return "cartesian" if weight == 0 else f"{scalar}-{weight:g}"


def _timed(key: str, compute: Callable[[], Any]) -> Any:
    start = time.process_time()
    result = compute()
    sys.stderr.write(f"{time.process_time() - start:7.1f} s  {key}\n")
    return result
