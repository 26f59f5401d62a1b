"""``qgeo symmetry``: the true map of a symmetric shape, none where there is none, and eq. (3) for both."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.matching.symmetry_measure import symmetry_sum

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


def test_the_map_is_the_reflection(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("symmetry", "mirror.off").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/symmetry-mirror"))
    surface = qg.Surface.read("mirror.off")
    image = cKDTree(surface.vertices).query(surface.vertices * [-1, 1, 1])[1]
    np.testing.assert_array_equal(arrays["nearest"], image)
    assert bool(arrays["found"]) is content["results"]["found"] is True
    symmetry, side = arrays["symmetry"], arrays["side"]
    assert symmetry.dtype.kind == side.dtype.kind == "i"
    np.testing.assert_array_equal(symmetry[symmetry], np.arange(162))
    x = surface.vertices[:, 0]
    off_axis = np.abs(x) > 0.2
    assert len(np.unique(np.sign(x[off_axis]) * side[off_axis])) == 1
    assert arrays["asymmetry"].max() < 1e-3
    found = content["results"]
    assert found["epsilon_of_mirror_images"] < 0.01 * found["epsilon_of_all_pairs"]
    written = qg.Surface.read("qgeo-out/symmetry-mirror/mirror.ply").attributes
    np.testing.assert_array_equal(written["qgeo_symmetry"], symmetry)
    np.testing.assert_array_equal(written["qgeo_side"], side)
    np.testing.assert_allclose(written["qgeo_asymmetry"], arrays["asymmetry"])
    pictures = {"symmetry.png", "sides.png", "asymmetry.png", "symmetry_regions.png", "symmetry_sum.png"}
    assert pictures <= set(content["files"])


def test_no_symmetry_is_said_and_the_measure_stays(qgeo: Qgeo, loaded: Loaded) -> None:
    result = qgeo("symmetry", "sphere.ply")
    assert result.exit_code == 0
    content, arrays = loaded(Path("qgeo-out/symmetry-sphere"))
    found = content["results"]
    assert found["found"] is False
    assert "family" in found["reason"]
    assert found["epsilon_of_mirror_images"] is None
    np.testing.assert_array_equal(arrays["symmetry"], np.arange(162))
    assert not arrays["side"].any()
    written = qg.Surface.read("qgeo-out/symmetry-sphere/sphere.ply").attributes
    assert set(written) == {"colors", "quality", "qgeo_symmetry_sum", "qgeo_symmetry_region"}
    assert "symmetry_regions.png" in content["files"]
    assert "symmetry.png" not in content["files"]
    assert "No symmetry map was found" in Path("qgeo-out/symmetry-sphere/report.html").read_text(encoding="utf-8")


def test_measure_alone(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("symmetry", "blob.off", "--no-map", "--regions", 5, "-k", 12, "--reading", "printed").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/symmetry-blob"))
    surface = qg.Surface.read("blob.off")
    spectrum = qg.distance_spectrum(surface, 12, qg.lifted_metric(surface))
    np.testing.assert_allclose(arrays["symmetry_sum"], symmetry_sum(spectrum, reading="printed"), rtol=1e-5, atol=1e-5)
    assert content["results"]["regions"] == 5 == len(np.unique(arrays["regions"]))
    assert 0 < content["results"]["largest_share_of_the_bound"] <= 1
    assert "symmetry" not in arrays
    written = qg.Surface.read("qgeo-out/symmetry-blob/blob.ply").attributes
    np.testing.assert_array_equal(written["qgeo_symmetry_region"], arrays["regions"])
    assert {"symmetry_regions.png", "symmetry_sum.png"} <= set(content["files"])


def test_regions_of_a_given_width(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("symmetry", "blob.off", "--no-map", "--epsilon", 0.7, "--no-pictures").exit_code == 0
    _, arrays = loaded(Path("qgeo-out/symmetry-blob"))
    for label in np.unique(arrays["regions"]):
        assert np.ptp(arrays["symmetry_sum"][arrays["regions"] == label]) <= 0.7  # eq. (3) within each


def test_a_shape_that_cannot_have_a_map_is_refused_at_once(qgeo: Qgeo) -> None:
    result = qgeo("symmetry", "square.obj")
    assert result.exit_code == 2
    assert "at least 60 vertices, got 49" in result.stderr
    assert qgeo("symmetry", "square.obj", "--no-map", "--no-pictures").exit_code == 0


@pytest.mark.parametrize("option", [("--epsilon", "-1"), ("-k", "0")])
def test_bad_options(qgeo: Qgeo, option: tuple[str, str]) -> None:
    assert qgeo("symmetry", "mirror.off", *option).exit_code == 2
    assert not Path("qgeo-out").exists()
