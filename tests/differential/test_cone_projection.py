"""Projections on cones against non-negative least squares."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from qgeo_filters.differential.cone_projection import projected_on_cones


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wide", "narrow", "flat", "repeated", "with zeros", "all of space"])
def test_as_non_negative_least_squares(kind: str) -> None:
    random = np.random.default_rng(3)
    cones, points = [], random.normal(size=(300, 3))
    for _ in points:
        vectors = random.normal(size=(random.integers(1, 9), 3))
        if kind == "narrow":
            vectors = 0.2 * vectors + random.normal(size=3)
        elif kind == "flat":
            vectors[:, 2] = 0
        elif kind == "repeated":
            vectors = np.repeat(vectors, 2, axis=0)
        elif kind == "all of space":
            vectors = np.concatenate([vectors, -vectors, np.eye(3), -np.eye(3)])
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        cones.append(np.concatenate([vectors, np.zeros((2, 3))]) if kind == "with zeros" else vectors)
    start = np.concatenate([[0], np.cumsum([len(cone) for cone in cones])])
    found = projected_on_cones(np.concatenate(cones), start, np.arange(start[-1]), points)
    expected = [cone.T @ nnls(cone.T, point)[0] for cone, point in zip(cones, points, strict=True)]
    np.testing.assert_allclose(found, expected, atol=2e-8)
