"""Every number on which reflections alone depend, each with where its value was measured, see `matching.parameters`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReflectionParameters:
    """What the choice of a reflection goes by where that of a map does not: limbs left in place, parts turned."""

    #: ``preview_ratio`` of reflections: one that leaves limbs in place keeps distances better than the right one does
    #: in an uneven pose, and is dropped for it only if that one is tried (symmetry: victoria2 needs 2.0).
    reflection_preview_ratio: float = 2.5
    #: Hypotheses that keep the orientation are not grown: those below this, over so many triangles (symmetry: 200 of
    #: 552, every third shape, all of which were at -.18 or below once they had grown).
    rough_orientation: float = -0.3
    rough_triangles: int = 100
    #: Reflections whose images are nearer than this in the mean after the preview end as the same one: the cheaper goes
    #: on (symmetry: .011 and less, or .033 and more).
    reflection_same: float = 0.02
    #: From this agreement on heat kernels need not lead a reflection once more: where they did, images moved by .009 at
    #: most in the mean, without them the same (symmetry; cat9 has .91 and moved by .07).
    reflection_closely_alike: float = 0.98
    #: Reflections that relate parts less alike than this, front to back, are none (symmetry).
    reflection_alike: float = 0.9
    #: A reflection that leaves limbs in place which another exchanges is none, unless that one costs this many times as
    #: much or agrees less than this (symmetry: cat9, michael18).
    fixed_limbs_cost: float = 30.0
    fixed_limbs_alike: float = 0.96
    #: Images this far apart are different; the least area where they are; there one map moves points by less than the
    #: third, the other by more than the fourth; least share that the other takes to itself (symmetry).
    limb_different: float = 0.2
    limb_area: float = 0.02
    limb_stays: float = 0.15
    limb_goes: float = 0.3
    limb_exchanged: float = 0.7
    #: Rounds in which parts of the best reflection are turned, as long as it costs no more than this ratio of the least
    #: cost, parts at a time, and the mean distance between images up to which a part has turned back (symmetry).
    part_rounds: int = 3
    part_patience: float = 1.5
    part_count: int = 2
    part_turned_back: float = 0.01
    #: A part is what lies this near to an extremum; the map is bent around it, up to this many times that (symmetry).
    part_radius: float = 0.2
    part_reach: float = 1.5
    #: Fewest vertices of a part, about as many as are aligned, iterations of closest points, weight of normals.
    part_fewest: int = 20
    part_aligned: int = 150
    part_iterations: int = 12
    part_normals: float = 0.1
    #: Alignments that leave less than this of the misfit and move the part by more than this (symmetry).
    part_better: float = 0.8
    part_moved: float = 0.04
