"""D(S), eq. (5): zero for isometric poses, growing with their distortion, whatever the numbering."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.matching.compatibility import compatibility, compatibility_of_spectra
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface


def stretched(amounts: list[float]) -> list[Surface]:
    vertices, faces = blob(2, seed=3)
    return [Surface(vertices * [1, 1 + amount, 1], faces) for amount in amounts]


def test_isometric_poses_are_compatible() -> None:
    shape = stretched([0])[0]
    turned = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    poses = [shape, shape.with_vertices(3 * shape.vertices @ turned), shape.with_vertices(shape.vertices + 7)]
    result = compatibility(poses, k=8)
    # Distances are float32 from the graph method.
    assert result.d_s < 0.02
    assert (result.index == np.arange(8)).all()


def test_stretch_makes_poses_less_compatible() -> None:
    mild, strong = (compatibility(stretched([0, a, 2 * a]), k=8).d_s for a in (0.02, 0.1))
    assert 0 < mild < strong / 2


def test_mean_over_pairs_and_symmetry() -> None:
    result = compatibility(stretched([0, 0.05, 0.1, 0.15]), baselines=(1, 3), k=6, curvature_weight=0.0)
    assert result.baselines == (1, 3)
    np.testing.assert_array_equal(result.c_xy, result.c_xy.T)
    assert (np.diag(result.c_xy) == 0).all()
    assert result.d_s == pytest.approx(result.c_xy.sum() / 12)
    # Poses further apart in the sequence are less alike.
    assert result.c_xy[0, 3] > result.c_xy[0, 1]


def test_numbering_order_and_signs_do_not_matter() -> None:
    rng = np.random.default_rng(0)
    n, k = 150, 6
    functions = np.linalg.qr(rng.normal(size=(n, 3 * k)))[0][:, :k] * np.sqrt(n)
    values = np.arange(k, 0, -1.0)
    areas = np.full(n, 1 / n)

    def pose(noise: float) -> tuple[Spectrum, np.ndarray]:
        noisy = np.linalg.qr(functions + noise * rng.normal(size=(n, k)))[0] * np.sqrt(n)
        to_pose = rng.permutation(n)
        order = rng.permutation(k)
        own = np.empty((n, k))
        own[to_pose] = noisy[:, order] * rng.choice([-1, 1], k)
        return Spectrum(values[order], own, areas, ()), to_pose

    exact = [pose(0.0) for _ in range(4)]
    spectra, to_pose = zip(*exact, strict=True)
    maps = [image[np.argsort(to_pose[2])] for image in to_pose]
    result = compatibility_of_spectra(spectra, maps, baselines=(2, 0), k=k)
    assert result.d_s < 1e-9
    np.testing.assert_array_equal(np.diff(result.eigenvalues, axis=0), 0)
    spectra, to_pose = zip(*(pose(0.02) for _ in range(4)), strict=True)
    maps = [image[np.argsort(to_pose[2])] for image in to_pose]
    noisy = compatibility_of_spectra(spectra, maps, baselines=(2, 0), k=k)
    # Two functions with independent noise of .02 are about .02 * sqrt(2) apart each.
    assert noisy.d_s == pytest.approx(k * 0.02 * 2**0.5, rel=0.1)


@pytest.mark.parametrize(
    ("count", "baselines", "message"),
    [(1, (0, 1), "two poses or more"), (3, (0, 3), "out of 0 to 2"), (3, (1, 1), "two different poses")],
)
def test_bad_baselines_are_refused(count: int, baselines: tuple[int, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        compatibility(stretched([0.0] * count), baselines)


def test_maps_that_do_not_fit_are_refused() -> None:
    poses = stretched([0, 0.1])
    identity = np.arange(poses[0].n_vertices)
    with pytest.raises(ValueError, match="one map for each of the 2 poses"):
        compatibility(poses, maps=[identity])
    with pytest.raises(ValueError, match=r"maps\[1\] must hold a vertex for each of the 162"):
        compatibility(poses, maps=[identity, identity[:5]])


def test_poses_are_compatible_through_the_true_map(data_dir: Path) -> None:
    """Independently triangulated wolves: another map between the same poses is far worse."""
    data = ToscaRemeshed(data_dir / "tosca")
    names = data.names("wolf")
    poses = [data.read(name) for name in names]
    maps = [data.truth(names[0], name).images for name in names]
    true = compatibility(poses, k=10, maps=maps)
    # The wrong map keeps no point near its place, as vertices are in no order.
    wrong = compatibility(poses, k=10, maps=[np.roll(image, 100) if i else image for i, image in enumerate(maps)])
    assert true.d_s < 0.5 * wrong.d_s
