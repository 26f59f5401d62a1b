"""Passages of the registration through the frequencies: for a preview, to where a map's cost tells, and to the end."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Stage:
    """One passage of the registration through the frequencies.

    Attributes
    ----------
    sizes : tuple of int
        Numbers of Laplacian eigenfunctions, increasing.
    first, last : float
        Length below which the deformed shape does not follow the map, at the first and last size.
    normals : float
        Weight of normals against positions.
    iterations : int
        Local-global iterations of the deformation for each matching.
    full : int
        Number of eigenfunctions from which on all vertices are matched, not only farthest points: fewer cannot tell
        vertices apart. At the very end all are, always.
    untwist : bool
        Whether the deformation starts afresh from the low frequencies of the map, limbs shrunk to their axes, with
        rotations of wide neighbourhoods: how a limb is turned about its axis then follows from the body that it
        grows on, not from the map.
    hks : float
        Weight of the heat kernel signatures against positions: they tell the front of a head from its back, which
        hardly strains the neck.
    """

    sizes: tuple[int, ...]
    first: float
    last: float
    normals: float
    iterations: int = 3
    full: int = 1000
    untwist: bool = False
    hks: float = 0.0


Stages = tuple[Stage, ...]

_SIZES = (20, 30, 45, 65, 90, 120, 160, 200)
#: Enough to tell which of several maps is right.
PREVIEW: Stages = (Stage((20, 30, 45), 0.05, 0.035, 0.07, untwist=True),)
#: From a previewed map to where its cost tells.
COARSE_TO_FINE: Stages = (
    Stage((20, 20, 30), 0.15, 0.08, 0.03, iterations=6, untwist=True),
    Stage(_SIZES, 0.05, 0.02, 0.07),
)
#: The same, led by the heat kernels: right where a head had been turned about its axis, sometimes wrong elsewhere, so
#: that the cost must decide.
HKS_GUIDED: Stages = (replace(COARSE_TO_FINE[0], hks=0.5), COARSE_TO_FINE[1])
#: From the map of the coarse shapes to the end, on the fine ones: the second time nearer to the target.
FINAL: Stages = (COARSE_TO_FINE[1], Stage(_SIZES, 0.03, 0.015, 0.03, full=90))
#: The same where one shape has grown together: low frequencies are those that this changes.
GROWN_FINAL: Stages = (replace(FINAL[1], sizes=_SIZES[-3:]),)
