"""Eq. (3) on shapes whose mirror map is known, and the paper's Table 1 beside sqrt(8 / n).

    QGEO_DATA=... python benchmarks/symmetry_measure.py

First table: root mean square of s(p) - s(Tp) over mirror images, divided by that over all pairs, for the three
readings of the sum. Second: epsilon over all pairs with five eigenvectors of the plain matrix, over sqrt(n), for those
of the paper's meshes that are manifold and in one piece.
"""

from __future__ import annotations

import os
from pathlib import Path

import igl
import numpy as np

from qgeo_filters import MeshError, Surface, distance_spectrum
from qgeo_filters.geodesics.lifting import lifted_metric
from qgeo_filters.matching.symmetry_measure import symmetry_epsilon

READINGS = ("printed", "even", "absolute")
TABLE_1 = {
    "lioness0": 0.0506,
    "wolf0": 0.0485,
    "seahorse0": 0.0603,
    "dog0": 0.0486,
    "michael0": 0.0486,
    "centaur0": 0.0485,
}


def mirror_images(tosca: Path, name: str) -> np.ndarray:
    """True left/right map of a remeshed pose."""
    tables = np.load(tosca / "ground_truth" / f"{name}.npz")
    mirror = np.loadtxt(tosca / "symmetry" / f"{name.rstrip('0123456789')}.sym", dtype=int).ravel() - 1
    return tables["vertex_of_full"][mirror[tables["full_of_vertex"]]]


def main() -> None:
    """Print the tables."""
    tosca = Path(os.environ["QGEO_DATA"]) / "tosca"
    print("| shape | weight | " + " | ".join(READINGS) + " |\n|---|---|---|---|---|")
    for name in ("cat0", "horse0", "wolf0", "dog0", "centaur0"):
        surface = Surface(*igl.read_triangle_mesh(str(tosca / "remeshed" / f"{name}.off"))[:2])
        image = mirror_images(tosca, name)
        for weight in (0.0, 0.03):
            spectrum = distance_spectrum(surface, metric=lifted_metric(surface, weight=weight))
            ratios = [
                symmetry_epsilon(spectrum, image, reading=reading) / symmetry_epsilon(spectrum, reading=reading)
                for reading in READINGS
            ]
            print(f"| {name} | {weight} | " + " | ".join(f"{ratio:.3f}" for ratio in ratios) + " |", flush=True)
    print("\n| shape | n | paper | sqrt(8 / n) | five eigenvectors |\n|---|---|---|---|---|")
    for name, printed in TABLE_1.items():
        vertices = np.loadtxt(tosca / "lowres" / f"{name}.vert")
        n = len(vertices)
        try:
            surface = Surface(vertices, np.loadtxt(tosca / "lowres" / f"{name}.tri", dtype=int) - 1)
            spectrum = distance_spectrum(surface, metric=lifted_metric(surface, weight=0), weights="uniform")
            ours = f"{symmetry_epsilon(spectrum, k0=5, reading='printed') / np.sqrt(n):.4f}"
        except MeshError as error:
            ours = str(error).split(";")[0]
        print(f"| {name} | {n} | {printed:.4f} | {np.sqrt(8 / n):.4f} | {ours} |", flush=True)


if __name__ == "__main__":
    main()
