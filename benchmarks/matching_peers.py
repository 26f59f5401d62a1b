"""The map-free correspondence beside pyFM on the same pairs of TOSCA, as Markdown tables.

    pip install pyfmaps
    python benchmarks/matching_peers.py ROOT --categories cat dog centaur --pairs 3

ROOT holds ``remeshed``, ``ground_truth`` and ``symmetry`` (see `ToscaRemeshed`). The peer does what the quick start of
its README says (pyfmaps 1.3.1): wave kernel signatures, a functional map with the orientation term, ZoomOut. Both
methods get the same two meshes and nothing else, in the same direction, from X to Y. Errors are direct, in units of
sqrt(area of Y), at every vertex of X; CPU time is that of all threads.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from geodesics_common import machine
from pyFM.functional import FunctionalMapping
from pyFM.mesh import TriMesh

import qgeo_filters as qg
from qgeo_filters.evaluation import PairResult, Row, ToscaRemeshed, symmetric_errors

CATEGORIES = ("cat", "dog", "centaur", "horse", "michael", "victoria", "wolf")
#: Eigenfunctions that `FunctionalMapping.preprocess` takes by default: 128 of them for the descriptors.
PROCESSED = 200
#: README of pyfmaps 1.3.1, "Quickstart".
DESCRIPTORS = {"descr_type": "WKS", "subsample_step": 2}
FIT = {"K": 30, "w_descr": 1e0, "w_lap": 1e-1, "w_dcomm": 1e0, "w_orient": 1e0}
ZOOMOUT = {"nit": 16, "step": 5}


@dataclass(frozen=True, eq=False)
class Mapped:
    """A map and the CPU seconds that it took."""

    method: str
    p2p: np.ndarray
    confident: bool
    preparing: float
    matching: float


def ours(x: qg.Surface, y: qg.Surface) -> Iterator[Mapped]:
    """What `qg.match` finds."""
    start = time.process_time()
    shapes = [qg.Descriptor(surface).prepared() for surface in (x, y)]
    prepared = time.process_time()
    found = qg.match(*shapes)
    yield Mapped("`qg.match`", found.p2p, found.confident, prepared - start, time.process_time() - prepared)


def theirs(x: qg.Surface, y: qg.Surface) -> Iterator[Mapped]:
    """What pyFM finds, before and after ZoomOut. Its point maps go from its second mesh to its first."""
    start = time.process_time()
    meshes = [TriMesh(s.vertices, s.faces, area_normalize=True, center=True).process(PROCESSED) for s in (y, x)]
    prepared = time.process_time()
    model = FunctionalMapping(*meshes)
    model.preprocess(**DESCRIPTORS)
    model.fit(**FIT)
    p2p = model.get_p2p()
    fitted = time.process_time()
    yield Mapped("pyFM: WKS, orientation", p2p, True, prepared - start, fitted - prepared)
    resumed = time.process_time()
    refined = model.get_p2p(model.zoomout_refine(**ZOOMOUT))
    seconds = fitted - prepared + time.process_time() - resumed
    yield Mapped("pyFM: the same, ZoomOut", refined, True, prepared - start, seconds)


def main() -> None:
    """Print each pair as it is done, as a comment; then the pooled table and the means by category."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="+", default=CATEGORIES)
    parser.add_argument("--pairs", type=int, help="pairs of each category, drawn at random (seed 0); all by default")
    arguments = parser.parse_args()
    data = ToscaRemeshed(arguments.root)
    qg.warmup()
    results: dict[str, list[PairResult]] = {}
    seconds: dict[str, list[tuple[float, float]]] = {}
    for category in arguments.categories:
        pairs = list(data.pairs(category))
        np.random.default_rng(0).shuffle(pairs)
        for one, other in pairs[: arguments.pairs]:
            x, y = data.read(one), data.read(other)
            truth, mirror = data.truth(one, other), data.symmetry(other)
            for find in (theirs, ours):
                for found in find(x, y):
                    errors = symmetric_errors(found.p2p[truth.points], truth.images, mirror.images, y)
                    name, total = f"{one} - {other}", found.preparing + found.matching
                    results.setdefault(found.method, []).append(
                        PairResult(name, category, errors, found.confident, total)
                    )
                    seconds.setdefault(found.method, []).append((total, found.matching))
                    side = ", mirrored" if errors.mirrored else ""
                    print(
                        f"<!-- {name}, {found.method}: {errors.direct.mean():.4f}{side}, {total:.1f} s -->", flush=True
                    )
    print(f"pyfmaps {version('pyfmaps')}, {machine()}\n")
    report(results, seconds)


def report(results: dict[str, list[PairResult]], seconds: dict[str, list[tuple[float, float]]]) -> None:
    """Print both tables."""
    head = ["method", "pairs", "mean", "median", "< .05 (%)", "< .10 (%)", "< .25 (%)", "mirrored", "failed"]
    head += ["CPU s a pair", "without each shape's own"]
    print("| " + " | ".join(head) + " |\n|---|" + "---:|" * (len(head) - 1))
    for method, found in results.items():
        row = Row.of(method, found)
        total, matching = np.mean(seconds[method], axis=0)
        cells = [f"{row.pairs}", f"{row.direct.mean:.4f}", f"{row.direct.median:.4f}"]
        cells += [f"{100 * share:.1f}" for share in row.direct.below]
        cells += [f"{row.mirrored}", f"{row.failed}", f"{total:.1f}", f"{matching:.1f}"]
        print(f"| {method} | " + " | ".join(cells) + " |")
    categories = list(dict.fromkeys(result.category for result in next(iter(results.values()))))
    print("\n| mean error (mirrored) | " + " | ".join(categories) + " |")
    print("|---|" + "---:|" * len(categories))
    for method, found in results.items():
        rows = [Row.of(category, [r for r in found if r.category == category]) for category in categories]
        print(f"| {method} | " + " | ".join(f"{row.direct.mean:.4f} ({row.mirrored})" for row in rows) + " |")


if __name__ == "__main__":
    main()
