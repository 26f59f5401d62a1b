"""Filters as objects: parameters, purity, composition, repair."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from shapes import bow_tie, icosphere

import qgeo_filters as qg
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered_filters
from qgeo_filters.geodesics import methods
from qgeo_filters.geodesics.dijkstra import EdgeDistances
from qgeo_filters.parallel import worker_count
from qgeo_filters.testing import check_filter, sample_surface

# Each filter's own example, so that a new one is tried without being listed here; and some with other parameters.
EXAMPLES = [cls.example(sample_surface()) for cls in registered_filters().values()]
VARIANTS = [
    qg.DifferentialCoordinates(weights="cotangent"),
    qg.SurfaceScalar(scalar="gaussian_curvature", smoothing=0.05),
    qg.QuasiGeodesicDistances(sources=[3, 7], curvature_weight=0.0, method="exact"),
    qg.QuasiGeodesicPath(start=3, end=60, method="edges"),
    qg.QuasiGeodesicSpectrum(k=6, mass="uniform"),
    qg.TransferAttributes(source=(sample_surface().vertices, sample_surface().faces), names=[]),
]


@pytest.mark.parametrize("filter", EXAMPLES + VARIANTS, ids=lambda filter: type(filter).__name__)
def test_every_filter_keeps_the_contract(filter: Filter) -> None:
    """The package's own conformance suite; it raises AssertionError with a sentence."""
    assert check_filter(filter) is None


def test_every_registered_filter_is_public_and_its_example_is_of_its_kind() -> None:
    for name, cls in registered_filters().items():
        assert getattr(qg, name) is cls
        example = cls.example(sample_surface())
        assert type(example.steps[-1] if isinstance(example, qg.Pipeline) else example) is cls


def test_parameters_are_given_by_name_but_what_a_filter_is_about() -> None:
    assert qg.Paint("height").get_params() == qg.Paint(attribute="height").get_params()
    for cls in registered_filters().values():
        with pytest.raises(TypeError, match=f"{cls.__name__}.*positional argument"):
            cls("height", 3) if cls is qg.Paint else cls(3)


@pytest.mark.parametrize("workers", [0, -1, 1.5])
def test_a_number_of_threads_that_is_none_is_refused(workers: float) -> None:
    with pytest.raises(qg.ParameterError, match=r"workers must be .*(whole number|at least 1)"):
        qg.DifferentialCoordinates()(sample_surface(), workers=workers)


def test_workers_bound_the_threads_of_every_step_and_change_no_result() -> None:
    seen = []

    class Counting(Filter):
        """Notes how many threads the call may use."""

        def compute(self, surface: qg.Surface, progress: bool = False) -> dict[str, np.ndarray]:
            seen.append(worker_count())
            return {}

    pipeline = Counting() | qg.QuasiGeodesicDistances(sources=[1, 2, 3], accuracy=2e-3) | Counting()
    results = []
    for workers in (3, 1, None):
        qg.cache.clear()
        results.append(pipeline(sample_surface(), workers=workers).attributes["qgeo_distance"])
    assert seen == [3, 3, 1, 1, *[worker_count()] * 2]
    assert all(np.array_equal(result, results[0]) for result in results)


def test_outputs_of_a_transfer_cost_nothing_and_never_fail(tmp_path: Path) -> None:
    source = sample_surface().with_attributes({"height": sample_surface().vertices[:, 2]})
    missing = qg.TransferAttributes(source=tmp_path / "not_there.ply")
    assert missing.outputs == {}
    assert (missing | qg.Curvatures()).outputs == qg.Curvatures.outputs
    assert set(qg.TransferAttributes(source=tmp_path / "not_there.ply", names=["a"]).outputs) == {"a"}
    assert set(qg.TransferAttributes(source="not_there.ply", names="height").outputs) == {"height"}
    assert qg.TransferAttributes().outputs == {}
    source.write(tmp_path / "source.ply")
    fromfile = qg.TransferAttributes(source=tmp_path / "source.ply")
    assert fromfile.outputs == {}
    assert fromfile(source).attributes["height"] == pytest.approx(source.vertices[:, 2])
    assert set(fromfile.outputs) == {"height"}  # known now
    assert fromfile.clone().outputs == {}
    assert check_filter(fromfile) is None


def test_an_assertion_of_the_suite_is_raised_under_python_o() -> None:
    code = """
import qgeo_filters as qg
from qgeo_filters.testing import check_filter
class Shy(qg.Filter):
    def __init__(self, radius=1, steps=2):
        self.radius, self.steps = radius, steps
try:
    check_filter(Shy())
except AssertionError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-O", "-c", code], capture_output=True, text=True)
    expected = "Shy: parameter steps can be given by position; put * behind the first, which says what it is about\n"
    assert done.stdout == expected, done.stderr


class _Broken(Filter):
    """A filter that breaks one rule, to see that the suite notices."""

    outputs = {"qgeo_broken": "(n,)"}

    def __init__(self, *, how: str = "none") -> None:
        self.how = how
        if how == "constructor":
            self.extra = 1

    def compute(self, surface: qg.Surface, progress: bool = False) -> dict[str, np.ndarray]:
        if self.how == "names":
            return {"qgeo_other": np.zeros(surface.n_vertices)}
        if self.how == "random":
            return {"qgeo_broken": np.random.default_rng().normal(size=surface.n_vertices)}
        if self.how == "kept random":
            kept = qg.cache.get("broken-random", lambda: np.random.default_rng().normal(size=surface.n_vertices))
            return {"qgeo_broken": kept}
        if self.how == "nan":
            return {"qgeo_broken": np.full(surface.n_vertices, np.nan)}
        if self.how == "parameter":
            self.how = "changed"
        return {"qgeo_broken": np.zeros(surface.n_vertices)}


def test_the_suite_accepts_a_good_filter() -> None:
    assert check_filter(_Broken()) is None


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ("constructor", "sets more than its parameters"),
        ("names", "outputs declares"),
        ("random", "two calls disagree"),
        ("kept random", "two calls disagree"),  # which the cache hid
        ("nan", "holds NaN"),
        ("parameter", "changed the parameter how"),
    ],
)
def test_the_suite_notices_a_broken_filter(how: str, sentence: str) -> None:
    with pytest.raises(AssertionError, match=sentence):
        check_filter(_Broken(how=how))


def test_unknown_parameter_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="QuasiGeodesicSpectrum has no parameter 'K'; it has k, scalar"):
        qg.QuasiGeodesicSpectrum().set_params(K=3)


def test_repr_evaluates_to_an_equal_filter() -> None:
    filter = qg.QuasiGeodesicSpectrum(k=7, curvature_weight=0.1)
    again = eval(repr(filter), {"QuasiGeodesicSpectrum": qg.QuasiGeodesicSpectrum})
    assert again.get_params() == filter.get_params()


def test_a_broken_mesh_is_refused_and_taken_when_repaired() -> None:
    vertices, faces = icosphere(2)
    # A second sphere that touches the first in one vertex: that vertex has two fans.
    touching = np.concatenate([vertices, 0.3 * vertices[1:] + 1.3 * vertices[0]])
    # Vertex 0 of the small sphere is replaced by the big one's.
    second = np.where(faces == 0, 0, faces + len(vertices) - 1)
    both = np.concatenate([faces, second])
    spectrum = qg.QuasiGeodesicSpectrum(k=4)
    with pytest.raises(qg.NonManifoldError, match=r"vertex 0 form more than one fan \(1 such vertex: 0\)"):
        spectrum((touching, both), repair=False)
    with pytest.raises(qg.MeshError, match=r"would remove 9\.\d+ % of the area .* pieces, of 320, 320 faces"):
        spectrum((touching, both), repair=True)
    result = spectrum((touching, both), repair="force")
    assert result.n_vertices == len(touching)
    phi = result.attributes["qgeo_phi"]
    # The larger sphere is kept, the rest has no value rather than a made-up one.
    assert np.isfinite(phi[: len(vertices)]).all()
    assert np.isnan(phi[len(vertices) :]).all()
    assert spectrum.repair_ is not None
    assert spectrum.repair_.report
    clean = spectrum((vertices, faces))
    assert spectrum.repair_ is None
    assert np.allclose(np.abs(clean.attributes["qgeo_phi"][:, 0]), np.abs(phi[: len(vertices), 0]), rtol=1e-4)


def test_bow_tie_names_the_vertex() -> None:
    with pytest.raises(qg.NonManifoldError, match="vertex 0"):
        qg.QuasiGeodesicDistances()(bow_tie(), repair=False)


def test_paint_says_which_attributes_there_are() -> None:
    with pytest.raises(qg.MeshError, match="no attribute 'qgeo_phi' to paint; the mesh has qgeo_delta"):
        (qg.DifferentialCoordinates() | qg.Paint(attribute="qgeo_phi"))(icosphere(1))


def test_paint_maps_the_range_to_the_map_and_the_rest_to_grey() -> None:
    surface = sample_surface()
    values = surface.vertices[:, 0].copy()
    values[5] = np.inf
    painted = qg.Paint(attribute="x", colormap="viridis")(surface.with_attributes({"x": values}))
    colors = painted.attributes["colors"]
    assert np.allclose(colors[5], 0.6)
    assert np.allclose(colors[np.argmin(values)], [0.267004, 0.004874, 0.329415])  # first colour of viridis
    finite = np.where(np.isfinite(values), values, -np.inf)
    assert np.allclose(colors[np.argmax(finite)], [0.993248, 0.906157, 0.143936])  # and its last


def test_transfer_is_exact_for_linear_functions_on_flat_triangles() -> None:
    """Barycentric interpolation reproduces a linear function at any point of the source."""
    source = sample_surface()
    linear = source.vertices @ np.array([1.0, -2.0, 0.5])
    source = source.with_attributes({"f": linear, "label": np.arange(source.n_vertices) % 3})
    rng = np.random.default_rng(0)
    weights = rng.dirichlet(np.ones(3), size=source.n_faces)
    points = np.einsum("ij,ijk->ik", weights, source.vertices[source.faces])
    target = qg.Surface(points, [[0, 1, 2]])
    result = qg.TransferAttributes(source=source)(target)
    assert np.allclose(result.attributes["f"], points @ np.array([1.0, -2.0, 0.5]), atol=1e-9)
    nearest = source.faces[np.arange(source.n_faces), weights.argmax(axis=1)]
    assert np.array_equal(result.attributes["label"], nearest % 3)


def test_transfer_along_a_correspondence() -> None:
    """From a turned copy with its vertices in another order: closest points in space would mean nothing."""
    target = sample_surface()
    order = np.random.default_rng(1).permutation(target.n_vertices)
    turned = target.vertices[order] @ np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    height = target.vertices[order, 2]
    attributes = {"height": height, "label": (height > 0).astype(int)}
    source = qg.Surface(turned, np.argsort(order)[target.faces], attributes)
    found = qg.Correspondence(target=source)
    result = (found | qg.TransferAttributes(source=source, correspondence=True))(target)
    reach = np.ptp(target.vertices[:, 2])
    assert np.abs(result.attributes["height"] - target.vertices[:, 2]).mean() < 0.02 * reach
    assert (result.attributes["label"] == (target.vertices[:, 2] > 0)).mean() > 0.95
    given = qg.TransferAttributes(source=source, names=["height"], correspondence=found.correspondence_)(target)
    assert np.array_equal(given.attributes["height"], result.attributes["height"])
    assert "label" not in given.attributes
    with pytest.raises(qg.MeshError, match=r"the correspondence maps .* vertices"):
        qg.TransferAttributes(source=source, correspondence=found.correspondence_)(qg.Surface(*icosphere(1)))


def test_the_path_is_as_long_as_the_distance_and_lies_in_the_marked_triangles() -> None:
    surface = sample_surface()
    filter = qg.QuasiGeodesicPath(start=5, end=120, curvature_weight=0.05)
    marks = filter(surface).attributes["qgeo_path"]
    exact = qg.QuasiGeodesicDistances(sources=5, curvature_weight=0.05, method="exact")(surface).attributes[
        "qgeo_distance"
    ]
    assert filter.path_.length == pytest.approx(exact[120], rel=1e-9)
    assert marks[[5, 120]].tolist() == [1, 1]
    assert 0 < marks.sum() < surface.n_vertices


def test_a_method_of_ones_own_is_known_to_filters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(methods, "METHODS", dict(methods.METHODS))
    qg.register_method("on foot", EdgeDistances.of)
    for kind, name in ((qg.QuasiGeodesicDistances, "qgeo_distance"), (qg.QuasiGeodesicSpectrum, "qgeo_phi")):
        own, edges = (kind(method=method)(sample_surface()).attributes[name] for method in ("on foot", "edges"))
        assert np.array_equal(own, edges)


def test_the_first_path_can_be_sought_along_edges() -> None:
    surface = sample_surface()
    metric = qg.lifted_metric(surface)
    for method in ("exact", "edges"):
        filter = qg.QuasiGeodesicPath(start=5, end=120, method=method)
        filter(surface)
        expected = qg.quasi_geodesic(surface, 5, 120, metric, initial=method)
        assert np.array_equal(filter.path_.points, expected.points)
        assert np.array_equal(filter.path_.initial_points, expected.initial_points)
    assert set(map(tuple, filter.path_.initial_points)) <= set(map(tuple, surface.vertices))
    with pytest.raises(qg.ParameterError, match="method must be one of 'exact', 'edges', got 'graph'"):
        qg.QuasiGeodesicPath(method="graph")(surface)  # type: ignore[arg-type]


def test_regions_of_eq_3_agree_with_the_mirror_image() -> None:
    """A surface that is mirrored in x = 0, vertex by vertex, has the same measure on both sides."""
    vertices, faces = icosphere(3)
    x, y, z = vertices.T
    lopsided = vertices * (1 + 0.3 * y + 0.25 * z * y - 0.2 * z + 0.3 * x**2 * z)[:, None]
    image = np.array([np.argmin(np.abs(vertices - vertices[i] * [-1, 1, 1]).sum(axis=1)) for i in range(len(vertices))])
    assert np.array_equal(image[image], np.arange(len(vertices)))
    filter = qg.SelfSymmetry(k0=12, n_regions=5)
    result = filter((lopsided, faces))
    values = result.attributes["qgeo_symmetry_sum"]
    assert np.sqrt(np.mean((values - values[image]) ** 2)) < 0.02 * filter.epsilon_
    regions = result.attributes["qgeo_symmetry_region"]
    assert (regions == regions[image]).mean() > 0.97  # all but vertices beside a limit
    assert set(regions) == set(range(5))
