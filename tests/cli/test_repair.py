"""Commands on meshes with something wrong: mended by default and said so, results on the vertices of the file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import blob, creature
from typer.testing import Result

import qgeo_filters as qg

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]

V, F = blob(2)
N = len(V)


def write_mess(name: str, vertices: np.ndarray, faces: np.ndarray, seed: int = 0) -> np.ndarray:
    """Writes an unwelded mesh with a crumb and a third of its faces turned over; the clean vertex of each, or -1."""
    turned = np.random.default_rng(seed).random(len(faces)) < 1 / 3
    where = np.where(turned[:, None], faces[:, ::-1], faces).ravel()
    crumb = [[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0]]
    points = np.concatenate([vertices[where], crumb])
    qg.Surface(points, np.arange(len(points)).reshape(-1, 3)).write(name)
    return np.concatenate([where, np.full(3, -1)])


def test_distances_of_a_mess_are_those_of_the_clean_mesh(qgeo: Qgeo, loaded: Loaded) -> None:
    of_clean = write_mess("mess.ply", V, F)
    here = of_clean >= 0
    assert qgeo("distances", "mess.ply", "-s", "700,3", "-w", 0, "--no-pictures").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/distances-mess"))
    wanted = qg.distances((V, F), of_clean[[700, 3]], "cartesian")
    np.testing.assert_allclose(arrays["distances"][:, here], wanted[:, of_clean[here]], rtol=2e-3, atol=1e-9)
    assert np.isinf(arrays["distances"][:, ~here]).all()  # the crumb stays, and cannot be reached
    assert any("joined with others" in line for line in content["mesh"]["repaired"])
    assert content["mesh"]["vertices_of_the_file"] == len(of_clean)
    assert content["results"]["shape"] == [2, len(of_clean)]
    drawn = qg.Surface.read("qgeo-out/distances-mess/mess.ply")
    np.testing.assert_array_equal(drawn.attributes["qgeo_distance"], arrays["distances"].T)
    np.testing.assert_array_equal(drawn.faces, np.arange(len(of_clean)).reshape(-1, 3))
    all_pairs = qgeo("distances", "mess.ply", "-w", 0, "--no-pictures", "-o", "all")
    assert all_pairs.exit_code == 0
    assert "repaired mess.ply: " in all_pairs.stdout
    matrix = loaded(Path("all"))[1]["distances"]
    np.testing.assert_allclose(matrix[[700, 3]], arrays["distances"], rtol=2e-3, atol=1e-6)


def test_a_path_runs_over_the_seams(qgeo: Qgeo, loaded: Loaded) -> None:
    of_clean = write_mess("mess.ply", V, F)
    assert qgeo("path", "mess.ply", 3, 700, "-w", 0, "--no-pictures").exit_code == 0
    _, arrays = loaded(Path("qgeo-out/path-mess-3-700"))
    wanted = qg.quasi_geodesic((V, F), *of_clean[[3, 700]], metric="cartesian")
    assert float(arrays["length"]) == pytest.approx(wanted.length, rel=1e-6)
    mess = qg.Surface.read("mess.ply")
    there = np.einsum("ij,ijk->ik", arrays["barycentric"], mess.vertices[mess.faces[arrays["faces"]]])
    np.testing.assert_allclose(there, arrays["points"], atol=1e-6)
    outside = qgeo("path", "mess.ply", 0, 9999)
    assert f"J is vertex 9999, but there are {len(of_clean)} vertices" in outside.stderr


def test_spectra_of_a_mess_are_on_the_vertices_of_the_file(qgeo: Qgeo, loaded: Loaded) -> None:
    of_clean = write_mess("mess.ply", V, F)
    here = of_clean >= 0
    assert qgeo("spectrum", "mess.ply", "-k", 3, "--no-pictures").exit_code == 0
    _, arrays = loaded(Path("qgeo-out/spectrum-mess"))
    wanted = qg.distance_spectrum((V, F), 3)
    np.testing.assert_allclose(arrays["eigenvalues"], wanted.eigenvalues, rtol=1e-3)
    found = arrays["eigenfunctions"][here]
    expected = wanted.eigenfunctions[of_clean[here]]
    np.testing.assert_allclose(found * np.sign((found * expected).sum(axis=0)), expected, atol=1e-2)
    assert np.isnan(arrays["eigenfunctions"][~here]).all()
    refused = qgeo("spectrum", "mess.ply", "-k", 3, "--no-repair")
    assert refused.exit_code == 2
    assert "needs a" in refused.stderr


def test_a_map_of_messes_names_vertices_of_the_files(qgeo: Qgeo, loaded: Loaded) -> None:
    """To itself, in another order of vertices: the map is known."""
    vertices, faces = creature(0.4, level=2)
    order = np.random.default_rng(1).permutation(len(vertices))
    of_x = write_mess("x.ply", vertices, faces, 1)
    of_y = order[write_mess("y.off", vertices[order], np.argsort(order)[faces], 2)]
    of_y[-3:] = -1
    assert qgeo("match", "x.ply", "y.off", "--no-pictures").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/match-x-y"))
    here = of_x >= 0
    assert (arrays["p2p"][~here] == -1).all()
    off = np.linalg.norm(vertices[of_y[arrays["p2p"][here]]] - vertices[of_x[here]], axis=1)
    assert off.max() <= qg.Surface(vertices, faces).edge_lengths.max()
    for mesh in content["meshes"]:
        assert any("joined with others" in line for line in mesh["repaired"])
    page = Path("qgeo-out/match-x-y/report.html").read_text(encoding="utf-8")
    assert "joined with others" in page


def test_a_symmetry_names_vertices_of_the_file(qgeo: Qgeo, loaded: Loaded) -> None:
    vertices, faces = creature(level=2)
    of_clean = write_mess("mess.ply", vertices, faces)
    here = of_clean >= 0
    assert qgeo("symmetry", "mess.ply", "--no-pictures").exit_code == 0
    _, arrays = loaded(Path("qgeo-out/symmetry-mess"))
    assert arrays["found"]
    mirror = vertices[of_clean[here]] * [-1, 1, 1]
    edge = qg.Surface(vertices, faces).edge_lengths.max()
    assert (np.linalg.norm(vertices[of_clean[arrays["symmetry"][here]]] - mirror, axis=1) < edge).all()
    drawn = qg.Surface.read("qgeo-out/symmetry-mess/mess.ply")
    np.testing.assert_array_equal(drawn.attributes["qgeo_symmetry"], arrays["symmetry"])
    assert np.isnan(arrays["asymmetry"][~here]).all()


def test_a_tidy_mesh_is_not_said_to_be_repaired(qgeo: Qgeo, loaded: Loaded) -> None:
    shown = qgeo("spectrum", "sphere.ply", "-k", 3, "--no-pictures")
    assert "repaired" not in shown.stdout
    content = json.loads(Path("qgeo-out/spectrum-sphere/result.json").read_text(encoding="utf-8"))
    assert "repaired" not in content["mesh"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "arguments", "per_vertex"),
    [
        ("info", (), None),
        ("distances", ("-s", 0), "distances"),
        ("path", (0, 100), None),
        ("spectrum", ("-k", 3), "eigenfunctions"),
        ("symmetry", (), "nearest"),
    ],
)
def test_each_command_takes_a_wrap(
    qgeo: Qgeo, loaded: Loaded, command: str, arguments: tuple[Any, ...], per_vertex: str | None
) -> None:
    mesh = qg.Surface(*in_pieces(creature(level=2)))
    mesh.write("mesh.off")
    made = qgeo(command, "mesh.off", *arguments, "--wrap", "--no-pictures", "-o", "out")
    assert made.exit_code == 0, made.stderr
    content, arrays = loaded(Path("out"))
    assert content["mesh"]["vertices_of_the_file"] == mesh.n_vertices
    assert any("wrapped in a closed surface" in line for line in content["mesh"]["repaired"])
    if per_vertex:
        assert mesh.n_vertices in arrays[per_vertex].shape
    for other in ("--repair", "--force-repair"):
        refused = qgeo(command, "mesh.off", *arguments, "--wrap", other)
        assert refused.exit_code == 2
        assert "--wrap is instead of" in refused.stderr


@pytest.mark.slow
def test_the_size_of_what_has_walls_inside_is_that_of_its_wrap(qgeo: Qgeo) -> None:
    vertices, faces = creature(level=2)
    qg.Surface(vertices, faces).write("x.off")
    inner = np.concatenate([vertices, 0.6 * vertices]), np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    qg.Surface(*inner).write("y.off")
    refused = qgeo("match", "x.off", "y.off", "--no-normalize", "--repair", "--no-partial", "--no-pictures")
    assert "areas of X and Y are" in refused.stderr
    made = qgeo("match", "x.off", "y.off", "--no-normalize", "--wrap", "--no-partial", "--no-pictures")
    assert made.exit_code == 0, made.stderr
