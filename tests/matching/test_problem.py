"""What a run goes by: parameters, the pair that they belong to, and the log of all that was looked at."""

from __future__ import annotations

import functools
import math
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from shapes import blob, icosphere

import qgeo_filters as qg
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.match_log import CHOSEN, IN_THE_RACE, LoggedMap, MatchLog
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.cost import torn_share
from qgeo_filters.matching.symmetry import reflection_log
from qgeo_filters.surface import Surface

#: Everything at full resolution.
FULL = MatchingParameters(search_vertices=10_000, registration_vertices=10_000)


def bodies() -> tuple[Surface, Surface]:
    """A body with four unequal limbs, and the same bent."""
    vertices, faces = icosphere(3)
    radius = np.full(len(vertices), 0.6)
    for direction, length in zip(np.random.default_rng(1).normal(size=(4, 3)), (1.3, 1.0, 0.8, 0.6), strict=True):
        radius += length * np.exp(12 * (vertices @ (direction / np.linalg.norm(direction)) - 1))
    points = vertices * radius[:, None]
    return Surface(points, faces), Surface(points + 0.05 * np.sin(2 * points[:, [1, 2, 0]]), faces)


@functools.cache
def prepared() -> tuple[PreparedShape, PreparedShape]:
    x, y = (PreparedShape(surface) for surface in bodies())
    return x, y


@functools.cache
def logged() -> tuple[qg.MatchResult, MatchLog]:
    return qg.match(*prepared(), parameters=MatchingParameters(quick=False), log=True)


# -- parameters ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("weights", [(0.03,), (0.0, 0.01), (0.01, 0.03, 0.0), (0.0, 0.03, 0.01, 0.05)])
def test_shapes_of_different_metrics_are_not_compared(weights: tuple[float, ...]) -> None:
    """Neither of fewer metrics, nor of others, nor in another order: pairs of metrics would be mismatched."""
    x, y = bodies()
    other = PreparedShape(y, curvature_weights=weights)
    message = r"was prepared with curvature_weights=.*prepare both shapes with the same parameters"
    with pytest.raises(ParameterError, match=f"Y: the shape {message}"):
        qg.match(x, other, parameters=MatchingParameters())
    with pytest.raises(ParameterError, match=message):
        qg.match(prepared()[0], other)
    with pytest.raises(ParameterError, match=message):
        qg.match(other, prepared()[0])
    with pytest.raises(ParameterError, match=f"the shape {message}"):
        qg.self_symmetry(other, parameters=MatchingParameters())


def test_a_surface_is_prepared_as_the_other_shape_was() -> None:
    x, y = bodies()
    other = PreparedShape(y, curvature_weights=(0.0, 0.02))
    problem = MatchProblem.of(x, other)
    assert problem.parameters.curvature_weights == problem.x.parameters.curvature_weights == (0.0, 0.02)


def test_parameters_that_no_shape_depends_on_may_be_varied() -> None:
    """And they do something: with one contender there is no runner-up."""
    x, y = prepared()
    given = replace(MatchingParameters(), preview_count=1, quick=False)
    found, log = qg.match(x, y, parameters=given, log=True)
    assert found.runner_up == found.margin == math.inf
    assert sum(entry.preview_cost is not None for entry in log) == 1
    assert sum(entry.preview_cost is not None for entry in logged()[1]) > 1


def test_parameters_are_frozen_and_can_be_looked_up() -> None:
    given = MatchingParameters()
    with pytest.raises(FrozenInstanceError):
        given.margin = 2.0  # type: ignore[misc]
    assert hash(given) == hash(MatchingParameters())
    assert given == MatchingParameters()
    of_shape = given.of_shape()
    assert {"curvature_weights", "hks_times", "fps_count", "laplacian_functions", "minimum_vertices"} <= set(of_shape)
    assert "margin" not in of_shape
    assert set(of_shape) < {field.name for field in fields(given)}


def test_old_names_are_taken_with_a_warning() -> None:
    x, _ = bodies()
    with pytest.warns(DeprecationWarning, match="weights is now called curvature_weights"):
        shape = PreparedShape(x, weights=(0.0, 0.05))  # type: ignore[call-arg]
    assert shape.parameters.curvature_weights == (0.0, 0.05)
    with pytest.raises(ParameterError, match="curvature_weights is empty"):
        PreparedShape(x, curvature_weights=())


@pytest.mark.parametrize("workers", [0, -1, True, 1.5])
def test_workers_are_checked(workers: object) -> None:
    x, y = prepared()
    with pytest.raises(ParameterError, match="workers must be"):
        qg.match(x, y, workers=workers)  # type: ignore[call-overload]
    with pytest.raises(ParameterError, match="workers must be"):
        qg.self_symmetry(x, workers=workers)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="workers must be"):
        qg.compatibility(bodies(), workers=workers)  # type: ignore[arg-type]


def test_the_map_does_not_depend_on_the_number_of_threads() -> None:
    x, y = bodies()
    one = qg.match(x, y, workers=1)
    np.testing.assert_array_equal(one.positions, logged()[0].positions)
    np.testing.assert_array_equal(one.p2p, logged()[0].p2p)


# -- the log -------------------------------------------------------------------------------------------------


def test_one_map_is_chosen_and_each_other_says_which_rule_dropped_it() -> None:
    _, log = logged()
    assert [entry.number for entry in log] == list(range(len(log)))
    assert sum(entry.fate == CHOSEN for entry in log) == 1
    assert all(entry.fate != IN_THE_RACE for entry in log)
    proposers = {entry.proposed_by for entry in log}
    for weight in ("0", "0.03", "0.01"):
        assert f"signs of eigenfunctions, curvature weight {weight}" in proposers


def test_what_went_further_was_measured_further() -> None:
    _, log = logged()
    chosen = log.chosen
    assert chosen is not None
    assert chosen.orientation is not None
    assert chosen.orientation > 0
    ended = [entry for entry in log if entry.end_cost is not None]
    assert chosen.end_cost == min(entry.end_cost for entry in ended if entry.end_cost is not None)
    for entry in log:
        terms = (entry.strain, entry.torn, entry.folded, entry.hks_agreement, entry.relief_agreement)
        assert all((term is None) == (entry.preview_cost is None) for term in terms)
        assert entry.end_cost is None or entry.preview_cost is not None
    reversing = [entry for entry in log if entry.fate == "reverses the orientation"]
    assert all(entry.orientation is not None and entry.orientation <= 0 for entry in reversing)


def test_the_log_changes_nothing() -> None:
    found = qg.match(*prepared())
    assert isinstance(found, qg.MatchResult)
    np.testing.assert_array_equal(found.positions, logged()[0].positions)
    assert found.margin == logged()[0].margin


def test_the_table_has_a_row_for_each_map() -> None:
    _, log = logged()
    rows = log.table()
    assert len(rows) == len(log)
    assert list(rows[0]) == [field.name for field in fields(LoggedMap)]
    lines = str(log).splitlines()
    assert len(lines) == len(log) + 2
    assert lines[2].endswith(f"| {CHOSEN} |")
    assert len({line.count("|") for line in lines}) == 1


def test_the_first_rule_stands() -> None:
    log = MatchLog()
    first, second = log.propose("one", 0.1), log.propose("other", 0.2)
    log.drop(second, "too far")
    log.choose(first)
    log.drop(second, "another reason")
    assert [entry.fate for entry in log] == [CHOSEN, "too far"]


def test_a_map_that_is_taken_to_the_end_after_all_is_in_the_race_again() -> None:
    log = MatchLog()
    first, second = log.propose("one", 0.1), log.propose("other", 0.2)
    log.drop(second, "not among the cheapest")
    log.note(second, preview_cost=2.0)
    assert log[second].fate == "not among the cheapest"
    log.note(second, end_cost=2.0)
    log.choose(first)
    assert log[second].fate == "costs more at the end than #0"
    log.note(first, end_cost=1.0)
    assert log[first].fate == CHOSEN
    assert log.chosen is log[first]


def test_reflections_are_logged_as_well() -> None:
    log = reflection_log(prepared()[0])
    assert len(log) > 0
    assert {entry.fate for entry in log} & {"keeps the orientation of the shape: no reflection", CHOSEN}


# -- the first attempt ---------------------------------------------------------------------------------------


def test_a_clear_map_is_found_by_the_last_metric_alone() -> None:
    x, y = (PreparedShape(surface) for surface in bodies())
    found = qg.match(x, y)
    assert {entry.proposed_by for entry in found.log} == {"signs of eigenfunctions, curvature weight 0.01"}
    assert sum(entry.fate == CHOSEN for entry in found.log) == 1
    thorough = logged()[0]
    moved = np.linalg.norm(y.full.vertices[found.p2p] - y.full.vertices[thorough.p2p], axis=1)
    assert moved.mean() < 0.01 * np.sqrt(y.full.area)


@pytest.mark.parametrize("doubt", [{"quick_margin": 1e6}, {"quick_alike": 1.01}, {"quick_distortion": 0.0}])
def test_where_there_is_any_doubt_all_metrics_propose(doubt: dict[str, float]) -> None:
    found = qg.match(*prepared(), parameters=MatchingParameters(**doubt))  # type: ignore[arg-type]
    np.testing.assert_array_equal(found.p2p, logged()[0].p2p)
    assert len(found.log) == len(logged()[1])


# -- torn edges ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", [1, 2, 3])
def test_the_right_map_onto_a_coarser_sphere_tears_nothing(level: int) -> None:
    """Vertices of 2562 that go to one vertex or to neighbours of 162: by X's edges alone a third would be torn."""
    x, y = (Surface(*icosphere(n)) for n in (4, level + 1))
    nearest = (x.vertices @ y.vertices.T).argmax(axis=1)
    problem = MatchProblem(PreparedShape(x, parameters=FULL), PreparedShape(y, parameters=FULL))
    assert torn_share(problem, nearest) == 0


def test_a_wrong_map_onto_a_coarser_sphere_tears_the_seam() -> None:
    """Half of the sphere is turned by 90 degrees: the edges across the seam are torn, whatever the resolution of Y."""
    x = Surface(*icosphere(4))
    turned = np.where(x.vertices[:, 2:] > 0, x.vertices[:, [1, 0, 2]] * [-1, 1, 1], x.vertices)
    seam = (x.vertices[x.edges, 2] > 0).sum(axis=1) == 1
    for level in (2, 3, 4):
        y = Surface(*icosphere(level))
        nearest = (turned @ y.vertices.T).argmax(axis=1)
        shapes = PreparedShape(x, parameters=FULL), PreparedShape(y, parameters=FULL)
        share = torn_share(MatchProblem(*shapes), nearest)
        assert 0.5 * seam.mean() < share < 1.5 * seam.mean()


# -- shapes without a symmetry -------------------------------------------------------------------------------


def test_without_a_symmetry_the_asymmetry_is_not_a_number() -> None:
    """0 would be a perfect symmetry."""
    shape = Surface(*blob(2, 4, 0.35))
    found = qg.self_symmetry(shape)
    assert not found.found
    assert np.isnan(found.asymmetry).all()
    assert math.isnan(found.score)
    assert math.isnan(found.orientation)
    out = qg.SelfSymmetry()(shape)
    assert np.isnan(out.attributes["qgeo_asymmetry"]).all()
