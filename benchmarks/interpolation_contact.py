"""Whether limbs go through the body on the way between two poses more than at its ends, as a Markdown table.

    python benchmarks/interpolation_contact.py DATA [--json FILE]

DATA holds ``tosca`` and ``deformation_transfer``: all pairs of ``tosca/full``, decimated to 5000 vertices (the other
pose is that of the same points), and those of the sequences that `deformation.py` interpolates. Crossing triangles are
those that cut through others than their neighbours, by PyMeshLab, in per cent of all, at both ends and at nine moments
between.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pymeshlab
from deformation import SEQUENCES, sequence
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.closest_points import closest_points
from qgeo_filters.decimation import decimated

TOSCA = (("cat", 0, 1), ("centaur", 0, 1), ("horse", 0, 10), ("michael", 0, 3), ("wolf", 0, 1), ("wolf", 0, 2))
TIMES = np.linspace(0, 1, 11)[1:-1]


def pairs(data: Path) -> Iterator[tuple[str, qg.Surface, np.ndarray]]:
    """Name, one pose, and the other one of its vertices."""
    for body, i, j in TOSCA:
        x, y = (qg.Surface.read(data / "tosca" / "full" / f"{body}{number}.off") for number in (i, j))
        coarse = decimated(x, 5000).surface
        yield f"{body}{i}-{body}{j}", coarse, closest_points(coarse.vertices, x).pulled_back(y.vertices)
    for animal, i, j in SEQUENCES:
        rest, poses = sequence(data, animal)
        yield f"{animal} {i + 1}-{j + 1}", rest.with_vertices(poses[i]), poses[j]


def lost(x: qg.Surface, end: np.ndarray) -> float:
    """Mean relative change of an edge half way on straight lines, from the mean of both ends."""
    half, other = (x.with_vertices(places).edge_lengths for places in (0.5 * (x.vertices + end), end))
    middle = 0.5 * (x.edge_lengths + other)
    kept = middle > 0
    return float(np.abs(half[kept] / middle[kept] - 1).mean())


def crossing(surface: qg.Surface, positions: np.ndarray) -> float:
    """Triangles that cut through others, in per cent."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(positions, surface.faces))
    meshes.compute_selection_by_self_intersections_per_face()
    return 100 * meshes.current_mesh().selected_face_number() / surface.n_faces


def table(data: Path, record: Record) -> None:
    """A row for each pair."""
    columns = (
        "vertices",
        "edges changed by straight lines, %",
        "crossing at the ends, %",
        "between: mean",
        "most",
        "at",
    )
    found = record.table("contact", "poses", *columns, "straight lines: mean", "most", align="l" + 8 * "r")
    for name, x, end in pairs(data):
        ends = [crossing(x, places) for places in (x.vertices, end)]
        frames = qg.interpolate(x, end, TIMES).positions
        ours = np.array([crossing(x, frame) for frame in frames])
        lines = np.array([crossing(x, (1 - t) * x.vertices + t * end) for t in TIMES])
        found.row(
            name,
            x.n_vertices,
            f"{100 * lost(x, end):.1f}",
            f"{ends[0]:.2f}, {ends[1]:.2f}",
            f"{ours.mean():.2f}",
            f"{ours.max():.2f}",
            f"{TIMES[ours.argmax()]:.1f}" if ours.any() else "",
            f"{lines.mean():.2f}",
            f"{lines.max():.2f}",
        )


def main(record: Record) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    table(arguments.data, record)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
