"""Pipelines: order, shared stages, YAML."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import qgeo_filters as qg
from qgeo_filters.filters import registry, stages
from qgeo_filters.testing import check_filter, sample_surface


def test_a_pipeline_is_a_filter() -> None:
    assert check_filter(qg.SurfaceScalar() | qg.QuasiGeodesicSpectrum(k=4) | qg.LaplacianSpectrum(k=3)) is None


def test_composition_is_flat_and_in_order() -> None:
    a, b, c = qg.DifferentialCoordinates(), qg.CorrectedNormals(), qg.SurfaceScalar()
    assert (a | (b | c)).steps == [a, b, c] == ((a | b) | c).steps
    assert (a | b | c)["SurfaceScalar"] is c
    with pytest.raises(KeyError, match="no step 'Paint'; the steps are DifferentialCoordinates"):
        (a | b)["Paint"]


def test_a_pipeline_gives_what_its_steps_give_one_by_one() -> None:
    surface = sample_surface()
    together = (qg.SurfaceScalar() | qg.QuasiGeodesicSpectrum(k=4))(surface)
    one_by_one = qg.QuasiGeodesicSpectrum(k=4)(qg.SurfaceScalar()(surface))
    for name, values in one_by_one.attributes.items():
        assert np.array_equal(together.attributes[name], values)


def test_an_earlier_attribute_can_be_the_scalar_of_a_later_metric() -> None:
    surface = sample_surface()
    pipe = qg.SurfaceScalar(scalar="shape_index") | qg.QuasiGeodesicDistances(scalar="qgeo_scalar")
    direct = qg.QuasiGeodesicDistances(scalar="shape_index")(surface)
    # f is scaled to unit deviation twice, which changes nothing but rounding; it is clipped twice as well.
    result = pipe(surface).attributes["qgeo_distance"]
    assert np.allclose(result, direct.attributes["qgeo_distance"], rtol=1e-2)
    assert not np.allclose(result, qg.QuasiGeodesicDistances(curvature_weight=0)(surface).attributes["qgeo_distance"])


def test_the_matrix_is_computed_once_whatever_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    true = stages.distance_matrix
    monkeypatch.setattr(stages, "distance_matrix", lambda *args, **kwargs: calls.append(1) or true(*args, **kwargs))
    qg.cache.clear()
    before = qg.cache.max_bytes
    qg.cache.configure(max_bytes=0)
    try:
        (qg.QuasiGeodesicSpectrum(k=3) | qg.QuasiGeodesicSpectrum(k=5) | qg.Curvatures())(sample_surface())
        assert len(calls) == 1
        qg.QuasiGeodesicSpectrum(k=3)(sample_surface())
        assert len(calls) == 2  # nothing is kept between calls with a bound of 0
    finally:
        qg.cache.configure(max_bytes=before)


def test_yaml_round_trip(tmp_path: Path) -> None:
    pipe = (
        qg.DifferentialCoordinates(weights="cotangent") | qg.SurfaceScalar(clip=(5, 95)) | qg.QuasiGeodesicSpectrum(k=7)
    )
    pipe.save(tmp_path / "pipe.yaml")
    again = qg.Pipeline.load(tmp_path / "pipe.yaml")
    assert repr(again) == repr(pipe)
    assert again.to_yaml() == pipe.to_yaml()


def test_yaml_by_hand() -> None:
    pipe = qg.Pipeline.from_yaml("qgeo_pipeline: 1\nsteps:\n- SurfaceScalar\n- Paint: {attribute: qgeo_scalar}\n")
    assert [type(step).__name__ for step in pipe.steps] == ["SurfaceScalar", "Paint"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("steps: [", "not valid YAML"),
        ("- a", "must be a mapping"),
        ("qgeo_pipeline: 2\nsteps: []", "format 2, this version reads qgeo_pipeline: 1"),
        ("qgeo_pipeline: 1\nsteps: [Sharpen]", r"steps\[0\]: unknown filter 'Sharpen'; known are"),
        ("qgeo_pipeline: 1\nsteps: [{Paint: {colour: red}}]", r"steps\[0\]: Paint has no parameter 'colour'"),
        ("qgeo_pipeline: 1\nsteps: [{Paint: 3}]", "parameters must be a mapping"),
        ("qgeo_pipeline: 1\nsteps: [3]", r"steps\[0\] must be one FilterName"),
        ("qgeo_pipeline: 1\nsteps: [{Paint: {1: 2}}]", "parameters must be a mapping by name"),
        ("qgeo_pipeline: 2001-13-45", "not valid YAML: month must be"),
        ("qgeo_pipeline: !!int ''", "not valid YAML"),
        (f"qgeo_pipeline: {9 * '9' * 999}", "not valid YAML"),
        (5000 * "[", "not valid YAML"),
        (f"qgeo_pipeline: 1\nsteps: [{999 * 'x'}]", r"unknown filter 'x+\.\.\.x+'"),
    ],
)
def test_bad_yaml_gets_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence) as caught:
        qg.Pipeline.from_yaml(text)
    assert "\n" not in str(caught.value)


def test_mappings_that_could_double_at_every_line_do_not() -> None:
    """Forty lines of merges would be more keys than there is memory for."""
    lines = ["m0: &m0 {a: 1, b: 2}"]
    lines += [f"m{i}: &m{i} {{<<: [{', '.join(9 * [f'*m{i - 1}'])}]}}" for i in range(1, 40)]
    with pytest.raises(qg.ParameterError, match="must be a mapping with qgeo_pipeline"):
        qg.Pipeline.from_yaml("\n".join(lines))


@pytest.mark.parametrize("content", [b"steps: [", b"\xff\xfe\x00", b"qgeo_pipeline: 1\nsteps: [Sharpen]"])
def test_a_bad_file_is_named(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "pipe.yaml").write_bytes(content)
    with pytest.raises(qg.ParameterError) as caught:
        qg.Pipeline.load(tmp_path / "pipe.yaml")
    assert str(caught.value).startswith(f"{tmp_path / 'pipe.yaml'}: ")
    assert str(caught.value).count("pipe.yaml") == 1


def test_a_pipeline_saved_before_weights_became_mass_still_loads() -> None:
    text = "qgeo_pipeline: 1\nsteps:\n- QuasiGeodesicSpectrum: {k: 3, weights: uniform}\n"
    with pytest.warns(DeprecationWarning, match="QuasiGeodesicSpectrum: weights is now called mass"):
        pipe = qg.Pipeline.from_yaml(text)
    assert pipe[0].get_params() == qg.QuasiGeodesicSpectrum(k=3, mass="uniform").get_params()
    assert "mass: uniform" in pipe.to_yaml()
    with pytest.warns(DeprecationWarning, match="QuasiGeodesicSpectrum: weights is now called mass") as caught:
        old = qg.QuasiGeodesicSpectrum(k=3, weights="uniform")  # type: ignore[call-arg]
    assert caught[0].filename == __file__
    assert repr(old) == repr(pipe[0])


def test_yaml_needs_no_host() -> None:
    """Saved pipelines are read where PyVista, whose accessor lives beside the filters, is not installed."""
    code = (
        "import sys; sys.modules['pyvista'] = sys.modules['pymeshlab'] = sys.modules['open3d'] = None\n"
        "import qgeo_filters as qg; print(qg.Pipeline.from_yaml('{qgeo_pipeline: 1, steps: [Paint]}'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.startswith("Pipeline([Paint(attribute='qgeo_scalar'"), done.stderr


def test_a_filter_of_ones_own_is_known_to_saved_pipelines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "REGISTRY", dict(registry.REGISTRY))
    for _ in range(2):  # a cell that is run twice

        @qg.registered
        class Sharpen(qg.Filter):
            """A filter from a notebook."""

    assert type(qg.Pipeline.from_yaml((Sharpen() | qg.Paint()).to_yaml())[0]) is Sharpen
    assert registry.registered_filters()["Sharpen"] is Sharpen
    with pytest.raises(qg.ParameterError, match=r"a filter Paint already, in qgeo_filters\.filters\.appearance"):
        qg.registered(type("Paint", (qg.Filter,), {}))
    assert registry.registered_filters()["Paint"] is qg.Paint


class _Blur(qg.Filter):
    """A filter with a parameter that happens to be called steps."""

    outputs = {"blur": "(n,), no unit: nothing"}

    def __init__(self, *, steps: int = 3) -> None:
        self.steps = steps

    def compute(self, surface: qg.Surface, progress: bool = False) -> dict[str, np.ndarray]:
        return {"blur": np.full(surface.n_vertices, self.steps)}


def test_a_filter_with_a_parameter_called_steps_is_no_pipeline() -> None:
    blur = _Blur(steps=5)
    assert check_filter(blur) is None
    pipeline = blur | qg.CorrectedNormals() | blur
    assert [type(step).__name__ for step in pipeline.steps] == ["_Blur", "CorrectedNormals", "_Blur"]
    assert (pipeline(sample_surface()).attributes["blur"] == 5).all()


def test_what_text_cannot_hold_is_named() -> None:
    with pytest.raises(ValueError, match=r"SurfaceScalar\.scalar is of type function"):
        qg.Pipeline([qg.SurfaceScalar(scalar=lambda delta: delta[:, 0])]).to_yaml()
