"""Every number that a prepared shape depends on, each with where its value was measured, see `matching.parameters`."""

from __future__ import annotations

from dataclasses import dataclass, fields

from qgeo_filters.defaults import CURVATURE_WEIGHT


@dataclass(frozen=True)
class ShapeParameters:
    """What a `PreparedShape` goes by; two shapes must have been prepared with the same to be matched.

    Lengths are fractions of sqrt(area), areas and times of heat fractions of the area.
    """

    #: Weights of mean curvature in the metrics that propose maps: the surface's own and two lifted ones, whose
    #: proposals differ (tuning). The last is that of the paper's functions.
    curvature_weights: tuple[float, ...] = (0.0, 0.03, CURVATURE_WEIGHT)
    #: Vertices of the proxies between which maps are sought, and of those at which they are finished; from there they
    #: are carried to all vertices (benchmarks/README.md, "From coarse to fine").
    search_vertices: int = 2000
    registration_vertices: int = 4000
    #: Times of heat: a paw, a limb and a half of the shape (tuning).
    hks_times: tuple[float, ...] = (0.003, 0.01, 0.03)
    #: Time of heat over which mean curvature is smoothed, a nose (choice), and of that over which the relief rises: a
    #: breast or a muzzle (tuning: of .0003 to .004 the one that tells right maps of 50 pairs from wrong ones best).
    curvature_time: float = 0.0003
    relief_time: float = 0.002
    #: Curvatures beyond this, in 1 / sqrt(area), are those of fingers, ears and noise (as before).
    curvature_limit: float = 30.0
    #: Eigenfunctions of the distances and of the Laplacian: more did not help (tuning).
    distance_functions: int = 60
    laplacian_functions: int = 200
    #: Residual of the last of them, relative; the first 20 come out as exact as float32 distances.
    eigen_tolerance: float = 1e-3
    #: Eigenfunctions that a result reports: the paper's k0.
    spectrum_functions: int = 20
    #: Farthest points; those whose distances to all vertices are kept (memory is this times n).
    fps_count: int = 2000
    fps_rows: int = 800
    #: Fewest vertices of a shape: the search needs more points than eigenfunctions.
    minimum_vertices: int = 60

    def of_shape(self) -> dict[str, object]:
        """The parameters that a `PreparedShape` depends on, by name."""
        return {field.name: getattr(self, field.name) for field in fields(ShapeParameters)}
