"""Nearest neighbours, distortions of coarse maps, and tasks side by side, against the plain way to compute them."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_info

from qgeo_filters.matching.maps.functional_map import functional_map, nearest_neighbors, nearest_neighbors_both_ways
from qgeo_filters.matching.maps.map_distance import coarse_distortions
from qgeo_filters.parallel import concurrently


@settings(max_examples=25)
@given(st.integers(1, 60), st.integers(1, 60), st.integers(1, 12), st.integers(0, 1000))
def test_nearest_rows_are_those_of_all_pairs(n: int, m: int, d: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    one, other = random.normal(size=(n, d)), random.normal(size=(m, d))
    squared = ((one[:, None] - other) ** 2).sum(axis=2)
    forth, back = nearest_neighbors_both_ways(one, other)
    np.testing.assert_array_equal(forth, squared.argmin(axis=1))
    np.testing.assert_array_equal(back, squared.argmin(axis=0))
    np.testing.assert_array_equal(nearest_neighbors(one, other), squared.argmin(axis=1))
    stack = np.stack([one, -one])
    np.testing.assert_array_equal(nearest_neighbors(stack, other)[0], squared.argmin(axis=1))


@pytest.mark.parametrize("n", [1024, 3100])
def test_nearest_rows_of_many_points(n: int) -> None:
    """More than one block, and more than one thread."""
    random = np.random.default_rng(0)
    one, other = random.normal(size=(n, 4)), random.normal(size=(n + 7, 4))
    forth, back = nearest_neighbors_both_ways(one, other)
    np.testing.assert_array_equal(forth, nearest_neighbors(one, other))
    np.testing.assert_array_equal(back, nearest_neighbors(other, one))


@settings(max_examples=25)
@given(st.integers(1, 20), st.integers(1, 20), st.integers(0, 5), st.integers(0, 1000))
def test_distortions_of_maps(s: int, m: int, count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    points_x, points_y = random.normal(size=(s, 3)), random.normal(size=(m, 3))
    near_x, near_y = (np.linalg.norm(p[:, None] - p, axis=2).astype(np.float32) for p in (points_x, points_y))
    maps = random.integers(0, m, (count, s))
    expected = [np.abs(near_x - near_y[images][:, images]).mean() for images in maps]
    np.testing.assert_allclose(coarse_distortions(near_x, near_y, maps), expected, rtol=1e-5, atol=1e-6)


@settings(max_examples=25)
@given(st.integers(1, 6), st.integers(1, 4), st.integers(0, 1000))
def test_functional_maps_of_a_stack_are_those_of_its_layers(k: int, layers: int, seed: int) -> None:
    """Equal to those of one layer after the other, and exact where a linear map is there to be found."""
    random = np.random.default_rng(seed)
    n, m = 20, 15
    stack, other = random.normal(size=(layers, n, k)), random.normal(size=(m, k))
    p2p = random.integers(0, m, (layers, n))
    weights = random.uniform(0.5, 1, n)
    found = functional_map(stack, other, p2p, weights)
    assert found.shape == (layers, k, k)
    for layer in range(layers):
        root = np.sqrt(weights)[:, None]
        expected = np.linalg.lstsq(root * stack[layer], root * other[p2p[layer]], rcond=None)[0]
        np.testing.assert_allclose(found[layer], expected, atol=1e-6)
        np.testing.assert_allclose(functional_map(stack[layer], other, p2p[layer], weights), expected, atol=1e-6)


def test_results_come_in_the_order_of_the_items_and_errors_come_out() -> None:
    gate = threading.Event()

    def late(item: int) -> int:
        if item == 0:
            gate.wait(0.2)
        gate.set()
        return item * item

    assert concurrently(late, range(5)) == [0, 1, 4, 9, 16]
    with pytest.raises(ZeroDivisionError):
        concurrently(lambda item: 1 // item, [1, 0])


def test_linear_algebra_stays_on_one_thread_meanwhile_and_gets_its_own_back() -> None:
    def threads() -> list[int]:
        return [entry["num_threads"] for entry in threadpool_info() if entry["user_api"] == "blas"]

    before = threads()
    assert before
    assert concurrently(lambda _: threads(), range(3)) == [[1] * len(before)] * 3
    assert threads() == before
