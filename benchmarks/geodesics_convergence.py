"""Convergence to the smooth surface: sphere, cone, cylinder, plane, the largest relative error of one row at each size.

    python benchmarks/geodesics_convergence.py [--json results/geodesics_convergence.json]

On the sphere the mesh converges with the square of the edge length; plane, cylinder and cone unroll, and what is
left is the bound of the graph.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import shapes
from geodesics_common import percent
from record import Record, recorded

from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.surface import Surface


def sphere() -> Iterator[tuple[Surface, np.ndarray]]:
    """Icospheres and great-circle distances."""
    for level in (2, 3, 4, 5):
        vertices, faces = shapes.icosphere(level)
        yield Surface(vertices, faces), np.arccos(np.clip(vertices @ vertices[0], -1, 1))


def plane() -> Iterator[tuple[Surface, np.ndarray]]:
    """Irregular square grids and straight lines."""
    for n in (10, 20, 40, 80):
        vertices, faces = shapes.grid(n, 0.3)
        yield Surface(vertices, faces), np.linalg.norm(vertices - vertices[0], axis=1)


def cylinder() -> Iterator[tuple[Surface, np.ndarray]]:
    """Cylinders of radius 1 and height 2, unrolled."""
    for n in (12, 24, 48, 96):
        vertices, faces = shapes.cylinder(n, n // 2, 1.0, 2.0)
        angle = np.abs(np.arctan2(vertices[:, 1], vertices[:, 0]))
        yield Surface(vertices, faces), np.hypot(angle, vertices[:, 2])


def cone() -> Iterator[tuple[Surface, np.ndarray]]:
    """Cones with a total angle of about 114 degrees, unrolled to a sector, from a point halfway up."""
    for n in (12, 24, 48, 96):
        vertices, faces = shapes.cone(n, n // 2, 3.0)
        start = 1 + n * (n // 4 - 1)
        slant = np.sqrt(10.0)
        radius = slant * np.hypot(vertices[:, 0], vertices[:, 1])
        angle = np.abs(np.arctan2(vertices[:, 1], vertices[:, 0])) / slant
        apart = np.sqrt(np.maximum(radius**2 + radius[start] ** 2 - 2 * radius * radius[start] * np.cos(angle), 0))
        order = np.argsort(np.arange(len(vertices)) != start, kind="stable")  # the start becomes vertex 0
        yield Surface(vertices[order], np.argsort(order)[faces]), apart[order]


def main(record: Record) -> None:
    """Print the table."""
    errors_at = [f"accuracy {accuracy}: max error, %" for accuracy in ("1e-3", "1e-5")]
    table = record.table("", "surface", "n", *errors_at, "order in h at 1e-5")
    for make in (sphere, cone, cylinder, plane):
        before = None
        for surface, truth in make():
            errors = []
            for accuracy in (1e-3, 1e-5):
                row = distances(surface, [0], accuracy=accuracy)[0]
                errors.append(np.abs(row - truth)[truth > 0] / truth[truth > 0])
            largest = errors[1].max()
            order = "" if before is None else f"{np.log2(before / largest):.1f}"
            table.row(make.__name__, surface.n_vertices, percent(errors[0].max()), percent(largest), order)
            before = largest


if __name__ == "__main__":
    with recorded() as record:
        main(record)
