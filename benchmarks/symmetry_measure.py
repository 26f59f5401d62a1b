"""Eq. (3) on shapes whose mirror map is known, and the paper's Table 1 beside sqrt(8 / n).

    QGEO_DATA=... python benchmarks/symmetry_measure.py [--json FILE]

First table: root mean square of s(p) - s(Tp) over mirror images, divided by that over all pairs, for the three
readings of the sum. Second: epsilon over all pairs with five and with twenty eigenvectors of the plain matrix, over
sqrt(n), for the paper's meshes, repaired where they are not manifold (largest piece).
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from record import Record, recorded

from qgeo_filters import Surface, distance_spectrum
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.matching.symmetry_measure import Reading, symmetry_epsilon
from qgeo_filters.spectral.spectrum import Spectrum

READINGS: tuple[Reading, ...] = ("printed", "even", "absolute")
TABLE_1 = {
    "lioness0": 0.0506,
    "wolf0": 0.0485,
    "seahorse0": 0.0603,
    "dog0": 0.0486,
    "michael0": 0.0486,
    "centaur0": 0.0485,
}


def mirror_ratios(spectrum: Spectrum, image: np.ndarray) -> list[float]:
    """Epsilon over mirror images divided by that over all pairs, for each reading: 0 if eq. (3) holds, 1 if not."""
    return [
        symmetry_epsilon(spectrum, image, reading=reading) / symmetry_epsilon(spectrum, reading=reading)
        for reading in READINGS
    ]


def table_1(tosca: Path, name: str, weight: float = 0.0) -> dict[str, Any]:
    """Numbers of vertices as published and used, and epsilon with five and twenty eigenvectors over sqrt(n)."""
    published = sum(1 for line in (tosca / "lowres" / f"{name}.vert").read_text().splitlines() if line.strip())
    surface, _ = Surface.read(tosca / "lowres" / f"{name}.vert", repair="force").largest_component()
    spectrum = distance_spectrum(surface, 20, lifted_metric(surface, curvature_weight=weight), mass="uniform")
    five, twenty = (symmetry_epsilon(spectrum, k0=k, reading="printed") / np.sqrt(spectrum.n_vertices) for k in (5, 20))
    return {"n": published, "used": surface.n_vertices, "five": float(five), "twenty": float(twenty)}


def main(record: Record) -> None:
    """Print the tables."""
    tosca = Path(os.environ["QGEO_DATA"]) / "tosca"
    data = ToscaRemeshed(tosca)
    table = record.table("eq. (3)", "shape", "weight", *READINGS, align="lrrrr")
    for name in ("cat0", "horse0", "wolf0", "dog0", "centaur0"):
        surface, image = data.read(name), data.symmetry(name).images
        for weight in (0.0, 0.03):
            ratios = mirror_ratios(
                distance_spectrum(surface, metric=lifted_metric(surface, curvature_weight=weight)), image
            )
            table.row(name, weight, *(f"{ratio:.3f}" for ratio in ratios))
    columns = ("shape", "n", "used", "paper", "sqrt(8 / n)", "five eigenvectors", "twenty")
    table = record.table("Table 1", *columns, align="lrrrrrr")
    for name, printed in TABLE_1.items():
        row = table_1(tosca, name)
        bound = np.sqrt(8 / row["n"])
        table.row(name, row["n"], row["used"], *(f"{x:.4f}" for x in (printed, bound, row["five"], row["twenty"])))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
