"""STL and glTF are written in float32: what that does to a mesh is said, and rubble is not written."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

V, F = blob(2)
SURFACE = Surface(V, F)
EDGE = np.linalg.norm(V[F] - np.roll(V[F], 1, axis=1), axis=2).mean()
FORMATS = pytest.mark.parametrize("suffix", [".stl", ".glb"])


@FORMATS
@pytest.mark.parametrize("offset", [1e4, 1e5, 1e6])
def test_the_largest_shift_is_named_where_it_can_be_seen(tmp_path, suffix, offset):
    moved = V + np.array([0, offset, -offset])
    shifts = np.linalg.norm(moved.astype("f4") - moved, axis=1)
    assert shifts.max() > 1e-4 * EDGE
    expected = (
        rf"a{suffix}: written in float32: vertices move by up to {shifts.max():.3g} \(vertex {shifts.argmax()}\), "
        rf"{shifts.max() / EDGE:.3g} of the mean edge \(move the mesh to the origin, or write .ply\)"
    )
    with pytest.warns(UserWarning, match=expected) as caught:
        Surface(moved, F).write(tmp_path / f"a{suffix}")
    assert caught[0].filename == __file__  # the line of the caller, not one of ours


@FORMATS
@pytest.mark.parametrize("scale", [1e-30, 1e-9, 1, 1e9, 1e30])
@pytest.mark.filterwarnings("error")
def test_any_unit_of_length_is_kept_without_a_word(tmp_path, suffix, scale):
    SURFACE.with_vertices(scale * V).write(tmp_path / f"a{suffix}")
    written = Surface.read(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(written.vertices[written.faces], scale * V[F], rtol=1e-6, atol=1e-6 * scale)


@FORMATS
def test_what_float32_cannot_hold_is_not_written(tmp_path, suffix):
    huge = V.copy()
    huge[7, 1] = 1e39
    for vertices, message in (
        (huge, r"vertices\[7\] is .*, beyond what the format holds \(float32, 3.4e\+38; 1 such vertex\)"),
        (2.1e-45 * V, r"in float32, which the format holds, vertices move by up to .* of the mean edge; move the mesh"),
        (V + 1e9, r"in float32, which the format holds, vertices move by up to .* of the mean edge; move the mesh"),
    ):
        with pytest.raises(MeshError, match=rf"a{suffix}: {message}"):
            Surface(vertices, F).write(tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".ply", ".off", ".obj", ".vert", ".mat"])
@pytest.mark.parametrize(
    "vertices", [V + 1e9, 1e45 * V, 1e-44 * V, np.nextafter(V, 9)], ids=["far", "huge", "tiny", "next"]
)
def test_the_other_formats_lose_nothing(tmp_path, suffix, vertices):
    with warnings.catch_warnings(action="error"):
        Surface(vertices, F).write(tmp_path / f"a{suffix}")
        np.testing.assert_array_equal(Surface.read(tmp_path / f"a{suffix}").vertices, vertices)
