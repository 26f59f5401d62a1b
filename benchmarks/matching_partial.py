"""Parts matched to the whole, as a Markdown table: how far off, how many are right, and whether that is known.

    python benchmarks/matching_partial.py --tosca ROOT --pfarm FOLDER [--json FILE]
    python benchmarks/matching_partial.py --tosca ROOT --within 0.0 0.07 0.15 1.0

ROOT as for ``matching.py``: poses are cut by planes in random directions (35 to 80 % of the area stay), or lose five
patches of random size ("holes"), and are matched to another pose; the numbers that seed the cuts are 0, 2, 3 and 4 for
tuning and others for the test. FOLDER holds the cuts of people of PFARM and the body ``smpl-base-neutro.off`` that they
are matched to; all eight were looked at. Errors are geodesic distances on Y to the true point over sqrt(area of Y), of
vertices that have a partner. A map is right if its mean error is below .1.

With ``--truth``, the true place of each part is registered as those are that are found, and comes to rest as they do:
where it ends, and whether it strains less, costs less, or keeps distances better than the place that was found.

With ``--landmarks``, so many points of truth are known, those farthest from each other on the part.

With ``--within``, the experiment that decided how distances are compared: how much a distance on the part counts that
is not that on the whole although a cut may explain it (see `distance_bounds`); 1 counts it like any other.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from record import Record, Table, machine, recorded
from scipy.spatial import cKDTree

from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.matching.partial.part_choice import PartChoice
from qgeo_filters.matching.partial.part_pair import PartPair
from qgeo_filters.matching.partial.partial_match import partial_match
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.surface import Surface

PAIRS = [
    "cat1-cat0", "cat7-cat0", "dog1-dog0", "dog5-dog0", "centaur2-centaur0", "horse6-horse0", "horse10-horse0",
    "michael2-michael0", "michael10-michael0", "victoria1-victoria0", "victoria7-victoria0", "wolf2-wolf0",
]  # fmt: skip
WHOLE = "smpl-base-neutro"
RIGHT = 0.1


@dataclass(frozen=True, eq=False)
class Case:
    """A part, the whole, and the true vertex of the whole for each of the part (-1 where it is not known)."""

    name: str
    part: Surface
    whole: Surface
    truth: np.ndarray


def main(record: Record) -> None:
    """Print a table of sets, or of values; each case as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tosca", metavar="ROOT")
    parser.add_argument("--pfarm", metavar="FOLDER")
    parser.add_argument("--pairs", nargs="+", default=PAIRS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1])
    parser.add_argument("--truth", action="store_true")
    parser.add_argument("--landmarks", nargs="+", type=int, default=[0], metavar="COUNT")
    parser.add_argument("--within", nargs="+", type=float, default=[PartialParameters.within_bounds])
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    counts = ("right", "sure", "sure and wrong", "overlap, IoU", "CPU s")
    what = ("within bounds", "landmarks", "cases", "share of the area", "mean error", "median")
    table = record.table("parts" if arguments.truth else "", "set", *what, *counts, align="l" + 11 * "r")
    beside = (
        "set",
        "cases",
        "mean error",
        "from the true place",
        "it strains less",
        "costs less",
        "keeps distances better",
    )
    true_places = record.table("the true place", *beside, align="l" + 6 * "r") if arguments.truth else None
    sets: list[tuple[str, list[Case]]] = []
    if arguments.pfarm:
        cuts = list(_pfarm(Path(arguments.pfarm)))
        sets.append(("PFARM", cuts))
    if arguments.tosca:
        data = ToscaRemeshed(arguments.tosca)
        for seed in arguments.seeds:
            for kind in ("cuts", "holes"):
                sets.append((f"TOSCA {kind}, {seed}", list(_tosca(data, arguments.pairs, kind, seed))))
    for name, cases in sets:
        for within in arguments.within:
            for count in arguments.landmarks:
                _row(table, name, cases, replace(PartialParameters(), within_bounds=within), count)
        if true_places is not None:
            _true_row(true_places, name, cases)


def _pfarm(folder: Path) -> Iterator[Case]:
    whole = Surface.read(folder / f"{WHOLE}.off")
    for file in sorted(folder.glob("cut-*.off")):
        truth = np.loadtxt(folder / f"maps/{file.stem}_{WHOLE}.map").astype(np.int64)
        yield Case(file.stem, Surface.read(file), whole, truth)


def _tosca(data: ToscaRemeshed, pairs: list[str], kind: str, seed: int) -> Iterator[Case]:
    random = np.random.default_rng(seed)
    for pair in pairs:
        x, y = pair.split("-")
        pose, known = data.read(x), data.truth(x, y)
        truth = np.full(pose.n_vertices, -1)
        truth[known.points] = known.images
        kept = _beside_a_plane(pose, random) if kind == "cuts" else _outside_patches(pose, random)
        part, numbers = pose.submesh(kept)
        label = part.components[1]
        part, again = part.submesh(label == np.bincount(label, part.vertex_areas).argmax())
        yield Case(pair, part, data.read(y), truth[numbers[again]])


def _beside_a_plane(pose: Surface, random: np.random.Generator) -> np.ndarray:
    """Vertices on one side of a plane, in a random direction of the shape made round."""
    direction, share = random.normal(size=3), random.uniform(0.35, 0.8)
    areas = pose.vertex_areas
    centred = pose.vertices - areas @ pose.vertices / pose.area
    values, axes = np.linalg.eigh((centred * areas[:, None]).T @ centred)
    order = np.argsort((centred @ axes / np.sqrt(values)) @ direction)
    kept = np.zeros(pose.n_vertices, dtype=bool)
    kept[order[np.cumsum(areas[order]) < share * pose.area]] = True
    return kept


def _outside_patches(pose: Surface, random: np.random.Generator) -> np.ndarray:
    """Vertices outside five geodesic discs of .1 to .22 sqrt(area)."""
    rows = distances(pose, random.choice(pose.n_vertices, 5, replace=False)) / np.sqrt(pose.area)
    return np.all(rows > random.uniform(0.1, 0.22, (5, 1)), axis=0)


def _row(table: Table, name: str, cases: list[Case], given: PartialParameters, count: int) -> None:
    shares, errors, sure, overlaps, seconds = [], [], [], [], []
    for case in cases:
        start = time.process_time()
        # Cuts leave corners that hang by a vertex.
        part = PreparedShape(case.part, repair="force")
        problem = MatchProblem.of(part, case.whole, landmarks=_landmarks(case, part, count))
        found = partial_match(problem, given=given)
        seconds.append(time.process_time() - start)
        origin = np.arange(len(case.truth)) if problem.x.repair is None else problem.x.repair.origin
        truth = case.truth[origin]
        known = (found.p2p >= 0) & (truth >= 0)
        errors.append(float(geodesic_error(found.p2p[known], truth[known], case.whole).mean()))
        shares.append(case.part.area / case.whole.area)
        sure.append(found.confident)
        overlaps.append(_overlap(found.inverse >= 0, case))
        said = f"{'sure' if sure[-1] else 'not sure'}: {found.explanation}"
        print(f"<!-- {name}, {case.name}: error {errors[-1]:.4f}, overlap {overlaps[-1]:.2f}; {said} -->", flush=True)
    wrong = np.array(errors) > RIGHT
    share = f"{min(shares):.2f} to {max(shares):.2f}"
    found_cells = (f"{np.mean(errors):.3f}", f"{np.median(errors):.3f}", int((~wrong).sum()), sum(sure))
    rest = (int((wrong & sure).sum()), f"{np.mean(overlaps):.2f}", f"{np.mean(seconds):.1f}")
    table.row(name, f"{given.within_bounds:g}", count, len(cases), share, *found_cells, *rest)


def _true_row(table: Table, name: str, cases: list[Case]) -> None:
    """The place that is found beside the true one, between the shapes that are worked on."""
    rows = []
    for case in cases:
        problem = MatchProblem.of(case.part, case.whole, repair="force")
        pair = PartPair.of(problem.x, problem.y, PartialParameters(), None, 0)
        choice = PartChoice(pair.part, pair.whole, problem.log)
        found = choice.decide(choice.places()).best
        true = _true_images(case, problem, pair)
        place = choice.settled(choice.placed([(choice.proposed(true, "the truth"), true)]))[0]
        points = pair.part.fps[: len(true)]
        errors = [float(geodesic_error(p.map.p2p[points], true, pair.whole.surface).mean()) for p in (found, place)]
        less = (place.strain < found.strain, place.cost < found.cost, place.distortion < found.distortion)
        rows.append((*errors, *less))
    means = np.mean(rows, axis=0)
    table.row(name, len(cases), *(f"{m:.4f}" for m in means[:2]), *(f"{m:.0%}" for m in means[2:]))


def _true_images(case: Case, problem: MatchProblem, pair: PartPair) -> np.ndarray:
    """The vertex of the whole that is nearest to the true point of each of the part's first farthest points."""
    part, whole = pair.part, pair.whole
    truth = case.truth if problem.x.repair is None else case.truth[problem.x.repair.origin]
    known = np.flatnonzero(truth >= 0)
    points = part.vertices[part.fps[: part.given.coarse_points]] * part.unit + part.centre
    nearest = known[cKDTree(part.full.vertices[known]).query(points)[1]]
    there = (whole.full.vertices[truth[nearest]] - whole.centre) / whole.unit
    return cKDTree(whole.vertices).query(there)[1].astype(np.int64)


def _landmarks(case: Case, part: PreparedShape, count: int) -> list[tuple[int, int]] | None:
    """Points of truth that are farthest from each other, in space, of what a repair leaves; None for none."""
    left = np.arange(len(case.truth)) if part.repair is None else np.unique(part.repair.origin)
    known = left[case.truth[left] >= 0]
    places = case.part.vertices[known]
    chosen, nearest = [], np.linalg.norm(places - places.mean(axis=0), axis=1)
    for _ in range(count):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return [(int(known[i]), int(case.truth[known[i]])) for i in chosen] or None


def _overlap(found: np.ndarray, case: Case) -> float:
    """Area of the whole that rightly has a partner over that which has or should have one."""
    areas = case.whole.vertex_areas
    images = np.unique(case.truth[case.truth >= 0])
    spacing = 1.5 * np.sqrt(case.part.area / max(len(images), 1))
    here = cKDTree(case.whole.vertices[images]).query(case.whole.vertices)[0] < spacing
    return float(areas[found & here].sum() / areas[found | here].sum())


if __name__ == "__main__":
    with recorded() as record:
        main(record)
