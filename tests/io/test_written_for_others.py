"""Files that are written for other programs: colours and attributes, as each of them finds these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

V, F = blob(1)
N = len(V)
RNG = np.random.default_rng(5)
COLORS = RNG.integers(0, 256, (N, 3), dtype=np.uint8)
ATTRIBUTES: dict[str, Any] = {
    "colors": COLORS,
    "quality": RNG.random(N),
    "where": np.where(np.arange(N) % 7, RNG.random(N), np.nan),
    "numbers": np.arange(N) - 2**40,
    "small": np.arange(N, dtype=np.int16),
    "phi": RNG.random((N, 20)),
    'n "<&> é': RNG.random((N, 3)),
}
SURFACE = Surface(V * np.pi, F).with_attributes(ATTRIBUTES)


@pytest.mark.parametrize("suffix", [".vtp", ".vtu"])
def test_vtk_files_give_back_every_bit(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("vtkmodules")
    SURFACE.write(tmp_path / f"a{suffix}")
    back = Surface.read(tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(back.vertices, SURFACE.vertices)
    np.testing.assert_array_equal(back.faces, F)
    assert list(back.attributes) == list(ATTRIBUTES)
    for name, values in ATTRIBUTES.items():
        assert back.attributes[name].dtype == values.dtype, name
        np.testing.assert_array_equal(back.attributes[name], values)


def test_pyvista_shows_the_colours_of_vtk_files_and_meshio_has_the_arrays(tmp_path: Path) -> None:
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    for suffix in (".vtp", ".vtu"):
        SURFACE.write(tmp_path / f"a{suffix}")
        mesh = pyvista.read(tmp_path / f"a{suffix}")
        assert mesh.active_scalars_name == "colors"
        assert mesh.active_scalars.dtype == np.uint8
        assert mesh.n_cells == len(F)
    mesh = meshio.read(tmp_path / "a.vtu")
    np.testing.assert_array_equal(mesh.cells_dict["triangle"], F)
    for name, values in ATTRIBUTES.items():
        np.testing.assert_array_equal(mesh.point_data[name], values)


def test_kinds_of_numbers_that_vtk_lacks_are_written_as_what_they_are(tmp_path: Path) -> None:
    pytest.importorskip("vtkmodules")
    given = {
        "flag": np.arange(N) % 3 == 0,
        "half": np.linspace(0, 1, N).astype(np.float16),
        "waves": np.exp(1j * np.arange(N)),
        "colors": np.linspace(0, 1, 3 * N).reshape(N, 3),
        "big": np.arange(N).astype(">i4"),
    }
    SURFACE.with_attributes(given).write(tmp_path / "a.vtp")
    back = Surface.read(tmp_path / "a.vtp").attributes
    np.testing.assert_array_equal(back["flag"], given["flag"])
    np.testing.assert_array_equal(back["half"], given["half"])
    np.testing.assert_array_equal(back["waves"] @ [1, 1j], given["waves"])
    np.testing.assert_array_equal(back["colors"], np.rint(given["colors"] * 255))
    np.testing.assert_array_equal(back["big"], given["big"])
    with pytest.raises(MeshError, match=r"a.vtp: attribute 'names' of dtype <U1 cannot be held by a VTK file"):
        SURFACE.with_attributes({"names": np.full(N, "a")}).write(tmp_path / "a.vtp")
    assert Surface.read(tmp_path / "a.vtp").n_faces == len(F)  # the file of before


def test_glb_has_linear_colours_and_narrow_attributes(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match=r"holds no such attributes, dropped: 'numbers', 'phi', 'where' \(write .ply"):
        SURFACE.write(tmp_path / "a.glb")
    back = Surface.read(tmp_path / "a.glb")
    np.testing.assert_array_equal(back.faces, F)
    shade = COLORS / 255
    linear = np.where(shade <= 0.04045, shade / 12.92, ((shade + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    np.testing.assert_array_equal(back.attributes["colors"], np.column_stack([np.rint(255 * linear), [255] * N]))
    for name in ("quality", "small", 'n "<&> é'):
        np.testing.assert_array_equal(back.attributes[name], ATTRIBUTES[name].astype(np.float32))


def test_obj_and_ply_have_colours_where_others_look_for_them(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    surface = Surface(V, F).with_attributes({"colors": COLORS, "quality": ATTRIBUTES["quality"]})
    with pytest.warns(UserWarning, match="'quality'"):
        surface.write(tmp_path / "a.obj")
    np.testing.assert_allclose(Surface.read(tmp_path / "a.obj").attributes["colors"] * 255, COLORS, atol=1e-3)
    surface.write(tmp_path / "a.ply")
    for suffix in (".obj", ".ply"):
        mesh = trimesh.load(tmp_path / f"a{suffix}", process=False)
        np.testing.assert_array_equal(mesh.visual.vertex_colors[:, :3], COLORS)
