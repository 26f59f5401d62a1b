"""A creature in a fine and a coarse triangulation, and its poses."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import arched, creature

from qgeo_filters.decimation import decimated
from qgeo_filters.surface import Surface

CURVATURES = (0.2, 0.5)


@pytest.fixture(scope="session")
def fine() -> Surface:
    return Surface(*creature(1.0))


@pytest.fixture(scope="session")
def poses(fine: Surface) -> list[np.ndarray]:
    return [arched(fine.vertices, curvature) for curvature in CURVATURES]


@pytest.fixture(scope="session")
def coarse(fine: Surface) -> Surface:
    """The same body in other triangles, half as many."""
    return decimated(fine, 321).surface
