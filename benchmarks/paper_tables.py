"""The paper's Table 2 (C_XY) and D(S) (eq. 5, Fig. 7), over the weight and the scalar of the metric.

    QGEO_DATA=... python benchmarks/paper_tables.py [--poses 3] [--categories cat ...] [--scalars curvedness ...]

The claim under test: the curvature-guided metric gives a lower C_XY than the Cartesian one (weight 0, the paper's
[47]). Poses are TOSCA's, triangulated independently; eigenfunctions are paired through the true map, so that no method
of matching enters. C_XY is that of `spectral_distance`: over 20 eigenfunctions of mean square 1 ("area"), and with
unit eigenvectors over sqrt(n) ("vertices"). D(S) is the mean of C_XY over all pairs of a category, with the
baselines' eigenspectra carried to all poses.
"""

from __future__ import annotations

import argparse
import itertools
import os
from pathlib import Path

import numpy as np

from qgeo_filters.deformation.compatibility import compatibility_of_spectra
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.geodesics.lifting import lifted_metric
from qgeo_filters.spectral.commutative import commutative_eigenspectra
from qgeo_filters.spectral.distance_spectrum import Spectrum, distance_spectrum

#: The paper's Table 2: Cartesian metric [47], and its own.
PRINTED = {
    "victoria": (0.069, 0.045),
    "dog": (0.0624, 0.0474),
    "cat": (0.06, 0.0522),
    "michael": (0.057, 0.0363),
    "horse": (0.0559, 0.0179),
    "centaur": (0.052, 0.0261),
}
WEIGHTS = (0.0, 0.01, 0.03, 0.06, 0.1, 0.2)
FUNCTIONS, SPARE = 20, 5


def spectra_of(data: ToscaRemeshed, names: list[str], scalar: str, weight: float) -> list[Spectrum]:
    """Spectra of some poses in one metric."""
    surfaces = [data.read(name) for name in names]
    return [distance_spectrum(s, FUNCTIONS + SPARE, lifted_metric(s, scalar, weight)) for s in surfaces]


def mean_distances(data: ToscaRemeshed, names: list[str], spectra: list[Spectrum]) -> tuple[float, float]:
    """C_XY in both normalisations, in the mean over all pairs of poses."""
    found = []
    for (i, x), (j, y) in itertools.combinations(enumerate(names), 2):
        truth = data.truth(x, y).images
        pairs = [
            commutative_eigenspectra(spectra[i], spectra[j], truth, FUNCTIONS, normalization)
            for normalization in ("area", "vertices")
        ]
        found.append([pair.c_xy for pair in pairs])
    area, vertices = np.mean(found, axis=0)
    return float(area), float(vertices)


def main() -> None:
    """Print one row for each category, scalar and weight."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=3, help="poses of each category, evenly spread")
    parser.add_argument("--categories", nargs="*", default=list(PRINTED))
    parser.add_argument("--scalars", nargs="*", default=["mean_curvature"])
    parser.add_argument("--weights", nargs="*", type=float, default=list(WEIGHTS))
    options = parser.parse_args()
    data = ToscaRemeshed(Path(os.environ["QGEO_DATA"]) / "tosca")
    print("| category | scalar | weight | C_XY (area) | C_XY (vertices) | D(S) | printed |")
    print("|---|---|---:|---:|---:|---:|---:|", flush=True)
    for category in options.categories:
        every = data.names(category)
        chosen = np.unique(np.linspace(0, len(every) - 1, min(options.poses, len(every))).round().astype(int))
        names = [every[i] for i in chosen]
        maps = [data.truth(names[0], name).images for name in names]
        done = set()
        for scalar, weight in itertools.product(options.scalars, options.weights):
            if weight == 0 and done:
                continue  # no scalar enters
            done.add(weight)
            spectra = spectra_of(data, names, scalar, weight)
            area, vertices = mean_distances(data, names, spectra)
            d_s = compatibility_of_spectra(spectra, maps, k=FUNCTIONS).d_s
            printed = PRINTED.get(category, (float("nan"),) * 2)
            value = f"{printed[0 if weight == 0 else 1]:.4f}"
            label = "none" if weight == 0 else scalar
            print(
                f"| {category} | {label} | {weight:g} | {area:.3f} | {vertices:.4f} | {d_s:.3f} | {value} |", flush=True
            )


if __name__ == "__main__":
    main()
