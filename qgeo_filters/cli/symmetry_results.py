"""What ``qgeo symmetry`` and ``qgeo demo`` say and keep of a symmetry map and of the measure of eq. (3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from qgeo_filters.cli.options import ALL_DISTANCES
from qgeo_filters.matching.symmetry_measure import epsilon_bound, symmetry_epsilon, symmetry_regions, symmetry_sum

if TYPE_CHECKING:
    from qgeo_filters.matching.symmetry_measure import Reading
    from qgeo_filters.matching.symmetry_result import Symmetry
    from qgeo_filters.spectral.spectrum import Spectrum

_PAIRS = 2000


def symmetry_results(found: Symmetry, spectrum: Spectrum, k0: int, reading: Reading = "absolute") -> dict[str, Any]:
    """Numbers of a symmetry map for result.json; None where they have no meaning because none was found."""
    return {
        "found": found.found,
        "reason": found.reason,
        "score": found.score if found.found else None,
        "orientation": found.orientation if found.found else None,
        "vertices_on_the_axis": int(found.fixed.sum()) if found.found else None,
        "plane": None
        if found.plane is None
        else {
            "normal": found.plane.normal.tolist(),
            "origin": found.plane.origin.tolist(),
            "deviation": found.plane.deviation,
        },
        # Not the involution: vertices that it pairs with themselves would flatter the measure.
        "epsilon_of_mirror_images": symmetry_epsilon(spectrum, found.nearest, k0, reading) if found.found else None,
    }


def curve_arrays(found: Symmetry) -> dict[str, Any]:
    """The axis of a symmetry for result.npz."""
    return {
        "curve": np.concatenate([np.zeros((0, 3)), *found.curve]),
        "curve_lengths": np.array([len(line) for line in found.curve], dtype=np.int64),
    }


def symmetry_arrays(found: Symmetry) -> dict[str, Any]:
    """Arrays of a symmetry map for result.npz."""
    return {
        "found": np.bool_(found.found),
        "symmetry": found.p2p,
        "nearest": found.nearest,
        "side": found.side.astype(np.int64),
        "asymmetry": found.asymmetry,
    }


def symmetry_attributes(arrays: dict[str, Any], found: Symmetry | None) -> dict[str, Any]:
    """Attributes for the mesh: those of eq. (3), and those of the map where one was found."""
    attributes = {"qgeo_symmetry_sum": arrays["symmetry_sum"], "qgeo_symmetry_region": arrays["regions"]}
    if found is not None and found.found:
        attributes |= {
            "qgeo_symmetry": found.p2p.astype(np.int32),
            "qgeo_side": found.side.astype(np.int32),
            "qgeo_asymmetry": found.asymmetry,
        }
    return attributes


def symmetry_measure(
    spectrum: Spectrum,
    matrix: np.ndarray | None,
    k0: int,
    n_regions: int | None = None,
    epsilon: float | None = None,
    reading: Reading = "absolute",
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers and arrays of eq. (3), its bound checked on random pairs of vertices where the matrix is at hand."""
    values = symmetry_sum(spectrum, k0, reading)
    regions = symmetry_regions(spectrum, n_regions, epsilon, k0, reading)
    share = None
    if matrix is not None:
        one, other = np.random.default_rng(0).integers(0, spectrum.n_vertices, (2, _PAIRS))
        one, other = one[one != other], other[one != other]
        bound = epsilon_bound(spectrum, matrix, one, other, k0)
        share = float((np.abs(values[one] - values[other]) / bound).max())
    results = {
        "k0": k0,
        "spectrum_from": spectrum.approximation or ALL_DISTANCES,
        "epsilon_of_all_pairs": symmetry_epsilon(spectrum, None, k0, reading),
        "regions": len(np.unique(regions)),
        "largest_share_of_the_bound": share,
    }
    return results, {"symmetry_sum": values, "regions": regions}
