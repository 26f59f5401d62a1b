"""The demo: runs without network on PyMeshLab's cow, and what it says is true."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.caching import cache
from qgeo_filters.cli.demo import cow, errors_against_exact
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.filters import stages
from qgeo_filters.matching import intrinsic_shape
from qgeo_filters.matching.parameters import MatchingParameters

Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


def test_demo(qgeo: Callable[..., Result], loaded: Loaded, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pymeshlab")
    cache.clear()  # whatever other tests left there
    weights = []
    true = stages.distance_matrix
    for module in (stages, intrinsic_shape):  # where matrices are asked for
        monkeypatch.setattr(
            module,
            "distance_matrix",
            lambda *args, **kwargs: weights.append(args[1].curvature_weight) or true(*args, **kwargs),
        )
    result = qgeo("demo", "-o", "out")
    assert result.exit_code == 0
    # The symmetry takes all metrics, on a proxy; the spectrum and the table take two, at full resolution.
    assert sorted(weights) == sorted([*MatchingParameters().curvature_weights, 0.0, CURVATURE_WEIGHT])
    assert "libigl" in result.stdout
    assert "report.html in out" in result.stdout
    content, arrays = loaded(Path("out"))
    found = content["results"]
    assert found["mean_error_percent"] < 0.03
    assert found["max_error_percent"] < 0.3
    assert found["matrix_is_symmetric"] is True
    matrix = arrays["distances"]
    assert matrix.shape == (2904, 2904)
    np.testing.assert_array_equal(matrix, matrix.T)
    assert arrays["eigenvalues"].shape == (20,)
    surface = qg.Surface.read("out/cow.ply")
    areas = surface.vertex_areas
    functions = arrays["eigenfunctions"]
    np.testing.assert_allclose(functions.T @ (areas[:, None] * functions), np.eye(20), atol=1e-6)
    # Eigenfunctions of the operator: the residual of (K f)(p) = integral d(p, q) f(q) dA(q).
    image = matrix.astype(float) @ (areas[:, None] * functions[:, :6])
    residual = np.linalg.norm(image - functions[:, :6] * arrays["eigenvalues"][:6], axis=0)
    assert (residual < 1e-3 * np.linalg.norm(image, axis=0)).all()
    # The map mirrors left and right: it is the reflection in the plane x = 0, which the search is not told.
    mirror = cKDTree(surface.vertices).query(surface.vertices * [-1, 1, 1])[1]
    assert found["found"] is True
    assert found["map_error_against_the_plane"] < 0.01
    assert np.average(arrays["nearest"] == mirror, weights=areas) > 0.9
    x = surface.vertices[:, 0] / np.ptp(surface.vertices[:, 0])
    off_axis = (np.abs(x) > 0.05) & (arrays["side"] != 0)
    agreement = np.average(np.sign(x[off_axis]) == arrays["side"][off_axis], weights=areas[off_axis])
    assert max(agreement, 1 - agreement) > 0.99
    symmetry = arrays["symmetry"]
    np.testing.assert_array_equal(symmetry[symmetry], np.arange(2904))
    assert found["epsilon_of_mirror_images"] < 0.35 * found["epsilon_of_all_pairs"]
    assert found["largest_share_of_the_bound"] <= 1
    pictures = [name for name in content["files"] if name.endswith(".png")]
    assert {"eigenfunctions.png", "distance_matrix.png", "symmetry.png", "sides.png", "spectrum.png"} <= set(pictures)
    assert len(pictures) >= 4
    assert {
        "qgeo_delta",
        "qgeo_normal",
        "qgeo_scalar",
        "qgeo_phi",
        "qgeo_symmetry",
        "qgeo_side",
        "qgeo_asymmetry",
    } <= set(surface.attributes)


def test_error_table_finds_a_planted_error() -> None:
    surface = qg.testing.sample_surface()
    matrix = qg.distance_matrix(surface, method="exact").astype(float)
    assert max(largest for _, _, largest in errors_against_exact(surface, matrix)) < 1e-4
    worse = errors_against_exact(surface, 1.01 * matrix)
    assert all(mean == pytest.approx(1.0, abs=1e-3) for _, mean, _ in worse)
    assert len({source for source, _, _ in worse}) == 5


def test_demo_without_pymeshlab_says_what_to_install(
    qgeo: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *args: None if name == "pymeshlab" else find(name))
    result = qgeo("demo")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "pip install 'qgeo-filters[meshlab]'" in result.stderr
    assert not Path("qgeo-out").exists()


def test_demo_with_a_pymeshlab_without_meshes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("pymeshlab", tmp_path / "__init__.py")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: spec)
    with pytest.raises(qg.MissingPackageError, match=r"cow\.obj"):
        cow()
