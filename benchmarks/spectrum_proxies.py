"""What a proxy and landmarks miss of a spectrum, beside that of all distances: subspace sine, eigenvalues, CPU seconds.

    python benchmarks/spectrum_proxies.py MESH [--vertices 10000] [--json FILE]

The mesh is decimated first, so that the matrix of its distances fits into memory: that at accuracy .001 is what
everything is compared with, in the surface's own metric and in the lifted one. CPU seconds have the distances in them.
"Eigenvalues" is as in ``spectrum_landmarks.py``.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator

from record import Record, recorded
from spectrum_landmarks import largest_error

import qgeo_filters as qg
from qgeo_filters.decimation import decimated
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.geodesics.solver import GeodesicSolver
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.landmarks import landmark_operator
from qgeo_filters.spectral.proxies import interpolation_over_proxy
from qgeo_filters.spectral.proxy_spectrum import proxy_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, spectrum_of_matrix

K, SPARE, LANDMARKS = 20, 10, 1000
#: Of the proxy that is interpolated over; of those that stand for the surface.
OVER, PROXIES = 3000, (5000, 2500)


def over_a_proxy(surface: qg.Surface, metric: LiftedMetric) -> Spectrum:
    """Landmarks, interpolated over a proxy, as on surfaces that are too large for the factorisation."""
    points, *between = interpolation_over_proxy(metric, LANDMARKS, OVER)
    rows = GeodesicSolver(surface, metric).single_distances(points)
    return spectrum_of_matrix(
        landmark_operator(metric, points, rows, interpolation=between), surface.vertex_areas, K + SPARE
    )


def ways(surface: qg.Surface, metric: LiftedMetric) -> Iterator[tuple[str, Callable[[], Spectrum]]]:
    """Name of a way to the spectrum, and the way."""

    def of_all(accuracy: float) -> Spectrum:
        return qg.distance_spectrum(surface, K + SPARE, metric, landmarks=None, accuracy=accuracy)

    def of_some(accuracy: float) -> Spectrum:
        return qg.landmark_spectrum(surface, K + SPARE, metric, landmarks=LANDMARKS, accuracy=accuracy)

    yield "all distances", lambda: of_all(1e-3)
    yield "all distances, accuracy .01", lambda: of_all(1e-2)
    yield f"{LANDMARKS} landmarks", lambda: of_some(1e-3)
    yield f"{LANDMARKS} landmarks, accuracy .01", lambda: of_some(1e-2)
    yield f"{LANDMARKS} landmarks, interpolated over a proxy of {OVER}", lambda: over_a_proxy(surface, metric)
    for vertices in PROXIES:
        yield (
            f"a proxy of {vertices} vertices",
            lambda n=vertices: proxy_spectrum(surface, K + SPARE, metric, vertices=n),
        )


def main(record: Record) -> None:
    """Print a table for each metric."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("--vertices", type=int, default=10_000)
    arguments = parser.parse_args(record.arguments)
    qg.warmup()
    surface = decimated(qg.Surface.read(arguments.mesh), arguments.vertices).surface
    areas = surface.vertex_areas
    for weight in (0.0, 0.03):
        metric = qg.lifted_metric(surface, curvature_weight=weight)
        title = "the lifted metric, weight .03" if weight else "the surface's metric"
        table = record.table(title, "", "sine, 20", "sine, 10", "eigenvalues", "CPU s", align="lrrrr")
        for name, way in ways(surface, metric):
            start = time.process_time()
            found = way()
            seconds = f"{time.process_time() - start:.1f}"
            if name == "all distances":
                full = found
                table.row(name, "", "", "", seconds)
                continue
            sines = [subspace_sine(found.eigenfunctions[:, :j], full.eigenfunctions[:, :j], areas) for j in (K, K // 2)]
            error = largest_error(found.eigenvalues, full.eigenvalues[:K])
            table.row(name, *(f"{sine:.4f}" for sine in sines), f"{error:.1e}", seconds)
    record.note(f"{surface.n_vertices} vertices.")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
