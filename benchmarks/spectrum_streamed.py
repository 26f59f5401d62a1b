"""Spectrum of a matrix that is never stored: error after each pass against the stored one, time and memory.

    python benchmarks/spectrum_streamed.py MESH [WEIGHT] [PASSES] [LANDMARKS] [--json FILE]

MESH is a file, or a number of vertices for the closed irregular mesh of the other benchmarks. Up to 20000 vertices the
reference is the spectrum of the stored matrix; beyond, what the last pass found, whose own error the bound limits.

The bound is Davis and Kahan's for the first 20: residuals over the gap between the 20th and the 21st eigenvalue in
size, which nothing outside can be nearer than. It holds for the Ritz vectors; what is returned is one step better.
"""

from __future__ import annotations

import resource
import time
from pathlib import Path

import numpy as np
from geodesics_common import blob
from record import Record, recorded

from qgeo_filters.compilation import warmup
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.spectral.block_krylov import spectrum_by_pass
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface

_K = 20


def main(record: Record, mesh: str, weight: float = 0.03, passes: int = 3, landmarks: int = 1000) -> None:
    """Print one row for each pass."""
    warmup()
    surface = Surface(*blob(int(mesh))) if mesh.isdigit() else Surface.read(mesh)
    n = surface.n_vertices
    found, seconds = [], []
    start = time.process_time()
    metric = lifted_metric(surface, curvature_weight=weight)
    by_pass = spectrum_by_pass(surface, _K + 1, metric, landmarks=landmarks, passes=passes)
    for spectrum in by_pass:
        found.append(spectrum)
        seconds.append(time.process_time() - start)
        print(
            f"pass {len(found)}: {seconds[-1]:.0f} CPU s, residuals up to {_residuals(spectrum).max():.2g}", flush=True
        )
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    stored = n <= 20000
    reference = distance_spectrum(surface, _K + 1, metric, landmarks=None) if stored else found[-1]
    name = "closed, irregular" if mesh.isdigit() else Path(mesh).stem
    columns = ("passes", "sine, 20", "sine, 10", "eigenvalues", "residuals", "bound on the sine", "CPU s")
    table = record.table(f"{name}, {n} vertices, {landmarks} landmarks, weight {weight}", *columns)
    for count, (spectrum, cpu) in enumerate(zip(found, seconds, strict=True), 1):
        residuals = _residuals(spectrum)
        measured = ["-"] * 3
        if spectrum is not reference:
            sines = [
                subspace_sine(spectrum.eigenfunctions[:, :j], reference.eigenfunctions[:, :j], surface.vertex_areas)
                for j in (_K, _K // 2)
            ]
            error = np.abs(spectrum.eigenvalues / reference.eigenvalues - 1)[:_K].max()
            measured = [f"{one:.1e}" for one in (*sines, error)]
        size = np.abs(spectrum.eigenvalues)
        bound = np.linalg.norm(residuals * size[:_K]) / (size[_K - 1] - size[_K])
        table.row(count, *measured, f"{residuals.max():.1e}", f"{bound:.1e}", f"{cpu:.0f}")
    size = np.abs(reference.eigenvalues)
    record.note(
        f"From the 20th to the 21st eigenvalue: {100 * (1 - size[_K] / size[_K - 1]):.1f} %. "
        f"Peak memory of the passes: {peak:.2f} GB; the matrix would take {n**2 * 4 / 2**30:.1f} GB."
    )


def _residuals(spectrum: Spectrum) -> np.ndarray:
    """Relative residuals of the first 20 eigenpairs."""
    assert spectrum.residuals is not None
    return spectrum.residuals[:_K]


if __name__ == "__main__":
    with recorded() as record:
        arguments = record.arguments
        main(record, arguments[0], *map(float, arguments[1:2]), *map(int, arguments[2:]))
