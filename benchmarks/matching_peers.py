"""The map-free correspondence beside pyFM on the same pairs of TOSCA, as Markdown tables.

    pip install pyfmaps
    python benchmarks/matching_peers.py ROOT --categories cat dog centaur --pairs 3 --store DIR [--json FILE]

ROOT holds ``remeshed``, ``ground_truth`` and ``symmetry`` (see `ToscaRemeshed`); pairs and store are those of
``matching.py``, whose finished pairs are taken over. The peer does what the quick start of its README says (pyfmaps
1.3.1): wave kernel signatures, a functional map with the orientation term, ZoomOut. Both methods get the same two
meshes and nothing else, in the same direction, from X to Y. Errors are direct, in units of sqrt(area of Y), at every
vertex of X; CPU time is that of all threads.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np
from geodesics_common import cpu
from pyFM.functional import FunctionalMapping
from pyFM.mesh import TriMesh
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import PairResult, Row, ToscaRemeshed, symmetric_errors
from qgeo_filters.evaluation.runner import PairFailure, PairStore, by_target, measured

CATEGORIES = ("cat", "dog", "centaur", "horse", "michael", "victoria", "wolf")
OURS, FITTED, REFINED = "`qg.match`", "pyFM: WKS, orientation", "pyFM: the same, then ZoomOut"
#: Eigenfunctions that `FunctionalMapping.preprocess` takes by default: 128 of them for the descriptors.
PROCESSED = 200
#: README of pyfmaps 1.3.1, "Quickstart".
DESCRIPTORS = {"descr_type": "WKS", "subsample_step": 2}
FIT = {"K": 30, "w_descr": 1e0, "w_lap": 1e-1, "w_dcomm": 1e0, "w_orient": 1e0}
ZOOMOUT = {"nit": 16, "step": 5}
#: Of a kept result: what it was made by.
KEY = f"pyfmaps {version('pyfmaps')} {PROCESSED} {DESCRIPTORS} {FIT} {ZOOMOUT}"


def processed(surface: qg.Surface) -> TriMesh:
    """Everything of pyFM's that belongs to one shape."""
    return TriMesh(surface.vertices, surface.faces, area_normalize=True, center=True).process(PROCESSED)


def pyfm_maps(x: TriMesh, y: TriMesh) -> Iterator[tuple[str, np.ndarray, float]]:
    """Name, map and CPU seconds before and after ZoomOut. pyFM's point maps go from its second mesh to its first."""
    start = time.process_time()
    model = FunctionalMapping(y, x)
    model.preprocess(**DESCRIPTORS)
    model.fit(**FIT)
    p2p = model.get_p2p()
    seconds = time.process_time() - start
    yield FITTED, p2p, seconds
    refined, more = cpu(lambda: model.get_p2p(model.zoomout_refine(**ZOOMOUT)))
    yield REFINED, np.asarray(refined), seconds + more


def theirs(data: ToscaRemeshed, one: str, other: str, store: PairStore | None) -> Iterator[tuple[str, PairResult]]:
    """Results of pyFM on a pair, kept ones if there are any."""
    category = data.category(one)
    names = {method: f"{stem} {one} - {other}" for method, stem in ((FITTED, "pyfm of"), (REFINED, "zoomout of"))}
    kept = {method: store.load(name, category, KEY) if store else None for method, name in names.items()}
    if all(kept.values()):
        yield from ((method, result) for method, result in kept.items() if result)
        return
    x, y = data.read(one), data.read(other)
    truth, mirror = data.truth(one, other), data.symmetry(other)
    for method, p2p, seconds in pyfm_maps(processed(x), processed(y)):
        errors = symmetric_errors(p2p[truth.points], truth.images, mirror.images, y)
        result = PairResult(names[method], category, errors, True, seconds, p2p)
        if store:
            store.save(result, KEY)
        yield method, result


def preparing(data: ToscaRemeshed, pairs: list[tuple[str, str]]) -> dict[str, float]:
    """CPU seconds that both shapes of a pair take, mean over these pairs, with pyFM and with the package."""
    shapes = [data.read(name) for pair in pairs for name in pair]
    pyfm = 2 * float(np.mean([cpu(lambda shape=shape: processed(shape))[1] for shape in shapes]))
    own = 2 * float(np.mean([cpu(lambda shape=shape: qg.PreparedShape(shape).prepare())[1] for shape in shapes]))
    return {FITTED: pyfm, REFINED: pyfm, OURS: own}


def main(record: Record) -> None:
    """Print each pair as it is done, as a comment; then the pooled table and the means by category."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="+", default=CATEGORIES)
    parser.add_argument("--pairs", type=int, help="pairs of each category, drawn at random (seed 0); all by default")
    parser.add_argument("--store", type=Path, help="folder in which finished pairs are kept")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    store = PairStore(arguments.store) if arguments.store else None
    qg.warmup()
    results: dict[str, list[PairResult]] = {FITTED: [], REFINED: [], OURS: []}
    firsts = []
    for category in arguments.categories:
        pairs = list(data.pairs(category))
        np.random.default_rng(0).shuffle(pairs)
        chosen = [(str(one), str(other)) for one, other in pairs[: arguments.pairs]]
        firsts.append(chosen[0])
        for pair in chosen:
            for method, result in theirs(data, *pair, store):
                add(results, method, result)
        for outcome in measured(data, by_target(chosen), "match", store):
            if isinstance(outcome, PairFailure):
                raise outcome.error
            add(results, OURS, outcome)
    print(f"{machine()}\n")
    report(record, results, preparing(data, firsts))
    record.note(f"pyfmaps {version('pyfmaps')}.")


def add(results: dict[str, list[PairResult]], method: str, result: PairResult) -> None:
    """Note a result, and print it."""
    results[method].append(result)
    side = ", mirrored" if result.errors.mirrored else ""
    print(
        f"<!-- {method}, {result.name}: {result.errors.direct.mean():.4f}{side}, {result.seconds:.1f} s -->", flush=True
    )


def report(record: Record, results: dict[str, list[PairResult]], prepared: dict[str, float]) -> None:
    """Both tables."""
    head = ["method", "pairs", "mean", "median", "< .05 (%)", "< .10 (%)", "< .25 (%)", "mirrored", "failed"]
    head += ["CPU s a pair", "and for its two shapes"]
    table = record.table("all", *head, align="l" + (len(head) - 1) * "r")
    for method, found in results.items():
        row = Row.of(method, found)
        cells = [f"{row.n_pairs}", f"{row.mean:.4f}", f"{row.points.median:.4f}"]
        cells += [f"{100 * share:.1f}" for share in row.points.below]
        cells += [f"{row.n_mirrored}", f"{row.n_failed}", f"{row.seconds:.1f}", f"{prepared[method]:.1f}"]
        table.row(method, *cells)
    categories = list(dict.fromkeys(result.category for result in results[OURS]))
    table = record.table("each category", "mean error, worst pair", *categories, align="l" + len(categories) * "r")
    for method, found in results.items():
        rows = [Row.of(category, [r for r in found if r.category == category]) for category in categories]
        table.row(method, *(f"{row.mean:.4f}, {row.worst:.4f}" for row in rows))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
