"""Spectra of meshes with something wrong, on the vertices that were given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from qgeo_filters._typing import RepairOption
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface, repaired_by
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.parallel import single_threaded_blas
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_repair, frozen


@single_threaded_blas  # its own threads wait for ours by spinning: twice the CPU time, and no less by the clock
def spectrum_of_mesh(
    surface: SurfaceLike, repair: RepairOption, compute: Callable[[Surface, Repair | None], Spectrum]
) -> Spectrum:
    """What ``compute`` gives for a surface and the repair that it comes from, on the vertices that were given.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    repair : bool, "auto" or "force"
        With "auto" the mesh is repaired if it is not welded, or ``compute`` refuses it as it is.
    compute : callable
    """
    if not checked_repair(repair):
        return compute(as_surface(surface), None)
    refusal = None
    if repair == "auto":
        try:
            given = as_surface(surface)
            if not given.unwelded_vertices.size:
                return compute(given, None)
        except MeshError as error:
            refusal = error
    found = repaired_by(surface, repair)
    if refusal is not None and not found.changed:
        raise refusal
    return spectrum_on_given(compute(found.surface, found), found)


def spectrum_on_given(spectrum: Spectrum, repair: Repair) -> Spectrum:
    """The spectrum of ``repair.surface`` for the vertices of ``repair.given``.

    Returns
    -------
    Spectrum
        Eigenfunctions are NaN and the area 0 where a vertex is gone. Vertices that were joined share the area of the
        one that stands for them, so that eigenfunctions stay orthonormal over those that are left.
    """
    areas = repair.areas_on_given(spectrum.areas)
    return replace(spectrum, eigenfunctions=frozen(repair.map_back(spectrum.eigenfunctions)), areas=frozen(areas))
