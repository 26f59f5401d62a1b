"""Spectrum from landmarks beside that of all vertices: subspace sine, eigenvalues, CPU seconds.

    python benchmarks/spectrum_landmarks.py [level] [--json FILE]

A lopsided sphere of 10 * 4^level + 2 vertices (10242 for the default level 5) and, where QGEO_DATA names the evaluation
data, three remeshed TOSCA shapes; the metric of the surface and the lifted one. "Eigenvalues" is the largest relative
error of one. A lifted metric has positive and negative ones of nearly equal size, which change places where they are
ordered by it: each of all vertices is compared with that of its sign and its place among those of its sign.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
from record import Record, recorded

from qgeo_filters import Surface
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.landmarks import farthest_points, landmark_operator
from qgeo_filters.spectral.spectrum import spectrum_of_matrix

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from shapes import blob


def surfaces(level: int) -> Iterator[tuple[str, Surface]]:
    """Made-up and real surfaces."""
    yield "blob", Surface(*blob(level, seed=1))
    if "QGEO_DATA" in os.environ:
        for name in ("cat0", "horse0", "michael0"):
            path = Path(os.environ["QGEO_DATA"]) / "tosca" / "remeshed" / f"{name}.off"
            yield name, Surface(*igl.read_triangle_mesh(str(path))[:2])


def largest_error(found: np.ndarray, true: np.ndarray) -> float:
    """Largest relative error of the eigenvalues, each paired within its sign."""
    gaps = []
    for sign in (1, -1):
        expected = true[sign * true > 0]
        gaps.append(np.abs(found[sign * found > 0][: len(expected)] / expected - 1))
    return float(np.concatenate(gaps).max())


def main(record: Record, level: int = 5, k: int = 20, spare: int = 10) -> None:
    """Print the table."""
    sines_of = ("sine, 20", "sine, 10", "eigenvalues", "CPU s", "all, CPU s")
    table = record.table("", "surface", "vertices", "weight", "landmarks", *sines_of, align="l" + 8 * "r")
    for name, surface in surfaces(level):
        areas = surface.vertex_areas
        for weight in (0.0, 0.03):
            metric = lifted_metric(surface, curvature_weight=weight)
            matrix = distance_matrix(surface, metric)
            start = time.process_time()
            full = spectrum_of_matrix(matrix, areas, k)
            full_time = time.process_time() - start
            for count in (500, 1000):
                start = time.process_time()
                points = farthest_points(surface, count, metric)
                part = spectrum_of_matrix(landmark_operator(metric, points, matrix[points]), areas, k + spare)
                seconds = time.process_time() - start
                sines = [
                    subspace_sine(part.eigenfunctions[:, :j], full.eigenfunctions[:, :j], areas) for j in (k, k // 2)
                ]
                error = largest_error(part.eigenvalues, full.eigenvalues)
                cells = (f"{sines[0]:.4f}", f"{sines[1]:.4f}", f"{error:.1e}", f"{seconds:.1f}", f"{full_time:.1f}")
                table.row(name, surface.n_vertices, weight, count, *cells)


if __name__ == "__main__":
    with recorded() as record:
        main(record, *map(int, record.arguments))
