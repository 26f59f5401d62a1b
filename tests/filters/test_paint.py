"""Colours from attributes: ranges, columns, what is not finite, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps
from shapes import icosphere

import qgeo_filters as qg
from qgeo_filters.report.colors import MISSING, mirror_colors


def painted(values: np.ndarray, **options: object) -> np.ndarray:
    surface = qg.Surface(*icosphere(1), {"own": values})
    return qg.Paint(attribute="own", **options).apply(surface).attributes["colors"]


@pytest.fixture
def values() -> np.ndarray:
    return np.linspace(-1.0, 3.0, 42)


@pytest.mark.parametrize("dtype", [np.int32, np.float64])  # hosts have their own types
def test_mirror_images_are_painted_as_such_and_not_by_their_numbers(dtype: type) -> None:
    vertices, faces = icosphere(1)
    images = np.array([np.linalg.norm(vertices - v * [-1, 1, 1], axis=1).argmin() for v in vertices])
    images[images == 7] = -1
    surface = qg.Surface(vertices, faces, {"qgeo_symmetry": images.astype(dtype)})
    colors = qg.Paint(attribute="qgeo_symmetry", colormap="magma").apply(surface).attributes["colors"]
    np.testing.assert_allclose(colors, mirror_colors(vertices, images, np.eye(3)))
    paired = (images >= 0) & (images[images] == np.arange(42))
    np.testing.assert_allclose(colors[paired], colors[images[paired]])
    np.testing.assert_allclose(colors[images < 0], [MISSING])
    assert len(np.unique(colors.round(3), axis=0)) > 15


def test_colours_are_those_of_the_map_over_the_range(values: np.ndarray) -> None:
    np.testing.assert_allclose(painted(values), colormaps["viridis"]((values + 1) / 4)[:, :3])
    limited = painted(values, vmin=0.0, vmax=1.0, colormap="gray")
    np.testing.assert_allclose(limited, colormaps["gray"](np.clip(values, 0, 1))[:, :3])


def test_a_centred_range_has_zero_in_the_middle(values: np.ndarray) -> None:
    np.testing.assert_allclose(painted(values, centred=True), colormaps["viridis"]((values + 3) / 6)[:, :3])


def test_a_column_or_the_length_of_a_vector(values: np.ndarray) -> None:
    wide = np.column_stack([values, 2 * values, 2 * values])
    np.testing.assert_allclose(painted(wide, component=1), painted(values))
    np.testing.assert_allclose(painted(wide), painted(np.abs(3 * values)))


def test_what_is_not_finite_is_grey_and_a_constant_is_the_middle(values: np.ndarray) -> None:
    values[[3, 5]] = np.nan, np.inf
    assert (painted(values)[[3, 5]] == 0.6).all()
    assert np.ptp(painted(np.full(42, 7.0)), axis=0).max() == 0


def test_what_cannot_be_painted_is_refused(values: np.ndarray) -> None:
    with pytest.raises(qg.ParameterError, match="unknown colour map 'no such'"):
        painted(values, colormap="no such")
    with pytest.raises(qg.MeshError, match="has 1 columns, but component is 2"):
        painted(values, component=2)
    with pytest.raises(qg.MeshError, match="no attribute 'other' to paint; the mesh has own"):
        qg.Paint(attribute="other").apply(qg.Surface(*icosphere(1), {"own": values}))
