"""Spectra of meshes with something wrong are those of the clean mesh, on the vertices that were given."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from shapes import blob

import qgeo_filters as qg

V, F = blob(2)
N = len(V)
WHERE = np.concatenate([F.ravel(), np.full(4, -1)])  # the clean vertex of each corner; a crumb and a loose vertex
MESS = (
    np.concatenate([V[F.ravel()], [[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0], [np.nan, 0, 0]]]),
    np.arange(F.size + 3).reshape(-1, 3),
)
HERE = WHERE >= 0

SPECTRA: dict[str, Callable[..., qg.Spectrum]] = {
    "distance": lambda mesh, **options: qg.distance_spectrum(mesh, 4, **options),
    "landmarks": lambda mesh, **options: qg.landmark_spectrum(mesh, 4, landmarks=60, **options),
    "streamed": lambda mesh, **options: qg.streamed_spectrum(mesh, 4, landmarks=60, **options),
    "laplacian": lambda mesh, **options: qg.laplacian_spectrum(mesh, 4, **options),
}


@pytest.mark.parametrize("name", SPECTRA)
def test_a_mess_has_the_spectrum_of_the_clean_mesh(name: str) -> None:
    found, wanted = SPECTRA[name](MESS), SPECTRA[name]((V, F))
    np.testing.assert_allclose(found.eigenvalues, wanted.eigenvalues, rtol=2e-3, atol=1e-9)
    phi, expected = found.eigenfunctions[HERE], wanted.eigenfunctions[WHERE[HERE]]
    np.testing.assert_allclose(phi * np.sign((phi * expected).sum(axis=0)), expected, atol=1e-2)
    assert np.isnan(found.eigenfunctions[~HERE]).all()
    # Orthonormal over the vertices that are left, each with its share of the area.
    assert not found.areas[~HERE].any()
    gram = phi.T @ (found.areas[HERE, None] * phi)
    np.testing.assert_allclose(gram, np.eye(4), atol=1e-9)
    np.testing.assert_allclose(np.bincount(WHERE[HERE], found.areas[HERE]), wanted.areas, rtol=1e-6)
    assert not found.areas.flags.writeable
    assert not found.eigenfunctions.flags.writeable
    with pytest.raises(qg.MeshError, match="finite"):
        SPECTRA[name](MESS, repair=False)
    with pytest.raises(qg.DisconnectedError, match="needs a mesh in one piece"):
        SPECTRA[name]((MESS[0][:-1], MESS[1]), repair=False)


def test_landmarks_are_vertices_of_the_given_mesh() -> None:
    chosen = np.flatnonzero(np.diff(WHERE[HERE], prepend=-1))[:200:4]
    chosen = chosen[np.sort(np.unique(WHERE[chosen], return_index=True)[1])]
    found = qg.landmark_spectrum(MESS, 3, landmarks=chosen)
    wanted = qg.landmark_spectrum((V, F), 3, landmarks=WHERE[chosen])
    np.testing.assert_allclose(found.eigenvalues, wanted.eigenvalues, rtol=2e-3)
    with pytest.raises(qg.MeshError, match=f"landmarks: {len(WHERE) - 1} had to go when the mesh was repaired"):
        qg.landmark_spectrum(MESS, 3, landmarks=[*chosen, len(WHERE) - 1])


def test_a_metric_of_the_callers_is_that_of_the_mesh_as_it_is() -> None:
    """It has lengths for the edges that the mesh has, not for those of a repaired one."""
    loose = qg.Surface(np.nan_to_num(MESS[0]), MESS[1])
    with pytest.raises(qg.DisconnectedError, match="not welded"):
        qg.distance_spectrum(loose, 3, qg.lifted_metric(loose))


def test_compatibility_of_a_mess_with_the_clean_mesh() -> None:
    """Maps name vertices of the files, given ones too."""
    other = V * [1.1, 1.0, 0.9]
    clean = qg.compatibility([(V, F), (other, F)], k=3)
    first = np.concatenate([WHERE[HERE], np.zeros(4, int)])  # of what is gone, any: it is not looked at
    found = qg.compatibility([MESS, (other, F)], k=3, maps=[np.arange(len(WHERE)), first])
    assert found.d_s == pytest.approx(clean.d_s, abs=2e-2)
    np.testing.assert_array_equal(found.maps[1][HERE], WHERE[HERE])
    np.testing.assert_array_equal(found.maps[1][~HERE], -1)
    assert found.maps[0][HERE].max() < F.size
    with pytest.raises(qg.MeshError, match=r"maps\[1\] leads to vertices that had to go"):
        qg.compatibility([(V, F), MESS], k=3, maps=[np.arange(N), np.full(N, len(WHERE) - 1)])
