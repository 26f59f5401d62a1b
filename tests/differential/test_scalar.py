"""The scalar of the metric: unit deviation, no unit, nothing made out of noise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, cylinder, grid, icosphere, moebius, torus

from qgeo_filters.differential.coordinates import differential_coordinates
from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.differential.scalar import BUILT_IN, heat_smoothed, surface_scalar
from qgeo_filters.surface import Surface

CURVATURES = [name for name in BUILT_IN if name != "differential_norm"]


def mean_and_deviation(surface: Surface, f: np.ndarray) -> tuple[float, float]:
    weights = surface.vertex_areas / surface.area
    mean = weights @ f
    return mean, np.sqrt(weights @ (f - mean) ** 2)


@pytest.mark.parametrize("name", BUILT_IN)
@pytest.mark.parametrize("smoothing", [0.0, 0.05])
def test_unit_deviation_over_the_area(name, smoothing):
    surface = Surface(*blob(3))
    f = surface_scalar(surface, name, smoothing=smoothing)
    assert f.shape == (surface.n_vertices,)
    assert mean_and_deviation(surface, f)[1] == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("name", BUILT_IN)
@given(exponent=st.floats(-9, 9))
@settings(max_examples=5)
def test_no_unit(name, exponent):
    vertices, faces = blob(2)
    f = surface_scalar(Surface(vertices, faces), name, smoothing=0.02)
    scaled = surface_scalar(Surface(10**exponent * vertices, faces), name, smoothing=0.02)
    np.testing.assert_allclose(scaled, f, atol=1e-8)


@pytest.mark.parametrize("name", BUILT_IN)
def test_rigid_motion_and_vertex_order_change_nothing(name):
    vertices, faces = blob(2)
    f = surface_scalar(Surface(vertices, faces), name)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    order = np.random.default_rng(1).permutation(len(vertices))
    place = np.argsort(order)
    moved = Surface((vertices @ turn.T + [3, -2, 5])[order], place[faces])
    np.testing.assert_allclose(surface_scalar(moved, name), f[order], atol=1e-9)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("name", CURVATURES)
def test_constant_curvature_gives_zeros_and_not_scaled_noise(name, dtype):
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for vertices, faces in (icosphere(2), icosphere(4), grid(20, 0.3), cylinder()):
        assert (surface_scalar(Surface((vertices @ turn).astype(dtype), faces), name) == 0).all()


def test_minimal_surface_has_no_mean_curvature_but_a_gaussian_one():
    n = 40
    u, v = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(0, np.pi, n + 1), indexing="ij")
    catenoid = np.column_stack([(np.cosh(u) * np.cos(v)).ravel(), (np.cosh(u) * np.sin(v)).ravel(), u.ravel()])
    surface = Surface(catenoid, grid(n)[1])
    assert (surface_scalar(surface, "mean_curvature") == 0).all()
    f = surface_scalar(surface, "gaussian_curvature", clip=None)
    expected = -1 / np.cosh(u.ravel()) ** 4
    assert np.corrcoef(f, expected)[0, 1] > 0.999
    assert f.max() < 0


def test_mean_curvature_is_the_torus_formula_and_positive_outside():
    surface = Surface(*torus(120, 60))
    cosine = (np.hypot(*surface.vertices[:, :2].T) - 1) / 0.4
    expected = (2.5 + cosine / (1 + 0.4 * cosine)) / 2
    f = surface_scalar(surface, clip=None)
    np.testing.assert_allclose(f, expected / mean_and_deviation(surface, expected)[1], rtol=0.01)


def test_clipping_limits_to_percentiles_of_the_area():
    vertices, faces = grid(50)
    surface = Surface(vertices, faces)
    x = vertices[:, 0]
    f = surface_scalar(surface, x, clip=(10, 90))
    step = 1 / 50
    ratio = np.ptp(f) / np.ptp(surface_scalar(surface, x, clip=None))
    clipped = np.clip(x, 0.1, 0.9)
    exact = 0.8 / mean_and_deviation(surface, clipped)[1] * mean_and_deviation(surface, x)[1]
    assert ratio == pytest.approx(exact, rel=step)
    one_spike = np.where(np.arange(len(x)) == 7, 1e6, x)
    with_spike = surface_scalar(surface, one_spike)
    assert with_spike.max() == with_spike[7]
    np.testing.assert_allclose(np.delete(with_spike, 7), np.delete(surface_scalar(surface, x), 7), atol=0.02)


def test_two_triangulations_agree_where_one_is_denser_on_one_side():
    even, faces = grid(60)
    uneven = even.copy()
    uneven[:, 0] = even[:, 0] ** 2
    height = lambda p: np.column_stack([p[:, :2], 0.1 * np.sin(4 * p[:, 0]) * np.cos(3 * p[:, 1])])  # noqa: E731
    value = lambda p: np.sin(3 * p[:, 0])  # noqa: E731
    f, g = (surface_scalar(Surface(height(p), faces), value(p)) for p in (even, uneven))
    assert np.ptp(f) == pytest.approx(np.ptp(g), rel=0.01)


def test_smoothing_is_one_implicit_heat_step():
    # On the unit sphere z is an eigenfunction of the Laplacian (eigenvalue 2): one step divides it by 1 + 2 t.
    surface = Surface(*icosphere(4))
    smoothing = 0.1
    duration = smoothing**2 * surface.area
    smooth = heat_smoothed(surface, surface.vertices[:, 2], smoothing)
    np.testing.assert_allclose(smooth, surface.vertices[:, 2] / (1 + 2 * duration), atol=5e-4)
    assert mean_and_deviation(surface, heat_smoothed(surface, np.ones(surface.n_vertices), 0.3))[0] == pytest.approx(1)


def test_smoothing_leaves_loose_vertices():
    vertices, faces = blob(2)
    surface = Surface(np.vstack([vertices, [[9.0, 9, 9]]]), faces)
    values = np.append(vertices[:, 0], 42.0)
    assert heat_smoothed(surface, values, 0.1)[-1] == 42


def test_attribute_array_and_callable_are_one_thing():
    vertices, faces = blob(2)
    norms = np.linalg.norm(differential_coordinates(Surface(vertices, faces)), axis=1)
    surface = Surface(vertices, faces, {"norm": norms, "column": norms[:, None]})
    expected = surface_scalar(surface, norms)
    for scalar in ("norm", "column", norms.tolist(), lambda delta: np.linalg.norm(delta, axis=1)):
        np.testing.assert_allclose(surface_scalar(surface, scalar), expected, atol=1e-10)
    # A closed surface has no boundary to treat: the built-in norm is this function.
    np.testing.assert_allclose(surface_scalar(surface, "differential_norm"), expected, atol=1e-10)


def test_callable_sees_coordinates_without_unit():
    vertices, faces = blob(2)
    bent = lambda delta: np.exp(30 * np.linalg.norm(delta, axis=1))  # noqa: E731
    f, g = (surface_scalar(Surface(s * vertices, faces), bent) for s in (1.0, 1e6))
    np.testing.assert_allclose(f, g, atol=1e-8)


def test_given_constant_is_zero_and_given_detail_is_kept():
    surface = Surface(*grid(10))
    assert (surface_scalar(surface, np.full(surface.n_vertices, 7.3)) == 0).all()
    f = surface_scalar(surface, 5 + 1e-6 * surface.vertices[:, 0], clip=None)
    assert mean_and_deviation(surface, f)[1] == pytest.approx(1, abs=1e-9)


def test_inputs_are_left_alone():
    surface = Surface(*blob(2))
    values = mean_curvature(surface)
    before = values.copy()
    values.setflags(write=False)
    surface_scalar(surface, values, smoothing=0.05)
    np.testing.assert_array_equal(values, before)


def test_same_input_same_bits():
    vertices, faces = blob(3)
    for name in BUILT_IN:
        f, g = (surface_scalar(Surface(vertices, faces), name, smoothing=0.02) for _ in range(2))
        np.testing.assert_array_equal(f, g)


def test_bad_requests():
    surface = Surface(*grid(10), {"mine": np.zeros(121)})
    with pytest.raises(
        ValueError, match=r"unknown scalar 'heat'.*mean_curvature, .*principal_2.*this surface are mine"
    ):
        surface_scalar(surface, "heat")
    with pytest.raises(ValueError, match=r"shape \(3,\), expected real ones of shape \(121,\)"):
        surface_scalar(surface, [1, 2, 3])
    with pytest.raises(ValueError, match=r"not finite at 2 of 121 vertices: 4, 7"):
        surface_scalar(surface, np.where(np.isin(np.arange(121), [4, 7]), np.nan, 1.0))
    with pytest.raises(ValueError, match="complex128"):
        surface_scalar(surface, np.ones(121, complex))
    with pytest.raises(ValueError, match="two percentiles"):
        surface_scalar(surface, "mine", clip=(98, 2))
    for smoothing in (-0.1, np.nan, np.inf):
        with pytest.raises(ValueError, match="smoothing is a length"):
            surface_scalar(surface, "mine", smoothing=smoothing)
    with pytest.raises(ValueError, match="pass clip=None"):
        surface_scalar(surface, np.arange(121) == 60)
    with pytest.raises(ValueError, match="positive area"):
        surface_scalar(Surface([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))


def test_one_sided_surface_has_unsigned_scalars():
    surface = Surface(*moebius(60, 8))
    with pytest.raises(ValueError, match="agree on which side is out"):
        surface_scalar(surface)
    assert np.isfinite(surface_scalar(surface, "differential_norm")).all()
