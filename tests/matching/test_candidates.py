"""Coarse maps, their measures and their mirrored twins."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from shapes import bent, limbed

from qgeo_filters.matching.initialization.candidates import Candidate, candidates, mapped_points, mirrored_map
from qgeo_filters.matching.maps.map_distance import landmark_lower_bound
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.surface import Surface


def lopsided(bend: float) -> Surface:
    """A body with two equal limbs, a longer tail and a bent back."""
    directions = ((0.7, 0.6, -0.4), (-0.7, 0.6, -0.4), (0, -1, 0.3), (0, 0.6, 0.8))
    vertices, faces = limbed(directions, (1.0, 1.0, 0.7, 0.4))
    return Surface(bent(vertices, bend), faces)


#: Fewer points and triangles than the shapes have.
FEW = MatchingParameters(candidate_points=400, candidate_triangles=200)


@functools.cache
def pair() -> MatchProblem:
    """Two poses of 642 vertices, equally numbered; fewer points are mapped."""
    return MatchProblem.of(lopsided(0.0), lopsided(0.25), FEW)


@functools.cache
def found() -> list[Candidate]:
    return candidates(pair())


def test_the_best_candidates_are_the_pose_and_its_mirror_image() -> None:
    x, y = pair().x, pair().y
    points = mapped_points(pair())
    assert len(points) < x.n_vertices
    kept = next(c for c in found() if c.orientation > 0)
    assert landmark_lower_bound(y, kept.p2p, points).mean() < 0.05
    reversing = next(c for c in found() if c.orientation < 0)
    mirror = self_symmetry(y).nearest
    assert landmark_lower_bound(y, reversing.p2p, mirror[points]).mean() < 0.05


def test_the_orientation_over_some_triangles_is_that_over_all() -> None:
    """But for ties, the order of the faces does not matter; and the value is near that of the true map."""
    x, y = pair().x, pair().y
    shuffled = np.random.default_rng(0).permutation(len(x.surface.faces))
    other = PreparedShape(Surface(x.surface.vertices, x.surface.faces[shuffled]), parameters=FEW)
    other.intrinsic = x.intrinsic
    again = [c.orientation for c in candidates(MatchProblem(other, y, FEW))]
    assert again == pytest.approx([c.orientation for c in found()], abs=0.02)
    kept = next(c for c in found() if c.orientation > 0)
    assert kept.orientation == pytest.approx(orientation(x.unit, y.unit, np.arange(x.n_vertices)), abs=0.35)


@pytest.mark.slow
@pytest.mark.parametrize("of_y", [True, False], ids=["symmetry of Y", "symmetry of X"])
def test_the_twin_of_a_candidate_is_its_mirror_image(of_y: bool) -> None:
    x, y = pair().x, pair().y
    reversing = next(c for c in found() if c.orientation < 0)
    twin = mirrored_map(pair(), reversing, self_symmetry(y if of_y else x).nearest, of_y=of_y)
    assert twin.orientation == -reversing.orientation
    assert twin.mean_distortion == pytest.approx(reversing.mean_distortion, abs=0.02)
    assert landmark_lower_bound(y, twin.p2p, mapped_points(pair())).mean() < 0.06


def test_maps_without_a_side_compete_only_where_there_are_no_others() -> None:
    middle = float(np.median([abs(c.orientation) for c in found()]))

    def kept(one_sided: float) -> list[float]:
        problem = replace(pair(), parameters=replace(FEW, one_sided=one_sided))
        return [c.orientation for c in candidates(problem)]

    some = kept(middle)
    assert some == [c.orientation for c in found() if abs(c.orientation) > middle]
    assert 0 < len(some) < len(found())
    assert kept(1.0) == [c.orientation for c in found()]
