"""Spectrum of a matrix that is never stored: error against the stored one, time and memory.

    python benchmarks/spectrum_streamed.py MESH [LANDMARKS]

The reference is the full spectrum of the stored matrix for up to 12000 vertices. Beyond, two passes are timed and
compared with the landmarks' own spectrum, which they started from.
"""

from __future__ import annotations

import resource
import sys
import time

from geodesics_common import machine

from qgeo_filters.geodesics.lifting import lifted_metric
from qgeo_filters.geodesics.warmup import warmup
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.landmarks import landmark_spectrum
from qgeo_filters.spectral.streaming import streamed_spectrum
from qgeo_filters.surface import Surface


def main(path: str, landmarks: int = 500, k: int = 20) -> None:
    """Print one row for each number of passes."""
    warmup()
    surface = Surface.read(path)
    print(f"Machine: {machine()}. {surface.n_vertices} vertices, {landmarks} landmarks, top {k}, weight .03.\n")
    print(
        "| passes | top-20 subspace sine | largest eigenvalue error, relative | CPU s | wall s |\n|---|---|---|---|---|"
    )
    small = surface.n_vertices <= 12000
    if small:
        reference = distance_spectrum(surface, k, lifted_metric(surface))
    else:
        reference = landmark_spectrum(surface, k, lifted_metric(surface), landmarks)
    for passes in (1, 2, 3) if small else (2,):
        metric = lifted_metric(surface)
        cpu, wall = time.process_time(), time.perf_counter()
        found = streamed_spectrum(surface, k, metric, landmarks=landmarks, passes=passes)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        sine = subspace_sine(found.eigenfunctions, reference.eigenfunctions, surface.vertex_areas)
        error = abs(found.eigenvalues / reference.eigenvalues - 1).max()
        print(f"| {passes} | {sine:.2g} | {error:.2g} | {cpu:.0f} | {wall:.0f} |", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    matrix = surface.n_vertices**2 * 4 / 2**30
    print(f"\nPeak memory of the process: {peak:.2f} GB; the matrix would take {matrix:.1f} GB.")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 500)
