"""Five poses of a small creature, and parameters with which a pair of them is matched in a fraction of a second."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from shapes import bent, creature

import qgeo_filters as qg
from qgeo_filters.matching.registration_stages import Stage

_STAGES = (Stage((20,), 0.05, 0.03, 0.05, iterations=2),)
#: A single metric, few hypotheses, a registration of one step; whatever comes first is taken.
QUICK = replace(
    qg.MatchingParameters(),
    curvature_weights=(0.15,),
    distance_functions=20,
    laplacian_functions=30,
    preview_count=2,
    quick_preview_count=2,
    quick_margin=0.0,
    quick_alike=0.0,
    quick_relief=-1.0,
    quick_distortion=9.0,
    sign_beam=16,
    sign_survivors=4,
    sign_hypotheses=3,
    extrema_beam=20,
    extrema_matchings=4,
    extrema_hypotheses=1,
    preview=_STAGES,
    coarse_to_fine=_STAGES,
    hks_guided=_STAGES,
    final=_STAGES,
    part_rounds=0,
)


def poses(count: int = 5) -> dict[str, qg.Surface]:
    """Poses p0, p1, ... of 162 vertices each, bent more and more."""
    vertices, faces = creature(level=2)
    return {f"p{number}": qg.Surface(bent(vertices.copy(), 0.2 * number), faces) for number in range(count)}


def by_number(name: str) -> str:
    """Group of a pose: the first two are "low"."""
    return "low" if name < "p2" else "high"


def written(folder: Path, count: int = 5) -> Path:
    """Folder with the poses as PLY files."""
    folder.mkdir(exist_ok=True)
    for name, surface in poses(count).items():
        surface.write(folder / f"{name}.ply")
    return folder
