"""Filters on meshes with something wrong: by default what a clean mesh gives, on the vertices that were given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import arched, blob, creature, icosphere

import qgeo_filters as qg
from qgeo_filters.closest_points import closest_points
from qgeo_filters.filters.repaired import repair_now
from qgeo_filters.surface import Surface

V, F = blob(2)
N = len(V)
CRUMB = np.array([[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0]])


def soup(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each face with corners of its own, a crumb and a vertex that is not finite; the clean vertex of each, or -1."""
    where = faces.ravel()
    points = np.concatenate([vertices[where], CRUMB, [[np.nan, 0, 0]]])
    own = np.arange(len(where) + 3).reshape(-1, 3)
    return points, own, np.concatenate([where, np.full(4, -1)])


ASIDE = np.array([1.0, 2, 3])
SOUP, SOUP_FACES, OF_CLEAN = soup(V, F)
HERE = OF_CLEAN >= 0


@pytest.mark.parametrize(
    "step",
    [
        qg.QuasiGeodesicSpectrum(k=4) | qg.SurfaceScalar(),
        qg.LaplacianSpectrum(k=4),
        qg.DifferentialCoordinates(),
        qg.Curvatures(),
    ],
    ids=lambda step: type(step).__name__,
)
def test_a_soup_gets_what_the_clean_mesh_gets(step: qg.Filter) -> None:
    clean = step.clone()((V, F)).attributes
    found = step((SOUP, SOUP_FACES))
    assert found.n_vertices == len(SOUP)
    assert step.repair_ is not None
    assert any("joined with others" in line for line in step.repair_.report)
    for name in step.outputs:
        # A soup cannot tell which corner came first, so that sums are rounded in another order.
        scale = np.abs(clean[name]).max()
        values = found.attributes[name][HERE]
        wanted = clean[name][OF_CLEAN[HERE]]
        signs = np.sign((values * wanted).sum(axis=0)) if name in ("qgeo_phi", "qgeo_laplacian_phi") else 1.0
        np.testing.assert_allclose(signs * values, wanted, atol=1e-4 * scale)


def test_what_can_be_taken_as_it_is_is_not_repaired() -> None:
    """Two pieces are no fault for distances, nor any mess for what looks at one vertex."""
    two = np.concatenate([V, V + 5]), np.concatenate([F, F + N])
    distances = qg.QuasiGeodesicDistances(sources=0)
    found = distances(two)
    assert distances.repair_ is None
    assert np.isfinite(found.attributes["qgeo_distance"][:N]).all()
    assert np.isinf(found.attributes["qgeo_distance"][N:]).all()
    paint = qg.TransferAttributes(source=Surface(V, F).with_attributes({"height": V[:, 2]}))
    holdable = SOUP[:-1], SOUP_FACES
    np.testing.assert_allclose(paint(holdable).attributes["height"][HERE[:-1]], V[OF_CLEAN[HERE], 2], atol=1e-9)
    assert paint.repair_ is None


def test_pieces_stay_where_the_filter_needs_no_single_one() -> None:
    two = np.concatenate([SOUP[: 3 * len(F)], SOUP[: 3 * len(F)] + 5])
    faces = np.arange(len(two)).reshape(-1, 3)
    found = qg.QuasiGeodesicDistances(sources=0, curvature_weight=0)((two, faces)).attributes["qgeo_distance"]
    wanted = qg.distances((V, F), [OF_CLEAN[0]], "cartesian")[0]
    assert np.isinf(found[3 * len(F) :]).all()
    np.testing.assert_allclose(found[: 3 * len(F)], wanted[OF_CLEAN[HERE]], rtol=2e-3, atol=1e-9)
    with pytest.raises(qg.MeshError, match=r"would remove 50 % of the area .*there are 2 pieces, of 320, 320 faces"):
        qg.QuasiGeodesicSpectrum(k=4)((two, faces))


def test_vertices_and_values_among_the_parameters_are_those_of_the_given_mesh() -> None:
    chosen = [900, 17]
    height = np.nan_to_num(SOUP[:, 2])
    step = qg.QuasiGeodesicDistances(sources=chosen, scalar=height)
    found = step((SOUP, SOUP_FACES)).attributes["qgeo_distance"]
    wanted = qg.distances((V, F), OF_CLEAN[chosen], qg.lifted_metric((V, F), V[:, 2]))
    np.testing.assert_allclose(found[HERE], wanted.T[OF_CLEAN[HERE]], rtol=2e-3, atol=1e-9)
    assert np.isinf(found[~HERE][:3]).all()  # the crumb is there, and cannot be reached
    assert np.isnan(found[~HERE][3:]).all()
    assert step.sources is chosen
    assert step.scalar is height
    with pytest.raises(qg.MeshError, match=rf"sources: {len(SOUP) - 1} had to go when the mesh was repaired"):
        qg.QuasiGeodesicDistances(sources=len(SOUP) - 1)((SOUP, SOUP_FACES))
    with pytest.raises(qg.MeshError, match="is vertex 5000"):
        qg.QuasiGeodesicDistances(sources=5000)((SOUP, SOUP_FACES))


def test_vertices_among_the_results_are_those_of_the_given_mesh() -> None:
    vertices, faces = creature(level=2)
    points, own, of_clean = soup(vertices, faces)
    step = qg.SelfSymmetry(k0=6)
    found = step((points, own)).attributes
    here = of_clean >= 0
    mirror = vertices[of_clean[here]] * [-1, 1, 1]
    edge = Surface(vertices, faces).edge_lengths.max()
    assert step.symmetry_.found
    assert (np.linalg.norm(points[found["qgeo_symmetry"][here]] - mirror, axis=1) < edge).all()
    assert (found["qgeo_symmetry"][~here] == -1).all()


@pytest.mark.slow
def test_hints_of_a_correspondence_are_vertices_of_the_given_mesh() -> None:
    """As for match, and taken and refused as there: one on a crumb beside the surface, and one on a crumb far away."""
    vertices, faces = creature(level=2)
    points, corners, of_clean = soup(vertices, faces)
    points[-4:-1] = vertices[7] + 0.01 * np.eye(3)  # the crumb
    far = len(points)
    points = np.concatenate([points[:-1], [[0, 0, 0]], CRUMB])
    mess, target = (points, np.concatenate([corners, [[far, far + 1, far + 2]]])), Surface(vertices, faces)
    labels = np.where(of_clean >= 0, of_clean % 3 // 2, -1)
    hints: list[dict[str, Any]] = [
        {"landmarks": [(far - 2, 7)]},
        {"landmarks": (points[[900, 17]], vertices[of_clean[[900, 17]]])},
        {"labels": (np.append(labels, [-1, -1, -1]), np.arange(len(vertices)) % 3 // 2)},
    ]
    for hint in hints:
        step = qg.Correspondence(target=target, **hint)
        found, wanted = step(mess).attributes, qg.match(mess, target, **hint)
        assert step.repair_ is not None
        np.testing.assert_array_equal(found["qgeo_correspondence"], wanted.p2p)
        np.testing.assert_array_equal(found["qgeo_distortion"], wanted.distortion)
        np.testing.assert_array_equal(step.correspondence_.landmark_errors, wanted.landmark_errors)
    for vertex in (far - 1, far + 1):
        said = []
        for refused in (qg.match, lambda x, y, landmarks: qg.Correspondence(target=y, landmarks=landmarks)(x)):
            with pytest.raises(
                qg.ParameterError, match=f"landmark 1 is vertex {vertex} of X, which had to go"
            ) as error:
                refused(mess, target, landmarks=[(0, int(of_clean[0])), (vertex, 7)])
            said.append(str(error.value))
        assert said[0] == said[1]
    with pytest.raises(qg.ParameterError, match="landmark 0 is vertex 9999 of X, which has"):
        qg.Correspondence(target=target, landmarks=[(9999, 7)])(mess)


def test_a_repair_goes_where_steps_before_have_moved_the_mesh() -> None:
    repair = qg.repair_surface((SOUP, SOUP_FACES))
    assert repair_now(None, repair.surface) is repair.surface
    assert repair_now(repair, repair.surface.with_attributes({"one": np.ones(N)})) is repair
    moved = repair_now(repair, repair.surface.with_vertices(repair.surface.vertices + ASIDE))
    assert isinstance(moved, qg.Repair)
    np.testing.assert_allclose(moved.given.vertices[HERE], SOUP[HERE] + ASIDE)
    np.testing.assert_allclose(moved.given.vertices[~HERE][:3], CRUMB)  # what is gone stays, as it does in the end
    np.testing.assert_allclose(moved.surface.vertices, repair.surface.vertices + ASIDE)
    other = Surface(V, F[::-1])
    assert repair_now(repair, other) is other  # a filter that repaired a mesh before is applied to another one


def test_a_refusal_that_repair_cannot_mend_is_the_filters_own() -> None:
    with pytest.raises(qg.MeshError, match="no attribute 'nothing'"):
        qg.Paint(attribute="nothing")((V, F))
    with pytest.raises(qg.DisconnectedError, match="needs a mesh in one piece"):
        qg.QuasiGeodesicSpectrum(k=4)((SOUP[:-1], SOUP_FACES), repair=False)
    assert qg.QuasiGeodesicSpectrum(k=4)(icosphere(1)).n_vertices == 42


@pytest.mark.slow
def test_the_other_mesh_is_wrapped_too() -> None:
    """What is matched, or gives attributes, may be as raw as the mesh itself, alone and in a pipeline."""
    vertices, faces = creature(level=3)
    x = qg.Surface(*in_pieces((vertices, faces)))
    y = qg.Surface(*in_pieces((arched(vertices, 0.3), faces), seed=1))
    y = y.with_attributes({"height": y.vertices[:, 2]})
    found = qg.match(x, y, repair="wrap")
    step = qg.Correspondence(target=y)
    with pytest.raises(qg.MeshError, match="repair='wrap'"):
        step(x)
    # At the resolution of the mesh, not of the wrap, alone and after other steps.
    for done in (step(x, repair="wrap"), (qg.Curvatures() | step)(x, repair="wrap")):
        np.testing.assert_array_equal(done.attributes["qgeo_correspondence"], found.p2p)
        np.testing.assert_array_equal(done.attributes["qgeo_distortion"], found.distortion)
        np.testing.assert_array_equal(done.attributes["qgeo_region"], found.regions_x)
    height = y.attributes["height"]
    for correspondence in (True, found):
        along = qg.TransferAttributes(source=y, correspondence=correspondence)
        np.testing.assert_array_equal(
            along(x, repair="wrap").attributes["height"], found.barycentric.pulled_back(height)
        )
    nearest = qg.TransferAttributes(source=y)(x, repair="wrap").attributes["height"]
    inside = found.p2p < 0
    np.testing.assert_array_equal(nearest[~inside], closest_points(x.vertices, y).pulled_back(height)[~inside])
    assert np.isnan(nearest[inside]).all()
    # Steps that follow see the values of the nearest vertex; a kind without a value for "none" gets one.
    rgb = y.with_attributes({"red": (np.arange(y.n_vertices) % 256).astype(np.uint8)})
    both = qg.TransferAttributes(source=rgb, names="red") | qg.Paint(attribute="red")
    done = both(x, repair="wrap").attributes
    assert done["red"].dtype == np.int64
    assert (done["red"][inside] == -1).all()
    assert np.isfinite(done["colors"][~inside]).all()
    with pytest.raises(qg.MeshError, match="repair='wrap'"):
        step(x)  # what was repaired for a call is forgotten at the next one


@pytest.mark.slow
def test_a_repair_stands_for_the_other_mesh_that_was_given() -> None:
    """Vertices of the target are those that were given, of a repair and of a wrap."""
    x = qg.Surface(*creature(level=3))
    points, corners, of_clean = soup(arched(x.vertices, 0.3), x.faces)
    target = qg.repair_surface((points[:-1], corners))
    images = qg.Correspondence(target=target)(x).attributes["qgeo_correspondence"]
    assert images.max() > x.n_vertices  # more were given than are left
    off = np.linalg.norm(x.vertices[of_clean[images]] - x.vertices, axis=1)
    assert off.mean() < 0.02 * np.sqrt(x.area)
    raw = qg.Surface(*in_pieces((arched(x.vertices, 0.3), x.faces), seed=1))
    wrap = qg.wrap_surface(raw, alpha=0.05)  # not that which "wrap" would make
    images = qg.Correspondence(target=wrap)(x).attributes["qgeo_correspondence"]
    np.testing.assert_array_equal(images, qg.match(x, wrap).p2p)
