"""`qg.match` on meshes with something wrong, as a Markdown table: what a user gets who repairs nothing.

    python benchmarks/messes.py ROOT [--pair horse0-horse5] [--scape FOLDER] [--skulls FOLDER ...]
        [--wrapped FOLDER ...] [--landmarks N ...] [--json FILE]

ROOT as for ``matching.py``. X is spoilt (see `mesh_messes`) and matched with Y as it is. Errors are those at the
vertices of X that the tidy mesh has too, in units of sqrt(area) of Y; "without partner" is the share of these that
got none. FOLDER holds meshes (.off) and ``corres/NAME.vts``, vertices from 1 that belong together row by row, 0 where
none is known. Seconds are CPU seconds. "Triangles" is the share of the tidy mesh's that are there after the repair.
A mesh that is refused is taken as the message advises: as a wrap. With --repair-only nothing is matched, which takes
seconds. With ``--landmarks N`` each pair is matched again with so many points of truth known, which a user would set on
the mesh as it is: those that are farthest from each other in space. Errors are over all points of truth.
"""

from __future__ import annotations

import argparse
import itertools
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from geodesics_common import cpu
from mesh_messes import MESSES, Messy
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.sampling import farthest_in_embedding

#: A map whose mean error is above this is wrong.
WRONG = 0.1


def verdict(found: qg.MatchResult) -> str:
    """Whether the match is sure of itself."""
    return "sure" if found.confident else "unsure"


def prepared(mesh: tuple[np.ndarray, np.ndarray]) -> qg.PreparedShape:
    """The shape, wrapped where the refusal advises that."""
    try:
        return qg.PreparedShape(mesh)
    except qg.MeshError as error:
        if "repair='wrap'" not in str(error):
            raise
        return qg.PreparedShape(mesh, repair="wrap")


def triangles_back(shape: qg.PreparedShape, messy: Messy, tidy: qg.Surface) -> str:
    """Share of the tidy mesh's triangles that the repaired one has, whichever side is out; none of a wrap."""
    if shape.repair is not None and not shape.repair.keeps_vertices:
        return "-"
    vertices = messy.origin if shape.repair is None else messy.origin[shape.repair.origin]
    there = set(map(tuple, np.sort(vertices[shape.full.faces], axis=1).tolist()))
    share = np.mean([face in there for face in map(tuple, np.sort(tidy.faces, axis=1).tolist())])
    return f"{100 * share:.2f} %"


class Landmarks:
    """A table of errors without hints, and with so many landmarks."""

    def __init__(self, record: Record, title: str, head: str, counts: list[int]) -> None:
        self._counts = counts
        heads = [f"{count} landmark{'s' * (count > 1)}" for count in counts]
        self._table = record.table(title, head, "no hints", *heads, align="l" + (1 + len(heads)) * "r")

    def row(
        self, name: str, x: qg.PreparedShape, y: qg.PreparedShape, truth: np.ndarray, found: qg.MatchResult
    ) -> None:
        """A row for a pair, ``found`` without hints; truth is a vertex of Y for each of X, -1 where there is none."""
        places = x.given.vertices
        known = np.flatnonzero((truth >= 0) & np.isfinite(places).all(axis=1))
        known = known[np.unique(truth[known], return_index=True)[1]]  # one of those that lie on each other
        chosen = known[farthest_in_embedding(places[known], max(self._counts))]
        results = [found]
        for count in self._counts:
            pairs = np.column_stack([chosen, truth[chosen]])[:count]
            results.append(qg.match(x, y, landmarks=pairs))
        self._table.row(name, *(self._cell(one, truth) for one in results))

    @staticmethod
    def _cell(found: qg.MatchResult, truth: np.ndarray) -> str:
        mean = float(np.nanmean(found.error(truth)))
        return f"{f'**{mean:.4f}**' if mean > WRONG else f'{mean:.4f}'}, {verdict(found)}"


def spoilt_rows(record: Record, root: str, pair: str, names: list[str], repair_only: bool, counts: list[int]) -> None:
    """A row for each kind of mess."""
    data = ToscaRemeshed(root)
    one, other = pair.split("-")
    tidy, y = data.read(one), qg.PreparedShape(data.read(other))
    images = data.truth(one, other).images
    columns = ("triangles", "repair, s", "repaired", "mean error", "without partner", "match, s")
    head = f"X = {one}, Y = {other}"
    table = record.table("spoilt", head, *columns, align="lllllrr")
    kept = []
    for name in names:
        messy = MESSES[name](np.array(tidy.vertices), np.array(tidy.faces), np.random.default_rng(0))
        try:
            shape, repairing = cpu(partial(prepared, (messy.vertices, messy.faces)))
            said = "; ".join(shape.repair.report) if shape.repair else "-"
            row = (name, triangles_back(shape, messy, tidy), f"{repairing:.2f}", said)
            if repair_only:
                table.row(*row, "", "", "")
                continue
            found, matching = cpu(partial(qg.match, shape, y))
        except qg.QgeoError as error:
            table.row(name, "", "", f"refused: {error}", "", "", "")
            continue
        known = messy.origin >= 0
        truth = np.where(known, images[messy.origin], -1)
        errors = found.error(truth)[known]
        error_cell = f"{np.nanmean(errors):.4f}, {verdict(found)}"
        table.row(*row, error_cell, f"{100 * np.isnan(errors).mean():.1f} %", f"{matching:.1f}")
        kept.append((name, shape, truth, found))
    if counts and kept:
        with_landmarks = Landmarks(record, "spoilt, landmarks", head, counts)
        for name, shape, truth, found in kept:
            with_landmarks.row(name, shape, y, truth, found)


def real_repairs(record: Record, folder: Path) -> None:
    """A row for each mesh of a folder: what is repaired of it."""
    columns = ("vertices", "genus", "seconds", "repaired")
    table = record.table(f"{folder.name}, repairs", folder.name, *columns, align="lrrrl")
    for path in sorted(folder.glob("*.off")):
        try:
            shape, seconds = cpu(lambda path=path: qg.PreparedShape(path))
        except qg.MeshError as error:
            table.row(path.stem, "", "", "", f"refused: {error}")
            continue
        said = "; ".join(shape.repair.report) if shape.repair else "-"
        table.row(path.stem, shape.full.n_vertices, shape.full.genus, f"{seconds:.2f}", said)


def real_rows(
    record: Record, folder: Path, count: int, counts: list[int], repair: Literal["auto", "wrap"] = "auto"
) -> None:
    """A row for each of the first pairs of a folder, repaired or wrapped."""
    names = sorted(path.stem for path in folder.glob("*.off"))
    shapes: dict[str, qg.PreparedShape | str] = {}
    kept = []
    columns = ("mean error", "verdict", "seconds: repairs, match", "repaired of X")
    name_of_table = f"{folder.name}, matches" if repair == "auto" else f"{folder.name}, matches of wraps"
    table = record.table(name_of_table, folder.name, *columns, align="lrlrl")
    for one, other in list(itertools.combinations(names, 2))[:count]:
        repairing = 0.0
        for name in (one, other):
            if name not in shapes:
                try:
                    shapes[name], seconds = cpu(
                        lambda path=folder / f"{name}.off": qg.PreparedShape(path, repair=repair)
                    )
                    repairing += seconds
                except qg.MeshError as error:
                    shapes[name] = str(error)
        x, y = shapes[one], shapes[other]
        if isinstance(x, str) or isinstance(y, str):
            table.row(f"{one}-{other}", f"refused: {x if isinstance(x, str) else y}", "", "", "")
            continue
        found, matching = cpu(lambda x=x, y=y: qg.match(x, y))
        here, there = (np.loadtxt(folder / "corres" / f"{name}.vts", dtype=np.int64) - 1 for name in (one, other))
        known = (here >= 0) & (there >= 0)
        truth = np.full(x.given.n_vertices, -1)
        truth[here[known]] = there[known]
        said = "; ".join(x.repair.report) if x.repair else "-"
        error = np.nanmean(found.error(truth))
        table.row(f"{one}-{other}", f"{error:.4f}", verdict(found), f"{repairing:.2f}, {matching:.1f}", said)
        kept.append((f"{one}-{other}", x, y, truth, found))
    if counts and kept:
        with_landmarks = Landmarks(record, f"{name_of_table}, landmarks", folder.name, counts)
        for row in kept:
            with_landmarks.row(*row)


def main(record: Record) -> None:
    """Print the tables, each row as it is done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pair", default="horse0-horse5")
    parser.add_argument("--messes", nargs="+", choices=MESSES, default=list(MESSES), metavar="MESS")
    parser.add_argument("--scape", type=Path, help="folder of SCAPE_a")
    parser.add_argument("--skulls", type=Path, nargs="+", default=[], help="folders of mouse skulls, raw and wrapped")
    parser.add_argument("--wrapped", type=Path, nargs="+", default=[], help="folders matched with repair='wrap'")
    parser.add_argument("--count", type=int, default=2, help="pairs of each folder")
    parser.add_argument("--landmarks", type=int, nargs="+", default=[], metavar="N", help="matched with so many too")
    parser.add_argument("--repair-only", action="store_true", help="match nothing")
    arguments = parser.parse_args(record.arguments)
    print(machine())
    spoilt_rows(record, arguments.root, arguments.pair, arguments.messes, arguments.repair_only, arguments.landmarks)
    for folder in [*([arguments.scape] if arguments.scape else []), *arguments.skulls]:
        real_repairs(record, folder)
        if not arguments.repair_only:
            real_rows(record, folder, arguments.count, arguments.landmarks)
    for folder in arguments.wrapped:
        real_rows(record, folder, 100, arguments.landmarks, "wrap")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
