"""Every number that a map depends on, each with where its value was measured.

Those of one shape are in `shape_parameters`, those of reflections alone in `reflection_parameters`.
"Tuning" is TOSCA's cat, dog and centaur (remeshed poses, `benchmarks/matching.py`), "symmetry" their shapes
(`benchmarks/symmetry.py`), "controls" the bodies with and without a left and right of
`benchmarks/matching_controls.py`, "choice" `benchmarks/matching_choice.py`. Lengths are fractions of sqrt(area), areas
and times of heat fractions of the area. `dataclasses.replace(MatchingParameters(), preview_count=6)` varies one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from qgeo_filters.matching.reflection_parameters import ReflectionParameters
from qgeo_filters.matching.registration_stages import COARSE_TO_FINE, FINAL, GROWN_FINAL, HKS_GUIDED, PREVIEW, Stages
from qgeo_filters.matching.shape_parameters import ShapeParameters


@dataclass(frozen=True)
class MatchingParameters(ShapeParameters, ReflectionParameters):
    """What `match` and `self_symmetry` go by; the defaults are what every figure of the README was measured with.

    Examples
    --------
    >>> from dataclasses import replace
    >>> default = qg.MatchingParameters()
    >>> default.search_vertices, default.registration_vertices
    (2000, 4000)
    >>> replace(default, search_vertices=1000).search_vertices
    1000
    """

    # -- the first attempt ------------------------------------------------------------------------------------
    #: Whether maps are sought in the last metric only, without mirrored ones and with fewer points, at first: all the
    #: rest follows where that leaves any doubt (benchmarks/README.md, "From coarse to fine").
    quick: bool = True
    quick_preview_count: int = 6
    quick_candidate_points: int = 400
    quick_registration_points: int = 800
    #: It leaves no doubt where the margin, and the agreement of heat kernels and of the relief, are this large, and the
    #: distortion of distances this small. Of all pairs of TOSCA one was wrong and sure, at an agreement of .966
    #: (victoria10-victoria23); of pairs drawn at random the right ones within a category have .972 and more.
    quick_margin: float = 2.0
    quick_alike: float = 0.97
    quick_relief: float = 0.65
    quick_distortion: float = 0.1
    #: Where a map of the other handedness distorts distances by less than this times as much, the mirrored maps of so
    #: many of them compete, by as many rough reflections of Y: the right one may be among them (SCAPE).
    quick_twins: float = 1.0
    quick_twinned: int = 3
    #: Nor if a map of the other handedness distorts distances by less than this times as much: teeth of a left and of a
    #: right jaw (benchmarks/README.md, "Both hands").
    quick_other_hand: float = 0.8

    # -- which maps are different ----------------------------------------------------------------------------
    #: Mean distance between the images of two maps from which they are different (tuning) ...
    different_mean: float = 0.04
    #: ... or this distance in this share of the points, such as the tip of a limb (tuning).
    different_limb: float = 0.2
    different_share: float = 0.015
    #: Maps that move points by less in the mean are the identity, or it with a limb displaced (symmetry).
    near_identity: float = 0.1
    #: Farthest points between which coarse maps are compared: enough for functions as smooth as the first 20.
    coarse_points: int = 300

    #: Metrics that propose maps, the last ones; all of them by default.
    proposing: int | None = None

    # -- sign search over the eigenfunctions of the distances ------------------------------------------------
    #: Eigenfunctions whose signs are enumerated, and that a hypothesis is grown to (tuning).
    signs_enumerated: int = 8
    signs_grown: int = 20
    #: Neighbouring eigenvalues closer than this, relatively, may come in either order (tuning).
    swap_gap: float = 0.06
    #: Hypotheses that are grown, that survive the checks, the sizes at which these are, and that are kept (tuning).
    sign_beam: int = 256
    sign_survivors: int = 24
    sign_checks: tuple[int, ...] = (10, 13)
    sign_hypotheses: int = 24

    # -- ends of limbs: extrema of the average geodesic distance --------------------------------------------
    #: An extremum exceeds all within this distance; at most so many take part (tuning).
    extrema_radius: float = 0.1
    extrema_count: int = 10
    #: Of reflections: matchings kept while one extremum after another is added, at the end, and as maps (tuning).
    extrema_beam: int = 2000
    extrema_matchings: int = 100
    extrema_hypotheses: int = 6
    #: Fewest matched extrema that tell points apart.
    extrema_fewest: int = 4
    #: Cost of leaving one unmatched, and the most that one pair of distances may cost (tuning).
    extrema_unmatched: float = 0.24
    extrema_worst: float = 0.5

    # -- matchings of ends of limbs by the symmetries, where shapes are hardly isometric ---------------------------
    #: Of extrema nearer to each other than this one is the end of a limb (fingers of one hand); at most so many.
    limb_ends_apart: float = 0.4
    limb_ends: int = 6
    #: Ends this near to the mirror image of one are that.
    limb_end_mirrored: float = 0.2
    limb_hypotheses: int = 16
    #: Of those the ones that are taken to the end: at most so many, within this ratio of the least cost in the preview.
    limb_close_count: int = 4
    limb_close_ratio: float = 6.0
    #: Of those from Y to X so many are turned round.
    limb_turned_count: int = 2
    #: Margin from which on a map is clear without, of near-isometric shapes (a gorilla onto a woman: wrong at 3.1).
    limb_margin: float = 3.0

    # -- how unlike the surroundings are of what a map relates, in all rankings before maps are registered ---------
    #: Disagreement of heat kernels and of the relief that is added to both, that which counts as usual, and the
    #: power of the factor (people and gorillas, dogs; benchmarks/README.md, "What lost the right map").
    least_unlike: float = 0.01
    usually_unlike: float = 0.1
    unlike_counts: float = 0.75

    # -- candidates ------------------------------------------------------------------------------------------
    #: Maps that distort distances by more than this times the best are not worth growing (tuning).
    candidate_ratio: float = 2.0
    #: Distortion below which the next ones count as well: a shape that turns onto itself has many as good as the
    #: identity, but for the rounding to farthest points (controls: sphere, torus, ellipsoid).
    candidate_floor: float = 0.02
    #: Added to the bounds on ratios of distortion, for maps that hardly distort.
    ratio_slack: float = 0.01
    #: Farthest points that candidates map, enough for smooth functions, and triangles that tell the orientation.
    candidate_points: int = 800
    candidate_triangles: int = 400
    #: Maps whose orientation is nearer to 0 turn much of the surface over: the best right ones of sixteen tuning
    #: pairs have .38 and more.
    one_sided: float = 0.15
    #: Y is the mirror image of something asymmetric if reversing maps distort less than this times the keeping ones.
    mirror_image_ratio: float = 0.5
    #: Or if the best of the others costs this many times as much as the best of them.
    mirror_image_cost: float = 1.3
    #: Where no map that keeps the orientation was proposed, one by a rough reflection does not compete, and nothing is
    #: sure, if it keeps distances to this: right maps between poses do no better (a wolf without a leg has .013,
    #: bodies without a symmetry .027 to .054).
    nearly_symmetric: float = 0.03

    # -- spectral upsampling of candidates -------------------------------------------------------------------
    #: Farthest points and step of the growth from 20 eigenfunctions of the distances on (tuning: as good as all).
    zoomout_points: int = 800
    zoomout_start: int = 20
    zoomout_step: int = 10
    #: Laplacian eigenfunctions that carry a map by landmarks, or by ends of limbs, to vertices (tuning).
    laplacian_lift: int = 20

    # -- registration (smooth shells) ------------------------------------------------------------------------
    #: Best on the tuning categories (benchmarks/README.md, "Where the error of the cats comes from").
    preview: Stages = PREVIEW
    coarse_to_fine: Stages = COARSE_TO_FINE
    hks_guided: Stages = HKS_GUIDED
    final: Stages = FINAL
    #: Straight from the true places of seven merged surfaces this ends at .044, the whole of ``final`` at .063.
    grown_final: Stages = GROWN_FINAL
    #: Matchings at each size, and iterations of the very first deformation (tuning).
    matchings: int = 2
    first_iterations: int = 8
    #: How often rotations are averaged over neighbours at the first size: of a stage that untwists, of another.
    wide_rotations: int = 30
    narrow_rotations: int = 3
    #: Farthest points that are matched before all vertices are.
    registration_points: int = 1500

    # -- which contenders are tried, and what they cost ------------------------------------------------------
    #: Contenders that are previewed, and how much more than the best they may distort distances (tuning).
    preview_count: int = 10
    preview_ratio: float = 1.7
    #: An edge is torn if its ends are mapped this many mean edges of X apart (tuning), and more than so many of Y,
    #: which is what a right map onto a coarser Y may do (a sphere of 2562 vertices onto one of 162).
    torn_edges: float = 3.0
    torn_edges_of_y: float = 2.0
    #: Shares of torn edges and folded triangles, strains, distortions and disagreements below these do not tell maps
    #: apart: the noise of right maps (tuning).
    least_torn: float = 1e-3
    least_folded: float = 5e-4
    least_strain: float = 1e-3
    least_distortion: float = 1e-4
    least_hks_gap: float = 5e-3
    least_curvature_gap: float = 5e-3
    #: Powers in the cost of maps that have settled: of torn and folded shares and of heat kernels, of the distortion,
    #: of the relief, of curvature, and of heat kernels after least (fitted to right and wrong contenders of 143 pairs
    #: of all kinds, that of the relief to those of 77; benchmarks/README.md, "What lost the right map").
    end_powers: tuple[float, float, float, float, float] = (0.5, 0.25, 3.0, 1.0, 1.0)
    #: The same for reflections, whose other bounds were tuned with these (symmetry).
    reflection_end_powers: tuple[float, float, float, float, float] = (1.0, 0.5, 2.0, 0.0, 0.0)
    #: Where heat kernels lead a map elsewhere and all but they say that it is this many times as bad, they led it
    #: astray (47 contenders of 23 pairs: 10 of 11 that came nearer to the truth have 1.06 and less, 34 of 36 that went
    #: away from it, such as tails on hind legs, 1.54 and more).
    led_astray: float = 1.3
    #: Of the times of heat the last ones are compared: the first varies between poses (tuning).
    hks_compared_from: int = 1

    # -- the decision ----------------------------------------------------------------------------------------
    #: Contenders that are registered to the end: at most so many, within this ratio of the least cost (choice) ...
    close_count: int = 4
    close_ratio: float = 6.0
    #: ... and of those whose images are this near in the mean at most so many (choice).
    kin_distance: float = 0.1
    kin_count: int = 2
    #: Then those within this ratio of the best in the preview, where costs are rough, too, and those within that one
    #: along which the relief agrees clearly better: a chest on a back, at 6.4 (SHREC'19). At most so many, so often.
    doubtful_ratio: float = 2.0
    doubtful_contrary_ratio: float = 30.0
    doubtful_count: int = 3
    doubtful_rounds: int = 2

    # -- hints (landmarks and labels) ------------------------------------------------------------------------
    #: A landmark may be this far off, and a border of labels: a few edges at 5000 vertices.
    hint_softness: float = 0.05
    #: What lies this near to a landmark, or to a labelled part, should go where that goes: a paw.
    hint_surroundings: float = 0.1
    #: Disagreement, summed over the hints, that makes a map twice as dear.
    hint_scale: float = 0.02
    #: Known parts whose distances tell points apart.
    hints_that_locate: int = 3
    #: In the registration distances from landmarks and labelled parts count as positions do, times this ...
    hint_weight: float = 1.0
    #: ... but saturate at this: a hint is silent far away.
    hint_reach: float = 0.25
    #: ... sooner where one shape has grown together (kid_3 from the true places: .137 at .25, .067 at .1, .043 at .05,
    #: .052 without hints).
    grown_hint_reach: float = 0.05
    #: From here on a hint contradicts the map.
    hint_contradicts: float = 0.1

    # -- what a result says ----------------------------------------------------------------------------------
    #: Points to which distances are compared for the distortion.
    probes: int = 200
    #: The runner-up must cost this many times as much (tuning: right maps 1.29 and more; a sphere has many at 1).
    margin: float = 1.3
    #: A map along which the relief disagrees by less than this times as much must cost this many times as much: a chest
    #: on a back can strain, tear and fold less than where it belongs (along settled wrong maps the relief disagrees
    #: 1.21 times as much as along the right one and more; benchmarks, "By what right and wrong maps are told").
    contrary_relief: float = 0.88
    contrary_margin: float = 2.0
    #: The best map of the other handedness must cost this many times as much.
    clear_hand: float = 1.3
    #: Mean distortion up to which shapes are near-isometric (tuning .01 to .04; different animals .2).
    near_isometric: float = 0.12
    #: From this distortion on the runner-up must cost this many times as much: a woman's arms go onto a gorilla's legs
    #: at .06 to .12 and a margin of 1.1 to 1.7 (benchmarks/README.md, "All sets").
    hardly_isometric: float = 0.06
    hardly_isometric_margin: float = 2.0
    #: Where heat kernels agree as those of poses of one shape do, from this distortion on only (SCAPE: right at .067).
    poses_alike: float = 0.95
    poses_isometric: float = 0.1
    #: Agreement of heat kernels: poses of TOSCA have .96 to 1, right maps of animals of different species .88 and more,
    #: different creatures .57 to .67.
    match_alike: float = 0.87
    #: The same where another map was found, and costs this many times as much (right maps of teeth .84 and 6.3).
    clear_alike: float = 0.82
    clear_margin: float = 5.0
    #: The same where one shape has handles that the other lacks: heat flows where surfaces have grown together (right
    #: maps of two children with a hand on the body .85, wrong ones .68 and less).
    grown_alike: float = 0.8
    #: Margin and agreement from which on such a map is clear enough not to be sought among places where distances may
    #: be shorter (wrong maps of michael's merged poses have up to 3.3 and .86, right ones of two children 3 and .92, 13
    #: and .87).
    grown_margin: float = 2.0
    grown_clear: float = 0.9
    #: A finished map whose orientation is below this did not settle on one side (tuning).
    settled_orientation: float = 0.3
    #: Ratio of areas up to which shapes count as of one size, for ``normalize=False``.
    same_area: float = 1.1
    #: A reflection that distorts distances by no more than this, but whose heat kernels agree by less, is sought once
    #: more between the surfaces at which maps are finished (symmetry: cat9; right ones have .973 and more).
    doubtful_reflection_distortion: float = 0.12
    doubtful_reflection_alike: float = 0.972
    #: Mean distance between images from which two reflections are different ones (symmetry).
    reflection_apart: float = 0.1
    #: Agreement of mirror points: posed animals have .96 to 1, random smooth blobs .91 to .96 under their best
    #: reflection, but for those that are nearly symmetric (symmetry, controls).
    symmetry_alike: float = 0.96
    #: A pose that changes the surroundings changes distances, too: how much less than 1 the agreement may be, as a
    #: multiple of the distortion (posed animals at most .5, the most alike blobs 1.4 and 1.6); or this (controls).
    symmetry_gap: float = 1.0
    symmetry_least_gap: float = 0.015

    def first_attempt(self) -> MatchingParameters:
        """The parameters of the quick search."""
        return replace(
            self,
            proposing=1,
            preview_count=self.quick_preview_count,
            candidate_points=self.quick_candidate_points,
            zoomout_points=self.quick_candidate_points,
            registration_points=self.quick_registration_points,
        )
