"""Coarse maps, their measures and their mirrored twins."""

from __future__ import annotations

import functools
import sys

import numpy as np
import pytest
from shapes import bent, limbed

from qgeo_filters.matching.correspondence import _twin
from qgeo_filters.matching.initialization.candidates import Candidate, between, candidates, mapped_points
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.surface import Surface


def lopsided(level: int, bend: float) -> Surface:
    """A body with two equal limbs, a longer tail and a bent back."""
    directions = ((0.7, 0.6, -0.4), (-0.7, 0.6, -0.4), (0, -1, 0.3), (0, 0.6, 0.8))
    vertices, faces = limbed(directions, (1.0, 1.0, 0.7, 0.4), level)
    return Surface(bent(vertices, bend), faces)


@functools.cache
def pair() -> tuple[PreparedShape, PreparedShape]:
    """Two poses of 2562 vertices, equally numbered; fewer points are mapped."""
    return PreparedShape(lopsided(4, 0.0)), PreparedShape(lopsided(4, 0.25))


@functools.cache
def found() -> list[Candidate]:
    return candidates(*pair())


def test_the_best_candidates_are_the_pose_and_its_mirror_image() -> None:
    x, y = pair()
    points = mapped_points(x)
    assert len(points) < x.n_vertices
    kept = next(c for c in found() if c.orientation > 0)
    assert between(y, kept.p2p, points).mean() < 0.05
    reversing = next(c for c in found() if c.orientation < 0)
    mirror = self_symmetry(y).nearest
    assert between(y, reversing.p2p, mirror[points]).mean() < 0.05


def test_the_orientation_over_some_triangles_is_that_over_all() -> None:
    """But for ties, the order of the faces does not matter; and the value is near that of the true map."""
    x, y = pair()
    shuffled = np.random.default_rng(0).permutation(len(x.surface.faces))
    other = PreparedShape(Surface(x.surface.vertices, x.surface.faces[shuffled]))
    for name in ("views", "laplacian"):
        other.__dict__[name] = getattr(x, name)
    other._samples = x._samples
    again = [c.orientation for c in candidates(other, y)]
    assert again == pytest.approx([c.orientation for c in found()], abs=0.02)
    kept = next(c for c in found() if c.orientation > 0)
    assert kept.orientation == pytest.approx(orientation(x.unit, y.unit, np.arange(x.n_vertices)), abs=0.35)


@pytest.mark.parametrize("onto", [True, False], ids=["symmetry of Y", "symmetry of X"])
def test_the_twin_of_a_candidate_is_its_mirror_image(onto: bool) -> None:
    x, y = pair()
    reversing = next(c for c in found() if c.orientation < 0)
    twin = _twin(x, y, reversing, self_symmetry(y if onto else x), onto)
    assert twin.orientation == -reversing.orientation
    assert twin.distortion == pytest.approx(reversing.distortion, abs=0.02)
    assert between(y, twin.p2p, mapped_points(x)).mean() < 0.06


def test_maps_without_a_side_compete_only_where_there_are_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[candidates.__module__]
    x, y = pair()
    middle = float(np.median([abs(c.orientation) for c in found()]))
    monkeypatch.setattr(module, "_ONE_SIDED", middle)
    some = [c.orientation for c in candidates(x, y)]
    assert some == [c.orientation for c in found() if abs(c.orientation) > middle]
    assert 0 < len(some) < len(found())
    monkeypatch.setattr(module, "_ONE_SIDED", 1.0)
    assert [c.orientation for c in candidates(x, y)] == [c.orientation for c in found()]
