"""Deformation transfer and interpolation against truth, and how many frames a second they make, as Markdown tables.

    python benchmarks/deformation.py DATA [--only PART ...] [--json FILE]

DATA holds ``deformation_transfer``, ``tosca`` and ``harder``. Errors are mean distances between vertices over
sqrt(area); "bound" is the same transfer along the true map. Where frames differ, both are brought together by a rigid
motion first (people, TOSCA). PMD is the mean squared distance at unit height, times 1000. Folded edges are those across
which two triangles lie on each other that do not at rest, of all frames; crossing triangles are those that meet another
than a neighbour, by PyMeshLab. Maps are found by `match`, from nothing. ``large`` takes minutes, and is left out by
default; run it alone, for its peak of memory is that of the process.
"""

from __future__ import annotations

import argparse
import resource
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
import pymeshlab
from record import Record, machine, recorded
from sumner_popovic import PlainTransfer

import qgeo_filters as qg
from qgeo_filters.animation.measures import edge_changes, folded_edges
from qgeo_filters.animation.pose_transfer import PoseTransfer
from qgeo_filters.closest_points import closest_points
from qgeo_filters.decimation import decimated
from qgeo_filters.deformation.interpolation import InterpolationPath
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.evaluation import ToscaRemeshed

ANIMALS = ("horse", "cat", "lion")
# The animal whose poses are taken over, and one of another body model that takes them.
SMAL = [
    ("lion", "MaleLion800"), ("lion", "lion_yawn"), ("cat", "fox"), ("cat", "wolf_alph3"),
    ("cat", "stalking_wolf_cub_by_nieme"), ("horse", "Brown-And-White-Akita-Dog_alph"),
]  # fmt: skip
# X in its reference, the pose of it that is to be taken over, Y: three poses of one body.
TOSCA = [
    ("cat0", "cat1", "cat2"), ("centaur0", "centaur1", "centaur2"), ("dog0", "dog1", "dog2"),
    ("horse0", "horse10", "horse5"), ("michael0", "michael3", "michael7"), ("victoria0", "victoria1", "victoria10"),
    ("wolf0", "wolf1", "wolf2"),
]  # fmt: skip
# Pairs of poses between which shapes are interpolated, by their numbers from 0.
SEQUENCES = (("horse", 0, 5), ("cat", 0, 6), ("cat", 3, 8), ("lion", 1, 5))
# Set, the individual whose pose is taken over, the one that takes it, and that one in this pose: the truth.
PEOPLE = [
    ("kids_r", "0002.null.0", "0001.isometry.1", "0001.null.0"),
    ("kids_r", "0002.null.0", "0001.isometry.7", "0001.null.0"),
    ("kids_r", "0001.null.0", "0002.isometry.5", "0002.null.0"),
    ("faust_r", "tr_reg_051", "tr_reg_000", "tr_reg_001"),
]


def sequence(data: Path, animal: str) -> tuple[qg.Surface, list[np.ndarray]]:
    """An animal at rest, and its poses."""
    folder = data / "deformation_transfer"
    poses = sorted((folder / f"{animal}-poses").glob("*.obj"), key=lambda file: int(file.stem))
    return qg.Surface.read(folder / f"{animal}-poses.obj"), [qg.Surface.read(pose).vertices for pose in poses]


def shuffled(surface: qg.Surface) -> qg.Surface:
    """The same surface with its vertices in random order."""
    order = np.random.default_rng(0).permutation(surface.n_vertices)
    return qg.Surface(surface.vertices[order], np.argsort(order)[surface.faces])


def error(found: np.ndarray, truth: np.ndarray, area: float) -> float:
    """Mean distance over sqrt(area)."""
    return float(np.linalg.norm(found - truth, axis=1).mean() / np.sqrt(area))


def rigidly(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The positions found, brought to the truth by a rigid motion."""
    return Similarity.between(found, truth, np.ones(len(truth)), 1.0)(found)


def horse(data: Path, record: Record) -> None:
    """Poses of the horse on the horse in other triangles."""
    x, poses = sequence(data, "horse")
    errors = ("map error", "by the map alone", "transfer", "bound: true map", "ratio", "worst pose")
    table = record.table("horse", "vertices of Y", *errors, align="rrrrrrr")
    for count in (5000, 2500):
        y = shuffled(decimated(x, count).surface)
        true = closest_points(y.vertices, x)
        found = qg.match(x, y)
        auto = found.inverse_barycentric
        rows = []
        for place in (true, found):
            moved = qg.transfer_deformation(x, poses, y, place).positions
            rows.append([error(p, true.pulled_back(pose), y.area) for p, pose in zip(moved, poses, strict=True)])
        plain = [error(auto.pulled_back(pose), true.pulled_back(pose), y.area) for pose in poses]
        of_map = error(auto.pulled_back(x.vertices), true.pulled_back(x.vertices), y.area)
        bound, ours = np.mean(rows, axis=1)
        cells = [f"{v:.5f}" for v in (of_map, np.mean(plain), ours, bound)]
        table.row(count, *cells, f"{ours / bound:.2f}", f"{np.max(rows[1]):.5f}")


def tosca(data: Path, record: Record) -> None:
    """A third pose of a body is brought into a pose that is there as another mesh, by way of a reference."""
    read = ToscaRemeshed(data / "tosca")
    columns = ("X", "scan", "Y", "apart at rest", "vertices at hand", "error")
    table = record.table("tosca", *columns, align="lllrrr")
    for x, scan, y in TOSCA:
        reference, pose, body = (read.read(name) for name in (x, scan, y))
        result = qg.transfer_deformation(
            reference, [pose], body, scans=True, same_pose=False, same_body=True, accept_unsure=True
        )
        truth = read.truth(y, scan)
        places = pose.vertices[truth.images]
        # How far the vertices at hand are from the true places: those of another triangulation.
        spacing = float(np.median(pose.edge_lengths) / 2 / np.sqrt(pose.area))
        found = error(rigidly(result.positions[0][truth.points], places), places, pose.area)
        table.row(x, scan, y, f"{result.apart:.3f}", f"{spacing:.4f}", f"{found:.4f}")


def people(data: Path, record: Record) -> None:
    """One individual in the pose of another."""
    columns = ("error", "PMD x 1000", "X itself, grown to the size of Y", "its PMD", "edges changed, %")
    table = record.table("people", "pose of", "taken by", *columns, align="llrrrrr")
    for folder, x, y, target in PEOPLE:
        root = data / "harder" / folder
        pose, body, truth = (qg.as_surface(str(root / f"{name}.off")) for name in (x, y, target))
        vertices = [np.loadtxt(root / "corres" / f"{name}.vts", dtype=int) - 1 for name in (y, target)]
        known = (vertices[0] >= 0) & (vertices[1] >= 0)
        points, places = vertices[0][known], truth.vertices[vertices[1][known]]
        found = qg.match(pose, body)
        moved = qg.transfer_pose(pose, body, found, accept_unsure=True)
        grown = found.inverse_barycentric.pulled_back(pose.vertices) * np.sqrt(body.area / pose.area)
        changed = edge_changes(qg.Animation(body, moved.vertices[None]))[0]
        cells = []
        for positions in (moved.vertices, grown):
            near = rigidly(positions[points], places)
            height = float(np.ptp(places, axis=0).max())
            cells += [error(near, places, truth.area), 1000 * ((near - places) ** 2).sum(axis=1).mean() / height**2]
        found_cells, grown_cells = ((f"{cells[i]:.4f}", f"{cells[i + 1]:.2f}") for i in (0, 2))
        table.row(x, y, *found_cells, *grown_cells, f"{100 * changed:.1f}")


def animals(data: Path, record: Record) -> None:
    """The poses of each animal on the others."""
    columns = ("poses", "edges changed on X, %", "on Y, %", "folded edges on X", "on Y")
    table = record.table("animals", "X", "Y", "sure", *columns, align="lllrrrrr")
    for a in ANIMALS:
        x, poses = sequence(data, a)
        for b in ANIMALS:
            if a == b:
                continue
            y, _ = sequence(data, b)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # the column "sure" says it
                result = qg.transfer_deformation(x, poses, y, accept_unsure=True)
            assert result.source is not None
            assert result.correspondence is not None
            both = result.source, result
            changed = [f"{100 * edge_changes(film).mean():.1f}" for film in both]
            folded = [str(sum(folded_edges(film.surface, p) for p in film.positions)) for film in both]
            sure = "yes" if result.correspondence.confident else "no"
            table.row(a, b, sure, len(poses), *changed, *folded)


def crossing(surface: qg.Surface, positions: np.ndarray) -> int:
    """Number of triangles that cut through others."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(positions, surface.faces))
    meshes.compute_selection_by_self_intersections_per_face()
    return int(meshes.current_mesh().selected_face_number())


def smal(data: Path, record: Record) -> None:
    """The poses of the animals on those of SMAL, which stand in another pose and are other species."""
    edges = ("edges changed on X, %", "on Y, %", "folded edges a pose: X", "Y")
    columns = ("X", "Y", "sure", "poses", "apart at rest", *edges, "crossing triangles a pose, % (at rest): X", "Y")
    table = record.table("smal", *columns, align="lll" + 8 * "r")
    for a, b in SMAL:
        x, poses = sequence(data, a)
        y = qg.Surface.read(data / "harder" / "smal_r" / f"{b}.off")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # the column "sure" says it
            result = qg.transfer_deformation(x, poses, y, same_pose=False, accept_unsure=True)
        assert result.source is not None
        assert result.correspondence is not None
        both = result.source, result
        changed = [f"{100 * edge_changes(film).mean():.1f}" for film in both]
        folded = [f"{np.mean([folded_edges(film.surface, p) for p in film.positions]):.0f}" for film in both]
        cut = []
        for film in both:
            rest, *moved = (
                100 * crossing(film.surface, p) / film.surface.n_faces for p in (film.surface.vertices, *film.positions)
            )
            cut.append(f"{np.mean(moved):.1f} ({rest:.1f})")
        sure = "yes" if result.correspondence.confident else "no"
        table.row(a, b, sure, len(poses), f"{result.apart:.3f}", *changed, *folded, *cut)


def volume(surface: qg.Surface, positions: np.ndarray) -> float:
    """Volume within, with its sign."""
    a, b, c = (positions[surface.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def conformal(surface: qg.Surface, positions: np.ndarray) -> float:
    """Mean by area of s/t + t/s - 2 of the singular values s and t of each triangle's map from rest."""
    sides = [positions[surface.faces[:, k]] - positions[surface.faces[:, 0]] for k in (1, 2)]
    rest = [surface.vertices[surface.faces[:, k]] - surface.vertices[surface.faces[:, 0]] for k in (1, 2)]
    grams = [np.stack([[np.einsum("ij,ij->i", p, q) for q in e] for p in e]).transpose(2, 0, 1) for e in (rest, sides)]
    good = surface.face_areas > 1e-9 * surface.area / surface.n_faces
    metric = np.linalg.solve(grams[0][good], grams[1][good])
    root = np.sqrt(np.maximum(np.linalg.det(metric), 1e-30))
    return float(np.average(np.trace(metric, axis1=1, axis2=2) / root - 2, weights=surface.face_areas[good]))


def ways(start: qg.Surface, end: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """The shape half way, by each method."""
    yield "ours", InterpolationPath(start, end)(0.5)
    yield "straight lines", 0.5 * (start.vertices + end)
    # libigl's ARAP has handles that are moved: every twentieth vertex, half way on straight lines.
    handles = np.arange(0, start.n_vertices, 20)
    solver = igl.ARAPData()
    igl.arap_precomputation(start.vertices, start.faces.astype(np.int64), 3, handles, solver)
    yield "libigl ARAP", igl.arap_solve(0.5 * (start.vertices + end)[handles], solver, start.vertices)


def interpolation(data: Path, record: Record) -> None:
    """Half way between poses."""
    columns = ("edges, mean %", "edges, 99 % below", "volume, %", "conformal")
    table = record.table("interpolation", "poses", "method", *columns, align="llrrrr")
    for animal, i, j in SEQUENCES:
        rest, poses = sequence(data, animal)
        start, end = rest.with_vertices(poses[i]), poses[j]
        middle = 0.5 * (start.edge_lengths + rest.with_vertices(end).edge_lengths)
        size = 0.5 * (volume(rest, poses[i]) + volume(rest, end))
        kept = middle > 0
        for name, found in ways(start, end):
            changed = 100 * np.abs(start.with_vertices(found).edge_lengths[kept] / middle[kept] - 1)
            grown = 100 * (volume(rest, found) / size - 1)
            cells = (f"{changed.mean():.2f}", f"{np.quantile(changed, 0.99):.1f}", f"{grown:+.1f}")
            table.row(f"{animal} {i + 1}-{j + 1}", name, *cells, f"{conformal(start, found):.3f}")


def speed(data: Path, record: Record) -> None:
    """Frames a second of one thread after the first, ours and those of a plain implementation."""
    pairs = ("prepared in, CPU s: ours", "plain", "transfer, frames/s: ours", "plain", "error: ours", "plain")
    table = record.table("speed", "vertices of Y", *pairs, "interpolation, frames/s", align=8 * "r")
    x, poses = sequence(data, "horse")
    fine = qg.Surface(*igl.upsample(x.vertices, x.faces.astype(np.int64), 1))
    larger = qg.Surface(*igl.upsample(fine.vertices, fine.faces.astype(np.int64), 1))
    for y in (x, decimated(fine, 10_000).surface, decimated(larger, 50_000).surface):
        place = closest_points(y.vertices, x)
        cells = []
        for make in (lambda place=place, y=y: planned(x, y, place), lambda y=y: PlainTransfer(x, y)):
            begin = time.process_time()
            move = make()
            prepared = time.process_time() - begin
            move(poses[0])
            begin = time.process_time()
            moved = [move(pose) for pose in poses]
            rate = len(poses) / (time.process_time() - begin)
            truths = [place.pulled_back(pose) for pose in poses]
            gap = np.mean([error(rigidly(p, t), t, y.area) for p, t in zip(moved, truths, strict=True)])
            cells.append((f"{prepared:.1f}", f"{rate:.0f}", f"{gap:.5f}"))
        way = InterpolationPath(y, place.pulled_back(poses[3]))
        way(0.5)
        begin = time.process_time()
        frames = len(list(way.frames(np.linspace(0.1, 0.9, 48)))) / (time.process_time() - begin)
        table.row(y.n_vertices, *(cell for pair in zip(*cells, strict=True) for cell in pair), f"{frames:.1f}")


def large(data: Path, record: Record) -> None:
    """Half a million vertices: the horse and its poses subdivided three times. Memory is the peak of the process."""
    columns = ("vertices", "frames", "wall s", "CPU s", "peak memory, GB", "error, or edges changed")
    table = record.table("large", "what", *columns, align="lrrrrrr")
    x, poses = sequence(data, "horse")
    x, *some = (x.with_vertices(p) for p in (x.vertices, *poses[3:6]))
    for _ in range(3):
        x, *some = (qg.Surface(*igl.upsample(s.vertices, s.faces.astype(np.int64), 1)) for s in (x, *some))
    truths = [pose.vertices for pose in some]

    def row(name: str, task: Callable[[], np.ndarray], judged: Callable[[np.ndarray], str]) -> None:
        wall, cpu = time.perf_counter(), time.process_time()
        found = task()
        seconds = time.perf_counter() - wall, time.process_time() - cpu
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6  # kB on Linux
        cells = [f"{seconds[0]:.0f}", f"{seconds[1]:.0f}", f"{peak:.1f}", judged(found)]
        table.row(name, x.n_vertices, len(found), *cells)

    def changed(found: np.ndarray) -> str:
        middle = 0.5 * (x.edge_lengths + some[0].edge_lengths)
        return f"{100 * np.abs(x.with_vertices(found[8]).edge_lengths / middle - 1).mean():.2f} %"

    def gap(found: np.ndarray) -> str:
        return f"{np.mean([error(p, q, x.area) for p, q in zip(found, truths, strict=True)]):.5f}"

    same = np.arange(x.n_vertices)
    row("interpolation", lambda: qg.interpolate(x, some[0], np.linspace(0, 1, 17)).positions, changed)
    row("transfer, map given", lambda: qg.transfer_deformation(x, truths, x, same).positions, gap)
    y = shuffled(x)
    order = np.random.default_rng(0).permutation(x.n_vertices)
    truths = [truth[order] for truth in truths]
    poses_of_x = [pose.vertices for pose in some]
    row("transfer to shuffled vertices, map found", lambda: qg.transfer_deformation(x, poses_of_x, y).positions, gap)


def planned(x: qg.Surface, y: qg.Surface, place: qg.BarycentricMap) -> Callable[[np.ndarray], np.ndarray]:
    """Our transfer of the poses of X to Y, which lies on X at rest."""
    plan = PoseTransfer.of(x, y, place, same_pose=True, same_body=False, align=True, accept_unsure=False)
    return plan.moved


PARTS = {part.__name__: part for part in (horse, tosca, people, animals, smal, interpolation, speed, large)}


def main(record: Record) -> None:
    """Print the tables, each row as it is done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=[name for name in PARTS if name != "large"])
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    for name in arguments.only:
        PARTS[name](arguments.data, record)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
