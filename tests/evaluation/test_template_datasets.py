"""Readers of the sets that are handed round as meshes beside lists of vertices."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from shapes import icosphere

from qgeo_filters.errors import MeshError
from qgeo_filters.evaluation import (
    Dt4d,
    NoTruthError,
    PartialDataset,
    SplitDataset,
    TopKids,
    VtsDataset,
    geodesic_error,
    measured,
    read_vts,
)
from qgeo_filters.surface import Surface


def mesh(file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    Surface(*icosphere(0)).write(file)


def lines(file: Path, *values: object) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(f"{value}\n" for value in values))


@pytest.mark.parametrize("folder", ["off", "shapes_test", "."])
def test_meshes_lie_in_a_folder_or_beside(tmp_path: Path, folder: str) -> None:
    mesh(tmp_path / folder / "b10.off")
    mesh(tmp_path / folder / "b9.off")
    assert VtsDataset(tmp_path).names() == ["b9", "b10"]


def test_points_without_a_vertex_have_no_truth(tmp_path: Path) -> None:
    for name, row in {"a": (1, 0, 3, 4, 3), "b": (5, 6, 0, 8, 9)}.items():
        mesh(tmp_path / f"{name}.off")
        lines(tmp_path / "corres" / f"{name}.vts", *row)
    truth = VtsDataset(tmp_path).truth("a", "b")
    np.testing.assert_array_equal(truth.points, [0, 2, 3])
    np.testing.assert_array_equal(truth.images, [4, 8, 7])
    np.testing.assert_array_equal(read_vts(tmp_path / "corres" / "b.vts", missing=True), [4, 5, -1, 7, 8])
    with pytest.raises(MeshError, match=r"b\.vts.*counted from 1"):
        read_vts(tmp_path / "corres" / "b.vts")


def test_vertices_of_matlab_files(tmp_path: Path) -> None:
    for name, row in {"a": [1, 0, 3], "b": [5, 6, 7]}.items():
        mesh(tmp_path / "off" / f"{name}.off")
        (tmp_path / "mat").mkdir(exist_ok=True)
        scipy.io.savemat(tmp_path / "mat" / f"{name}.mat", {"smpl_matches": np.array(row)[:, None]})
    truth = VtsDataset(tmp_path).truth("a", "b")
    np.testing.assert_array_equal(truth.points, [0, 2])
    np.testing.assert_array_equal(truth.images, [4, 6])
    for content, message in (({"other": [1]}, "no array smpl_matches, only other"), ({"smpl_matches": [-3]}, "got -3")):
        scipy.io.savemat(tmp_path / "mat" / "a.mat", content)
        with pytest.raises(MeshError, match=rf"a\.mat.*{message}"):
            VtsDataset(tmp_path).truth("a", "b")


def test_mirrored_images_are_those_of_the_points_of_the_truth(tmp_path: Path) -> None:
    for name, row, mirrored in (("a", (3, 2, 1), (1, 2, 3)), ("b", (5, 6, 7), (7, 0, 5))):
        mesh(tmp_path / f"{name}.off")
        lines(tmp_path / "corres" / f"{name}.vts", *row)
        lines(tmp_path / "corres" / f"{name}.sym.vts", *mirrored)
    data = VtsDataset(tmp_path)
    np.testing.assert_array_equal(data.truth("a", "b").images, [6, 5, 4])
    # Where no mirror image is known the true one stands in: such a point says nothing of left and right.
    np.testing.assert_array_equal(data.reflected_images("a", "b"), [4, 5, 6])
    symmetry = data.symmetry("b")
    np.testing.assert_array_equal(symmetry.points, [4, 6])
    np.testing.assert_array_equal(symmetry.images, [6, 4])
    lines(tmp_path / "corres" / "b.sym.vts", 1)
    with pytest.raises(MeshError, match=r"b\.vts has 3 points and b\.sym\.vts has 1"):
        data.reflected_images("a", "b")


def test_pairs_and_hands_of_the_authors(tmp_path: Path) -> None:
    for name in ("a", "b", "c"):
        mesh(tmp_path / f"{name}.off")
    data = VtsDataset(tmp_path)
    assert not data.reversing("a", "b")
    assert len(list(data.pairs())) == 3
    assert len(list(SplitDataset(tmp_path).pairs())) == 6
    assert len(list(SplitDataset(tmp_path, ordered=False).pairs())) == 3
    assert SplitDataset(tmp_path, "b").names() == ["b", "c"]
    lines(tmp_path / "test_pairs.txt", "c a", "", "a gone")
    lines(tmp_path / "handedness.txt", "a +", "b -", "c +")
    assert list(data.pairs()) == list(SplitDataset(tmp_path).pairs()) == [("c", "a")]
    assert data.reversing("a", "b")
    assert not data.reversing("a", "c")
    lines(tmp_path / "handedness.txt", "a +", "c -")
    for pair in (("a", "b"), ("b", "a"), ("b", "b")):  # of b nothing is known, not that it is unlike
        with pytest.raises(MeshError, match=r"handedness\.txt does not say of which hand b is"):
            data.reversing(*pair)
    for line in ("b", "b + -", "b left"):
        lines(tmp_path / "handedness.txt", "a +", "", line)
        with pytest.raises(MeshError, match=re.escape(f"line 3: expected a name and + or -, got {line!r}")):
            data.reversing("a", "b")
    lines(tmp_path / "test_pairs.txt", "a b c")
    with pytest.raises(MeshError, match="line 1: expected two names"):
        list(data.pairs())


def test_deforming_things_within_a_class_and_across(tmp_path: Path) -> None:
    for kind, name, row in (("bear", "x0", (1, 2, 3)), ("bear", "x1", (4, 5, 6)), ("fox", "y0", (7, 8))):
        mesh(tmp_path / "off" / kind / f"{name}.off")
        lines(tmp_path / "corres" / kind / f"{name}.vts", *row)
    data = Dt4d(tmp_path)
    assert data.categories == ("bear", "fox")
    assert list(data.pairs()) == [("x0", "x1")]
    np.testing.assert_array_equal(data.truth("x0", "x1").images, [3, 4, 5])
    with pytest.raises(NoTruthError, match=r"bear_fox\.vts is missing"):
        data.truth("x0", "y0")
    lines(tmp_path / "corres" / "cross_category_corres" / "bear_fox.vts", 2, 0, 1)
    truth = data.truth("x0", "y0")
    np.testing.assert_array_equal(truth.points, [0, 2])
    np.testing.assert_array_equal(truth.images, [7, 6])


def test_classes_of_dt4d_may_share_names(tmp_path: Path) -> None:
    """Each shape keeps its own mesh and its own points; before, the class that was read last had the name alone."""
    for place, one in enumerate(("bear", "fox")):
        for name in ("run", one):
            mesh(tmp_path / "off" / one / f"{name}.off")
            lines(tmp_path / "corres" / one / f"{name}.vts", place + 1, place + 2)
    data = Dt4d(tmp_path)
    assert sorted(data.names()) == ["bear", "bear.run", "fox", "fox.run"]
    assert [sorted(pair) for pair in data.pairs()] == [["bear", "bear.run"], ["fox", "fox.run"]]
    assert data.files["fox.run"] == tmp_path / "off" / "fox" / "run.off"
    np.testing.assert_array_equal(data.truth("bear.run", "bear").points, [0, 1])
    np.testing.assert_array_equal(data.truth("fox", "fox.run").images, [1, 2])


def test_parts_know_their_whole(tmp_path: Path) -> None:
    mesh(tmp_path / "null" / "off" / "cat.off")
    for kind in ("cuts", "holes"):
        mesh(tmp_path / kind / "off" / f"{kind}_cat_shape_3.off")
        lines(tmp_path / kind / "corres" / f"{kind}_cat_shape_3.vts", 3, 0, 1)
        data = PartialDataset(tmp_path, kind)
        assert list(data.pairs()) == [(f"{kind}_cat_shape_3", "cat")]
        truth = data.truth(f"{kind}_cat_shape_3", "cat")
        np.testing.assert_array_equal(truth.points, [0, 2])
        np.testing.assert_array_equal(truth.images, [2, 0])
        with pytest.raises(NoTruthError):
            data.truth("cat", f"{kind}_cat_shape_3")
    (tmp_path / "null" / "off" / "cat.off").unlink()
    with pytest.raises(FileNotFoundError, match="the whole cat is missing"):
        PartialDataset(tmp_path, "cuts")


def test_maps_of_parts_count_from_zero(tmp_path: Path) -> None:
    for name in ("leg", "man"):
        mesh(tmp_path / f"{name}.off")
    lines(tmp_path / "maps" / "leg_man.map", 0, -1, 5)
    data = PartialDataset(tmp_path)
    assert list(data.pairs()) == [("leg", "man")]
    np.testing.assert_array_equal(data.truth("leg", "man").images, [0, 5])
    lines(tmp_path / "maps" / "leg_man.map", 0, -2)
    with pytest.raises(MeshError, match=r"leg_man\.map.*counted from 0"):
        data.truth("leg", "man")


def test_glued_children_go_to_the_one_at_rest(tmp_path: Path) -> None:
    mesh(tmp_path / "off" / "kid01.off")
    with pytest.raises(FileNotFoundError, match="kid00"):
        TopKids(tmp_path)
    mesh(tmp_path / "off" / "kid00.off")
    lines(tmp_path / "corres" / "kid01_ref.txt", 2, 0, 4)
    data = TopKids(tmp_path)
    assert list(data.pairs()) == [("kid01", "kid00")]
    np.testing.assert_array_equal(data.truth("kid01", "kid00").points, [0, 2])
    with pytest.raises(NoTruthError, match="to kid00 only"):
        data.truth("kid00", "kid01")


@pytest.mark.slow
def test_two_children_are_told_from_their_mirror_images(data_dir: Path) -> None:
    """The whole way on real files: truth at some vertices, left and right, a map that is nearer to the former."""
    folder = data_dir / "harder" / "kids_r"
    if not folder.is_dir():
        pytest.skip("no children in the data")
    data = VtsDataset(folder)
    x, y = "0001.null.0", "0001.isometry.1"
    truth, y_surface = data.truth(x, y), data.read(y)
    between = geodesic_error(truth.images, data.reflected_images(x, y), y_surface)
    assert 0.2 < between.mean() < 0.8
    mirror = data.symmetry(y)
    back = dict(zip(mirror.points.tolist(), mirror.images.tolist(), strict=True))
    twice = [(p, back[q]) for p, q in back.items() if q in back]
    assert geodesic_error(*np.array(twice).T, y_surface).mean() < 0.01
    (outcome,) = measured(data, [(x, y)])
    assert outcome.errors.direct.mean() < 0.04
    assert not outcome.errors.mirrored
