"""Landmarks in pictures."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import icosphere

import qgeo_filters as qg
from qgeo_filters.report.colors import distinct
from qgeo_filters.report.landmarks import plot_landmarks

BALL = qg.Surface(*icosphere(2))


def shows(axes, color) -> bool:
    """Whether a picture has the hue of a colour somewhere."""
    picture = np.asarray(axes.images[0].get_array(), dtype=np.float64)[..., :3].reshape(-1, 3)
    size = np.linalg.norm(picture, axis=1) * np.linalg.norm(color)
    return bool(((picture @ color) / np.maximum(size, 1e-9) > 0.998).any())


def test_a_landmark_has_one_colour_on_all_and_none_where_it_has_no_place():
    top = BALL.vertices[[BALL.vertices[:, 1].argmax(), BALL.vertices[:, 1].argmin()]]
    there, lost = top.copy(), top.copy()
    lost[1] = np.nan
    marks = {name: qg.Landmarks(("a", "b"), points) for name, points in (("x", there), ("y", lost))}
    figure = plot_landmarks({"x": BALL, "y": BALL}, marks)
    one, other = figure.axes
    first, second = distinct(2)
    assert [axes.get_title() for axes in figure.axes] == ["x", "y"]
    assert shows(one, first)
    assert shows(other, first)
    assert shows(one, second)
    assert not shows(other, second)


def test_shapes_without_landmarks_are_named():
    with pytest.raises(qg.ParameterError, match=r"y has no landmarks \(1 such\)"):
        plot_landmarks({"y": BALL}, {})
    with pytest.raises(qg.ParameterError, match="there is no shape"):
        plot_landmarks({}, {})
