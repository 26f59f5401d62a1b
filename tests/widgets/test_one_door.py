"""Filters, commands and widgets share what is expensive: each match, symmetry and matrix is computed once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters.caching import cache
from qgeo_filters.filters import stages
from qgeo_filters.matching import reflection_search
from qgeo_filters.matching.parameters import MatchingParameters


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Counter[str]]:
    """How often each expensive thing was computed, from an empty cache on."""
    calls: Counter[str] = Counter()

    def counted(module, name):
        function = getattr(module, name)

        def count(*args, **options):
            calls[name] += 1
            return function(*args, **options)

        monkeypatch.setattr(module, name, count)

    for name in ("match", "distance_matrix", "distance_spectrum", "lifted_metric"):
        counted(stages, name)
    counted(reflection_search, "candidates")  # the search for a reflection
    cache.clear()
    yield calls
    cache.clear()


@pytest.fixture(scope="module")
def bilateral() -> tuple[np.ndarray, np.ndarray]:
    """A closed shape with one symmetry, the reflection in the plane x = 0."""
    vertices, faces = shapes.icosphere(2)
    x, y, z = vertices.T
    radius = 1 + 0.3 * y + 0.2 * z * y + 0.25 * x**2 * y - 0.15 * z**3
    return np.column_stack([0.8 * x, 1.4 * y, z]) * radius[:, None], faces


def test_the_symmetry_widget_and_filter_share_one_symmetry(bilateral, computed):
    widget = qw.symmetry(bilateral)
    assert widget.message == ""
    filtered = qg.SelfSymmetry()(qg.Surface(*bilateral))
    np.testing.assert_array_equal(filtered.attributes["qgeo_symmetry"], widget._symmetry.p2p)
    assert computed["candidates"] == 1
    assert computed["distance_spectrum"] == 1
    assert computed["distance_matrix"] == 3  # one for each metric that proposes maps, the spectrum's among them
    widget.close()


def test_the_compare_widget_and_the_filter_share_one_match(pair, computed):
    x, y, _ = pair
    widget = qw.compare(x, y, progress=False)
    assert widget.message == ""
    filtered = qg.Correspondence(target=y)(qg.Surface(x.vertices, x.faces))
    np.testing.assert_array_equal(filtered.attributes["qgeo_correspondence"], widget.p2p)
    assert computed["match"] == 1
    assert computed["distance_matrix"] == 2  # in the metric that proposes maps first
    widget.close()


def test_the_mirrored_twin_takes_the_symmetry_that_was_found(bilateral, computed):
    surface = qg.Surface(*bilateral)
    found = stages.symmetry_of(surface)
    widget = qw.compare(surface, surface, p2p=np.arange(surface.n_vertices))
    widget.flip = True
    assert widget.message == ""
    np.testing.assert_array_equal(widget.p2p, found.p2p)
    assert computed["candidates"] == 1
    widget.close()


def test_a_match_and_the_symmetry_of_its_target_search_once(bilateral, computed):
    surface = qg.Surface(*bilateral)
    twice = qg.Surface(2.0 * surface.vertices, surface.faces)
    prepared = stages.prepared_shape_of(twice)
    qg.match(surface, prepared, parameters=MatchingParameters(quick=False))
    assert computed["candidates"] == 1  # a thorough match asks for the symmetry of Y
