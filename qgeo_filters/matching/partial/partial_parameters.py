"""Every number that a partial match depends on, each with where its value was measured.

"Cuts" are the tuning cases of `benchmarks/matching_partial.py`: poses of TOSCA cut by planes, and four of the eight
cuts of people (PFARM). Lengths are fractions of sqrt(area of Y), areas fractions of that area.
"""

from __future__ import annotations

from dataclasses import dataclass

from qgeo_filters.matching.registration_stages import Stage, Stages

#: From a coarse map of farthest points to all vertices: limbs follow from the body that they grow on, then details.
PART_STAGES: Stages = (
    Stage((20, 30, 45), 0.12, 0.06, 0.03, iterations=6, untwist=True),
    Stage((30, 45, 65, 90, 120, 120), 0.05, 0.015, 0.05),
)
#: Once more from where that led, stiffer and slower: without what is beyond the rim a part slides to its place in many
#: small steps.
PART_SETTLING: Stages = (
    PART_STAGES[0],
    Stage((30, 30, 45, 45, 65, 65, 90, 90, 120, 120), 0.08, 0.03, 0.05),
    Stage((120, 120), 0.05, 0.015, 0.05),
)


@dataclass(frozen=True)
class PartialParameters:
    """What ``match(..., partial=True)`` goes by."""

    #: Farthest points of the part and of the whole, with distances to all vertices.
    part_points: int = 250
    whole_points: int = 600
    #: Vertices that are worked on, of proxies of larger shapes, and eigenfunctions of the Laplacian on them.
    part_vertices: int = 1500
    whole_vertices: int = 2000
    eigenfunctions: int = 120
    #: Farthest points of the part that are chosen away from the rim too; the rest spread over the rim as well.
    inner_points: int = 60
    #: Radii of the balls whose areas describe a point.
    ball_radii: tuple[float, ...] = (0.06, 0.1, 0.15, 0.2, 0.27, 0.35, 0.45, 0.6, 0.8, 1.0, 1.25)
    #: Mean curvature is averaged over this length; curvatures beyond the limit (in 1 / length) are noise.
    bulge_radius: float = 0.05
    curvature_limit: float = 30.0
    #: Most that one ball and the curvature can count, and the difference of curvature that counts as one.
    ball_cap: float = 0.5
    bulge_cap: float = 0.3
    bulge_scale: float = 30.0
    #: Most that one pair of distances can count, and the weight of what lies within the bounds.
    pair_cap: float = 0.3
    within_bounds: float = 0.5
    #: Landmarks of the beam search, points of Y that they may go to, and partial hypotheses that are kept.
    landmarks: int = 9
    landmark_targets: int = 300
    beam: int = 8000
    #: Hypotheses of one kind in the beam: whose landmarks go to the same of so many regions of Y.
    kinds: int = 30
    per_kind: int = 1
    #: Weight of descriptors against distances, in the search and for dense maps.
    descriptor_weight: float = 0.5
    dense_descriptor_weight: float = 0.15
    #: Weight of what a user knows against distances, in both; where it is known, that decides.
    hint_weight: float = 2.0
    #: Mean distance of landmarks' images from which hypotheses differ, and how many are made dense.
    different: float = 0.06
    hypotheses: int = 40
    #: Points of a coarse map, rounds in which it is found from itself, and the length over which points count.
    coarse_points: int = 150
    rounds: int = 5
    locality: float = 0.5
    #: Coarse maps that are registered: at most so many, no more than this times as distorted as the best, plus slack.
    registered: int = 8
    registered_ratio: float = 2.0
    registered_slack: float = 0.004
    #: Orientation below which a coarse map reverses that of the surface (right ones of a hand have -.04 to .08).
    keeps_orientation: float = -0.1
    #: Weight of descriptors against distortion where coarse maps are ranked.
    unlikeness_weight: float = 0.1
    #: Mean distance between images up to which two coarse maps are the same, and from which placed parts are
    #: different; farthest points of Y by which it is measured.
    same: float = 0.03
    apart: float = 0.06
    gap_rows: int = 100
    #: The steps of the registration; iterations of its first deformation, the eigenfunctions of its start, and how
    #: often rotations are averaged over neighbours at the first step of a stage.
    stages: Stages = PART_STAGES
    first_iterations: int = 8
    first_functions: int = 20
    wide_rotations: int = 30
    narrow_rotations: int = 3
    #: Of the registered places so many, the cheapest, come to rest by these.
    settled: int = 4
    settling: Stages = PART_SETTLING
    #: Eigenfunctions of the part beyond those of the whole's frequencies: its rim bends them.
    more_functions: int = 10
    #: Distance on Y up to which a match there and back is mutual.
    mutual: float = 0.05
    #: Strains, shares of torn edges and of folded area, costs of descriptors and distortions below these do not tell
    #: maps apart.
    least_strain: float = 0.05
    least_torn: float = 3e-3
    least_folded: float = 1e-2
    least_unlikeness: float = 0.02
    least_distortion: float = 0.01
    #: Powers of these in what a place costs, in this order. The true place strains less than a wrong one, always, but
    #: keeps distances worse, mostly: the search went by them, and poses change them (`matching_partial.py --truth`).
    cost_powers: tuple[float, float, float, float, float] = (1.0, 0.0, 0.5, 1.0, 0.0)

    # -- a surface that has grown together ------------------------------------------------------------------
    #: Distances of each point from where the other surface may have grown together: those that maps are sought with,
    #: and that with which costs are compared.
    shortcut_reaches: tuple[float, ...] = (0.1, 0.2, 0.3)
    compared_reach: float = 0.2
    #: How many times as dear as another place the map of the usual search must be to give way.
    shortcut_reason: float = 1.3
    #: A vertex is uncovered whose match comes back this far from it, and so many mean edges; parts of this area, so
    #: many of them, are tried for each limb: its points are those this near its end, and they go to what lies this near
    #: the part. So many times. (Of three misplaced arms half is uncovered, of all else nothing.)
    uncovered_gap: float = 0.04
    uncovered_edges: float = 1.5
    uncovered_area: float = 0.005
    uncovered_parts: int = 3
    uncovered_reach: float = 0.08
    limb_reach: float = 0.5
    limb_moves: int = 3
    #: Places that are turned by half a turn, the cheapest, and of those turned as many whose limbs are moved.
    turned: int = 2

    # -- size ------------------------------------------------------------------------------------------------
    #: Sizes of a part that are tried where sizes do not count.
    sizes: tuple[float, ...] = (1.0, 0.85, 1.18)
    #: Distances from which on their ratio tells the size, and ratio up to which the size is right.
    least_distance: float = 0.2
    same_size: float = 1.05

    # -- who has a partner -----------------------------------------------------------------------------------
    #: Gap up to which a deformed vertex lies on the other surface, and how far beyond the rim is still on it.
    overlap_gap: float = 0.04
    rim_gap: float = 0.01

    # -- what a result says ----------------------------------------------------------------------------------
    #: Parts of less area look like other parts: hands like feet, a limb like the other.
    least_area: float = 0.1
    #: A shape with more of the area is not tried as a part unless it is said to be one.
    most_area: float = 0.95
    #: Of 100 right maps of cuts nine in ten distort by up to .05, keep the orientation by .52 and more, strain up to
    #: .42, fold up to .007, have surroundings up to .09 unlike, and a margin of 1.2 and more. Of four wrong ones three
    #: have .083 and more of unlike surroundings, the other a margin of 1.04.
    near_isometric: float = 0.06
    settled_orientation: float = 0.3
    settled_strain: float = 0.6
    settled_folded: float = 0.03
    settled_unlikeness: float = 0.08
    margin: float = 1.2
    least_overlap: float = 0.7

    @classmethod
    def of_grown_surfaces(cls) -> PartialParameters:
        """Those for a surface that has grown together, which has no rim that would tell what distances are bounded by.

        By the parameters of cuts one of the four merged children comes out wrong that is nearly right by these (.65
        instead of .15; `benchmarks/topological_noise.py`).
        """
        return cls(
            within_bounds=0.15,
            landmarks=12,
            beam=3000,
            rounds=3,
            registered=6,
            registered_ratio=1.5,
            keeps_orientation=0.1,
            cost_powers=(1.0, 1.0, 1.0, 1.0, 0.5),
        )
