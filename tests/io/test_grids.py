"""VTK's and Gmsh's files, in each of their forms, and damaged ones, which must not reach the user's process."""

from __future__ import annotations

import re
import subprocess

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError
from qgeo_filters.io import grids
from qgeo_filters.surface import Surface

V, F = blob(1)
VALUES = {"f": V[:, 0].copy(), "two words": V * 2, "number": np.arange(len(V))}
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)


def polydata():
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData.from_regular_faces(V, F)
    for name, values in VALUES.items():
        mesh.point_data[name] = values
    return mesh


def gmsh_text(faces, kind, points=SQUARE):
    """A file of version 2.2 with its nodes and cells of one kind."""
    nodes = "\n".join(f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(points))
    cells = "\n".join(f"{i + 1} {kind} 2 0 1 {' '.join(str(c + 1) for c in face)}" for i, face in enumerate(faces))
    return (
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n{nodes}\n$EndNodes\n"
        f"$Elements\n{len(faces)}\n{cells}\n$EndElements\n"
    )


@pytest.mark.parametrize("form", ["vtk", "vtk text", "vtp", "vtk grid", "vtu", "vtu text"])
def test_vtk_files_and_their_point_data(tmp_path, form):
    mesh = polydata()
    if "grid" in form or "vtu" in form:
        mesh = mesh.cast_to_unstructured_grid()
    file = tmp_path / f"mesh 1.{form.split()[0]}"
    mesh.save(file, binary="text" not in form)
    surface = Surface.read(file)
    np.testing.assert_allclose(surface.vertices, V, rtol=1e-6 if "text" in form else 0)
    np.testing.assert_array_equal(surface.faces, F)
    assert set(surface.attributes) == set(VALUES)
    for name, values in VALUES.items():
        np.testing.assert_allclose(surface.attributes[name], values, rtol=1e-6, err_msg=name)


def test_strips_of_vtk(tmp_path):
    text = "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 1 1 0\n"
    (tmp_path / "a.vtk").write_text(text + "TRIANGLE_STRIPS 1 5\n4 0 1 2 3\n")
    surface = Surface.read(tmp_path / "a.vtk")
    assert surface.area == 1
    np.testing.assert_array_equal(surface.face_normals, [[0, 0, 1]] * 2)


@pytest.mark.parametrize("form", ["2.2 text", "2.2", "4.1 text", "4.1"])
def test_gmsh_files_and_their_node_data(tmp_path, form):
    meshio = pytest.importorskip("meshio")
    version, _, text = form.partition(" ")
    cells = [("triangle", F)] + ([("line", F[:3, :2]), ("vertex", F[:1, :1])] if version == "2.2" else [])
    mesh = meshio.Mesh(V, cells, point_data={"f": VALUES["f"]})
    file = tmp_path / "a.msh"
    meshio.gmsh.write(file, mesh, version, binary=not text)
    if text:  # meshio writes numbers as NumPy 2 shows them: np.float64(0.5)
        file.write_text(re.sub(r"np\.float64\((.*)\)", r"\1", file.read_text()))
    surface = Surface.read(file)
    np.testing.assert_allclose(surface.vertices, V, rtol=1e-15)
    np.testing.assert_array_equal(surface.faces, F)
    np.testing.assert_allclose(surface.attributes["f"], VALUES["f"], rtol=1e-15)


def test_meshes_of_fluent_are_no_files_of_gmsh(tmp_path):
    meshio = pytest.importorskip("meshio")
    meshio.ansys.write(tmp_path / "a.msh", meshio.Mesh(V, [("triangle", F)]))
    with pytest.raises(MeshError, match=r"a.msh: not a readable .msh file \(it is no Gmsh file of version 2 or 4, as"):
        Surface.read(tmp_path / "a.msh")


def test_solids_and_curved_cells_of_gmsh(tmp_path):
    pytest.importorskip("meshio")
    file = tmp_path / "a.msh"
    file.write_text(gmsh_text([[0, 1, 3, 2]], 4, np.vstack([SQUARE[[0, 1, 3]], [[0, 0, 1]]])))
    with pytest.raises(MeshError, match=r"a.msh: it holds a solid of 1 tetrahedra, no surface; repair=True takes"):
        Surface.read(file)
    solid = Surface.read(file, repair=True)
    assert (solid.n_faces, solid.is_closed) == (4, True)
    file.write_text(gmsh_text([[0, 1, 2, 3, 1, 2]], 9))
    with pytest.raises(MeshError, match="it has cells of kind triangle6; save it as a mesh of order 1"):
        Surface.read(file)


VTK_HEAD = "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\n"
DAMAGED = {
    "empty.vtk": "",
    "text.vtk": "hello\n",
    "huge.vtk": VTK_HEAD + "POINTS 99999999999 float\n0 0 0\nPOLYGONS 1 4\n3 0 1 2\n",
    "cut.vtk": VTK_HEAD + "POINTS 4 float\n0 0 0 1 0",
    "image.vtk": VTK_HEAD.replace("POLYDATA", "STRUCTURED_POINTS") + "DIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n",
    "no faces.vtk": VTK_HEAD + "POINTS 1 float\n0 0 0\n",
    "range.vtk": VTK_HEAD + "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 7\n",
    "text.vtp": "<VTKFile",
    "other.vtp": '<VTKFile type="ImageData"></VTKFile>',
    "empty.vtu": "",
    "empty.msh": "",
    "text.msh": "hello\n",
    "huge.msh": gmsh_text([[0, 1, 2]], 2).replace("$Nodes\n4", "$Nodes\n99999999999"),
    "many.msh": gmsh_text([[0, 1, 2]], 2).replace("$Elements\n1", "$Elements\n99999999999"),
    "cut.msh": gmsh_text([[0, 1, 2]], 2)[:90],
    "range.msh": gmsh_text([[0, 1, 8]], 2),
    "kind.msh": gmsh_text([[0, 1, 2]], 999),
}


def test_vtk_gives_its_reason_and_bytes_that_are_no_text_do_no_harm(tmp_path):
    pytest.importorskip("vtkmodules")
    file = tmp_path / "a.vtk"
    file.write_bytes(VTK_HEAD.encode() + b"POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n\xff\xfe 3\n")
    with pytest.raises(MeshError, match=r"not a readable .vtk file \(Unrecognized keyword"):
        Surface.read(file)
    head = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS "
    file.write_bytes((VTK_HEAD + head).encode() + b"\xff\xfe float\nLOOKUP_TABLE default\n1 2 3\n")
    (values,) = Surface.read(file).attributes.values()
    np.testing.assert_array_equal(values, [1, 2, 3])


@pytest.mark.parametrize("name", DAMAGED)
def test_damage_is_said_in_a_line_and_nothing_reaches_the_terminal(tmp_path, name, capfd):
    pytest.importorskip("meshio" if name.endswith(".msh") else "vtkmodules")
    (tmp_path / name).write_text(DAMAGED[name])
    with pytest.raises(MeshError) as caught:
        Surface.read(tmp_path / name)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / name}: ")
    assert "\n" not in message
    assert not message.endswith("()")
    assert len(message) < 400 + len(str(tmp_path))
    assert capfd.readouterr() == ("", "")


def test_files_that_kill_vtk_or_hold_it_up_are_the_files_fault(tmp_path, monkeypatch):
    pytest.importorskip("vtkmodules")
    (tmp_path / "a.vtk").write_text("")

    def killed(program, **options):
        return subprocess.CompletedProcess(program, -11, b"", b"half a line")

    def held_up(program, **options):
        raise subprocess.TimeoutExpired(program, options["timeout"])

    for run, reason in ((killed, "its reader ended by SIGSEGV"), (held_up, "its reader was stopped after 60 s")):
        monkeypatch.setattr(grids.subprocess, "run", run)
        with pytest.raises(MeshError, match=rf"a.vtk: not a readable .vtk file \({reason}\)"):
            Surface.read(tmp_path / "a.vtk")


def test_a_binary_file_with_bytes_changed_never_ends_the_process(tmp_path):
    """Of such files every fifth is VTK's end."""
    file = tmp_path / "a.vtk"
    polydata().save(file)
    content = file.read_bytes()
    rng = np.random.default_rng(1)
    failed = 0
    for _ in range(8):
        damaged = bytearray(content)
        for at in rng.integers(0, len(content), 4):
            damaged[at] = rng.integers(256)
        file.write_bytes(bytes(damaged))
        try:
            Surface.read(file, repair=True)
        except MeshError:
            failed += 1
    assert failed
