"""Folder layouts, written out in small and read back; TOSCA itself where it is present."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import icosphere

from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation import (
    IndexedDataset,
    NoTruthError,
    Shrec19,
    ToscaLowres,
    ToscaRemeshed,
    VtsDataset,
    read_vts,
    symmetric_errors,
)
from qgeo_filters.evaluation.datasets import natural_key
from qgeo_filters.surface import Surface


def write(folder: Path, *names: str) -> Surface:
    folder.mkdir(parents=True, exist_ok=True)
    surface = Surface(*icosphere(0))
    for name in names:
        surface.write(folder / name)
    return surface


def lines(file: Path, values: list[int]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(map(str, values)) + "\n")


def test_names_sort_by_number() -> None:
    assert sorted(["cat10", "cat2", "ant1", "cat"], key=natural_key) == ["ant1", "cat", "cat2", "cat10"]


def test_remeshed_layout_goes_through_the_full_mesh(tmp_path: Path) -> None:
    write(tmp_path / "remeshed", "cat0.off", "cat1.off", "dog0.off")
    (tmp_path / "ground_truth").mkdir()
    rng = np.random.default_rng(0)
    full = {name: rng.permutation(20)[:12] for name in ("cat0", "cat1")}
    nearest = {name: rng.integers(0, 12, 20) for name in full}
    for name in full:
        np.savez(tmp_path / "ground_truth" / f"{name}.npz", full_of_vertex=full[name], vertex_of_full=nearest[name])
    lines(tmp_path / "symmetry" / "cat.sym", list(range(20, 0, -1)))
    data = ToscaRemeshed(tmp_path)
    assert data.categories == ("cat", "dog")
    assert list(data.pairs()) == [("cat0", "cat1")]
    assert data.read("dog0").n_vertices == 12
    truth = data.truth("cat0", "cat1")
    np.testing.assert_array_equal(truth.points, np.arange(12))
    np.testing.assert_array_equal(truth.images, nearest["cat1"][full["cat0"]])
    np.testing.assert_array_equal(data.symmetry("cat1").images, nearest["cat1"][19 - full["cat1"]])
    with pytest.raises(NoTruthError, match="different categories"):
        data.truth("cat0", "dog0")
    with pytest.raises(NoTruthError, match=r"dog\.sym is missing"):
        data.symmetry("dog0")


def test_indexed_layout_is_the_identity_for_equal_sizes(tmp_path: Path) -> None:
    write(tmp_path, "tr_reg_000.ply", "tr_reg_001.ply")
    Surface(*icosphere(1)).write(tmp_path / "tr_reg_002.ply")
    data = IndexedDataset(tmp_path)
    np.testing.assert_array_equal(data.truth("tr_reg_000", "tr_reg_001").images, np.arange(12))
    with pytest.raises(NoTruthError, match="12 and 42 vertices"):
        data.truth("tr_reg_000", "tr_reg_002")
    with pytest.raises(NoTruthError, match="no left/right map"):
        data.symmetry("tr_reg_000")


def test_two_meshes_of_one_name_are_refused(tmp_path: Path) -> None:
    """Which of the two was taken depended on the order of the folder."""
    write(tmp_path, "cat0.off", "cat0.ply", "cat1.off")
    with pytest.raises(MeshError, match=r"cat0\.off and .*cat0\.ply are both cat0: leave one there"):
        IndexedDataset(tmp_path)


def test_paper_meshes_have_no_truth(tmp_path: Path) -> None:
    write(tmp_path, "cat0.vert", "cat1.vert", "cat2.off")
    data = ToscaLowres(tmp_path)
    assert data.names("cat") == ["cat0", "cat1"]
    with pytest.raises(NoTruthError, match="decimated independently"):
        data.truth("cat0", "cat1")


def test_vts_layout_meets_at_the_template(tmp_path: Path) -> None:
    write(tmp_path / "off", "tr_reg_000.off", "tr_reg_001.off")
    lines(tmp_path / "corres" / "tr_reg_000.vts", [3, 1, 3, 12])
    lines(tmp_path / "corres" / "tr_reg_001.vts", [5, 6, 7, 8])
    data = VtsDataset(tmp_path)
    truth = data.truth("tr_reg_000", "tr_reg_001")
    np.testing.assert_array_equal(truth.points, [0, 2, 11])
    np.testing.assert_array_equal(truth.images, [5, 4, 7])
    with pytest.raises(NoTruthError, match="no left/right map"):
        data.symmetry("tr_reg_000")
    lines(tmp_path / "corres" / "template.sym", [4, 3, 2, 1])
    mirror = data.symmetry("tr_reg_001")
    np.testing.assert_array_equal(mirror.points, [4, 5, 6, 7])
    np.testing.assert_array_equal(mirror.images, [7, 6, 5, 4])
    np.testing.assert_array_equal(read_vts(tmp_path / "corres" / "tr_reg_001.vts"), [4, 5, 6, 7])


def test_shrec_layout_lists_its_own_pairs(tmp_path: Path) -> None:
    write(tmp_path / "off", "1.off", "2.off", "10.off")
    lines(tmp_path / "groundtruth" / "2_10.map", list(range(12, 0, -1)))
    lines(tmp_path / "groundtruth" / "2_3.map", list(range(12, 0, -1)))  # without 3.off
    data = Shrec19(tmp_path)
    assert data.names() == ["1", "2", "10"]
    assert list(data.pairs()) == [("2", "10")]
    np.testing.assert_array_equal(data.truth("2", "10").images, np.arange(12)[::-1])
    with pytest.raises(NoTruthError, match="no pair"):
        data.truth("1", "2")


@pytest.fixture
def remeshed(tmp_path: Path) -> Path:
    """Two poses of twelve vertices, cut from a mesh of twenty, and its left/right map."""
    write(tmp_path / "remeshed", "cat0.off", "cat1.off")
    (tmp_path / "ground_truth").mkdir()
    for name in ("cat0", "cat1"):
        table = {"full_of_vertex": np.arange(12), "vertex_of_full": np.arange(20) % 12}
        np.savez(tmp_path / "ground_truth" / f"{name}.npz", **table)
    lines(tmp_path / "symmetry" / "cat.sym", list(range(20, 0, -1)))
    return tmp_path


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"full_of_vertex": [0, 99]}, r"cat1\.npz: no image of vertex 99, only of 20 vertices, .* \(1 such vertex\)"),
        ({"full_of_vertex": [0, -1]}, "full_of_vertex must be vertices, counted from 0"),
        ({"full_of_vertex": [[0, 1]]}, "full_of_vertex must be vertices, counted from 0, in one dimension"),
        ({"full_of_vertex": [0, 0.5]}, r"full_of_vertex\[1\] is 0.5, not a whole number"),
        ({"full_of_vertex": ["x"]}, "full_of_vertex must be whole numbers"),
        ({"full": [0]}, "no array full_of_vertex, only full"),
        (None, "is not a readable .npz file"),
    ],
)
def test_ground_truth_that_lies_is_named(remeshed: Path, arrays: dict[str, list] | None, message: str) -> None:
    file = remeshed / "ground_truth" / "cat0.npz"
    if arrays is None:
        file.write_bytes(file.read_bytes()[:-30])
    else:
        np.savez(file, **arrays)
    with pytest.raises(MeshError, match=message):
        ToscaRemeshed(remeshed).truth("cat0", "cat1")


def test_a_left_right_map_of_another_mesh_is_named(remeshed: Path) -> None:
    lines(remeshed / "symmetry" / "cat.sym", [2, 1])
    with pytest.raises(MeshError, match=r"cat\.sym: no image of vertex 2, only of 2 vertices"):
        ToscaRemeshed(remeshed).symmetry("cat0")
    write(remeshed / "off", "cat.off")
    lines(remeshed / "corres" / "cat.vts", [1, 2, 3])
    for values, message in (
        ([1, 2], r"template\.sym has 2 points"),
        ([1, 2, 9], r"template\.sym: no image of vertex 8"),
    ):
        lines(remeshed / "corres" / "template.sym", values)
        with pytest.raises(MeshError, match=message):
            VtsDataset(remeshed).symmetry("cat")


@pytest.mark.parametrize("content", ["", "0\n1\n", "1.5\n", "1e99\n", "nan\n", "one\n", "1 2\n3 4\n"])
def test_files_that_do_not_count_from_one_are_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "a.vts").write_text(content)
    with pytest.raises(MeshError, match=r"a\.vts"):
        read_vts(tmp_path / "a.vts")


def test_empty_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no meshes of VtsDataset"):
        VtsDataset(tmp_path)


def test_tosca_truth_is_smooth_and_its_symmetry_an_involution(data_dir: Path) -> None:
    data = ToscaRemeshed(data_dir / "tosca")
    assert len(data.files) == 68
    x, y = data.names("wolf")[:2]
    surface = data.read(y)
    truth, mirror = data.truth(x, y).images, data.symmetry(y).images
    edges = surface.vertices[truth[data.read(x).edges]]
    # Neighbours go to neighbours: an edge is about 0.03 sqrt(area) long.
    assert np.median(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1)) < 0.05 * np.sqrt(surface.area)
    errors = symmetric_errors(mirror[mirror], np.arange(surface.n_vertices), mirror, surface)
    assert errors.direct.mean() < 0.02
    assert errors.reflected.mean() > 0.2
