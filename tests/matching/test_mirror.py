"""Maps that may, must or must not reverse the orientation."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
from shapes import crooked, limbed, reflected

import qgeo_filters as qg
from qgeo_filters.evaluation import VtsDataset, geodesic_error


@functools.cache
def described() -> qg.PreparedShape:
    return qg.PreparedShape(qg.Surface(*crooked(0, 2)))


@functools.cache
def other_side() -> qg.PreparedShape:
    """What `described()` is in a mirror."""
    return qg.PreparedShape(qg.Surface(*reflected(crooked(0, 2))))


@pytest.mark.parametrize("mirror", ["auto", "yes"])
def test_a_mirror_image_is_found_vertex_by_vertex(mirror: str) -> None:
    found = qg.match(described(), other_side(), mirror=mirror)
    assert (found.p2p == np.arange(len(found.p2p))).mean() > 0.99
    assert found.orientation < -0.6
    assert found.confident, found.explanation
    assert "mirror image of X" in found.explanation
    # Positions are those on the mirror image.
    assert np.abs(found.positions - found.y.vertices).max() < 0.05 * np.sqrt(found.y.area)


@pytest.mark.parametrize("seed", [2, 3])
def test_a_mirror_image_is_sure_where_no_map_that_keeps_the_orientation_is_proposed(seed: int) -> None:
    """What it is compared with then are mirrored maps by reflections that the body nearly has."""
    mesh = crooked(seed, 2)
    found = qg.match(qg.Surface(*mesh), qg.Surface(*reflected(mesh)))
    np.testing.assert_array_equal(found.p2p, np.arange(len(found.p2p)))
    assert found.confident, found.explanation


def test_the_orientation_is_kept_where_it_must_be() -> None:
    found = qg.match(described(), other_side(), mirror="no")
    assert found.orientation > 0
    assert "mirror" not in found.explanation
    assert found.score > 0.02  # nothing fits, which is 0 in a mirror


def test_what_must_be_turned_over_is_turned_over() -> None:
    """A shape onto itself, as a mirror image; left to itself, it stays as it is."""
    copy = qg.PreparedShape(qg.Surface(*crooked(0, 2)))
    found = qg.match(described(), copy, mirror="yes")
    assert found.orientation < 0
    assert "as was asked for" in found.explanation
    assert found.score > 0.02
    same = qg.match(described(), copy)
    assert same.confident, same.explanation
    np.testing.assert_array_equal(same.p2p, np.arange(len(same.p2p)))


@pytest.mark.slow
def test_what_has_a_left_and_a_right_keeps_them_in_the_pose_that_it_has_in_a_mirror() -> None:
    """A woman who lifts her left arm is not the mirror image of one who lifts her right, though that fits better."""
    directions = ((0.0, 0.2, 1.0), (1.0, 0.3, 0.4), (-1.0, 0.3, 0.4), (0.6, 0.25, -1.0), (-0.6, 0.25, -1.0))
    vertices, faces = limbed(directions, (0.5, 0.9, 0.9, 1.4, 1.4))
    angle = 0.3 * np.clip(vertices[:, 0] - 0.3, 0, 1)  # of the limbs on one side
    turned = np.column_stack([
        vertices[:, 0],
        vertices[:, 1] * np.cos(angle) + vertices[:, 2] * np.sin(angle),
        vertices[:, 2] * np.cos(angle) - vertices[:, 1] * np.sin(angle),
    ])  # fmt: skip
    x, y = qg.Surface(turned, faces), qg.Surface(*reflected((turned, faces)))
    partner = np.linalg.norm((vertices * [-1, 1, 1])[:, None] - vertices[None], axis=2).argmin(axis=1)
    found = qg.match(x, y)
    np.testing.assert_array_equal(found.p2p, partner)
    assert found.confident
    assert found.score > 0.005  # which is 0 in the mirror
    asked = qg.match(x, y, mirror="yes")
    assert (asked.normalize, asked.partial, asked.mirror) == (True, "auto", "yes")
    np.testing.assert_array_equal(asked.p2p, np.arange(len(partner)))


def test_options_that_are_none() -> None:
    with pytest.raises(qg.ParameterError, match="mirror must be 'no', 'yes' or 'auto', got True"):
        qg.match(described(), other_side(), mirror=True)  # type: ignore[call-overload]
    with pytest.raises(qg.ParameterError, match="partial matches keep the orientation"):
        qg.match(described(), other_side(), mirror="yes", partial=True)


@pytest.mark.slow
@pytest.mark.thorough
def test_teeth_of_either_jaw(data_dir: Path) -> None:
    """A left molar onto a right one reverses the orientation."""
    pair = "Q11", "a13"
    folder = data_dir / "harder" / "teeth"
    if not folder.is_dir():
        pytest.skip("no teeth in the data")
    data = VtsDataset(folder)
    x, y = (data.read(name) for name in pair)
    truth = data.truth(*pair)
    found = qg.match(x, y)
    assert (found.orientation < 0) == data.reversing(*pair)
    assert found.confident, found.explanation
    # Landmarks are set by hand, to within .03 or so.
    assert geodesic_error(found.p2p[truth.points], truth.images, y).mean() < 0.05
