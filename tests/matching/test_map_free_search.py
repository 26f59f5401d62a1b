"""Correspondence and self-symmetry on shapes whose true maps are known by construction."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from shapes import bent, creature, grid, moebius

from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation.errors import geodesic_error
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.surface import Surface


@functools.cache
def prepared() -> PreparedShape:
    return PreparedShape(Surface(*creature()))


def mirror_of(vertices: np.ndarray) -> np.ndarray:
    gaps = np.linalg.norm(vertices[:, None] - vertices * [-1, 1, 1], axis=2)
    return gaps.argmin(axis=1)


def test_the_identity_is_found_through_numbering_position_and_size() -> None:
    """A renumbered, turned, moved and scaled copy: the map is the renumbering."""
    vertices, faces = creature()
    order = np.random.default_rng(0).permutation(len(vertices))
    place = np.argsort(order)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    copy = Surface(100 * vertices[order] @ turn.T + [5, -3, 2], place[faces])
    found = match(prepared(), copy)
    assert (found.p2p == place).mean() > 0.99
    assert (found.inverse == order).mean() > 0.99
    assert found.score < 1e-3
    assert np.allclose(found.positions, copy.vertices[place], atol=0.02 * np.sqrt(copy.area))


def test_a_bent_copy_is_matched_and_not_mirrored() -> None:
    vertices, faces = creature()
    y = Surface(bent(vertices, 0.25), faces)
    found = match(prepared(), y)
    truth = np.arange(len(vertices))
    error = geodesic_error(found.p2p, truth, y)
    assert error.mean() < 0.01
    assert geodesic_error(found.p2p, mirror_of(vertices), y).mean() > 0.1
    assert found.orientation > 0.6
    assert found.functional_map.shape == (20, 20)
    # Regions of one number are each other's images.
    assert (found.regions_x == found.regions_y[found.p2p]).mean() > 0.9


def test_the_symmetry_of_a_creature() -> None:
    vertices, _ = creature()
    found = self_symmetry(prepared())
    assert found.found, found.reason
    n = len(vertices)
    assert np.array_equal(found.p2p[found.p2p], np.arange(n))
    truth = mirror_of(vertices)
    surface = prepared().unit
    assert geodesic_error(found.nearest, truth, surface).mean() < 0.005
    assert geodesic_error(found.p2p, truth, surface).mean() < 0.02
    # Sides are those of the sign of x, up to a swap, and the axis runs near x = 0.
    away = np.abs(vertices[:, 0]) > 0.1
    agreement = np.sign(vertices[away, 0]) * found.side[away]
    assert abs(agreement.mean()) > 0.97
    assert np.abs(vertices[found.fixed, 0]).max() < 0.2
    assert found.asymmetry.max() < 0.05


def test_the_same_call_gives_the_same_bits() -> None:
    first, second = (self_symmetry(Surface(*creature(level=2))) for _ in range(2))
    assert np.array_equal(first.p2p, second.p2p)
    assert np.array_equal(first.asymmetry, second.asymmetry)


def test_what_cannot_be_matched_is_refused_with_a_sentence() -> None:
    with pytest.raises(MeshError, match="it is one-sided"):
        PreparedShape(Surface(*moebius()))
    with pytest.raises(MeshError, match="at least 60 vertices, got 16"):
        PreparedShape(Surface(*grid(3)))
    with pytest.raises(ValueError, match="weights is empty"):
        PreparedShape(Surface(*creature(level=2)), curvature_weights=())
    vertices, faces = creature()
    with pytest.raises(ValueError, match="normalize=True"):
        match(prepared(), Surface(2 * vertices, faces), normalize=False)
    with pytest.raises(ValueError, match="positive fraction"):
        self_symmetry(prepared(), tolerance=0)


def test_progress_names_the_stages_and_silence_is_silent(capfd: pytest.CaptureFixture[str]) -> None:
    shape = PreparedShape(Surface(*creature(level=2)))
    match(shape, shape)
    assert capfd.readouterr().err == ""
    match(shape, shape, progress=True)
    told = capfd.readouterr().err
    assert "prepare" in told
    assert "matched: 100%" in told
