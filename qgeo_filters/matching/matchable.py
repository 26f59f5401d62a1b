"""Whether a shape can be matched, and two with sizes kept: what cannot is refused before anything is computed."""

from __future__ import annotations

from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.spectral.spectrum import check_areas
from qgeo_filters.surface import Surface


def check_matchable(surface: Surface, parameters: MatchingParameters | None = None, *, repaired: bool = False) -> None:
    """Raise `MeshError`, saying why, for a surface that cannot be matched."""
    surface.require_manifold("matching")
    surface.require_connected("matching")
    if not surface.is_oriented and repaired:
        raise MeshError(
            "matching tells a shape from its mirror image by the side of the surface that is out, but it is one-sided "
            f"(as a Moebius band, or a scan with wrong bridges; Euler characteristic {surface.euler_characteristic}), "
            "which no turning of faces mends: repair='wrap' takes a closed surface around it"
        )
    if not surface.is_oriented:
        raise MeshError(
            "matching tells a shape from its mirror image by the orientation of its faces, but neighbouring faces "
            "disagree; repair=True turns them, unless the surface is one-sided"
        )
    check_areas(surface.vertex_areas)
    least = (parameters or MatchingParameters()).minimum_vertices
    if surface.n_vertices < least:
        raise MeshError(f"matching needs at least {least} vertices, got {surface.n_vertices}")


def check_same_size(x: Surface, y: Surface, ratio: float = MatchingParameters.same_area) -> None:
    """Raise `ParameterError` for shapes whose areas differ by more than this ratio."""
    if not 1 / ratio <= x.area / y.area <= ratio:
        raise ParameterError(
            f"the areas of X and Y are {x.area:.6g} and {y.area:.6g}: shapes of different size are compared with "
            "normalize=True"
        )
