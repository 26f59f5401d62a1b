"""Positions over time, as arrays and in a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import icosphere

import qgeo_filters as qg

BALL = qg.Surface(*icosphere(1), {"name": np.arange(42)})
GROWING = np.stack([BALL.vertices * size for size in (1.0, 2.0, 4.0)])


def test_frames_are_surfaces() -> None:
    film = qg.Animation(BALL, GROWING)
    assert len(film) == 3
    assert [frame.vertices[0, 0] for frame in film] == GROWING[:, 0, 0].tolist()
    assert np.array_equal(film[-1].vertices, GROWING[2])
    assert np.array_equal(film[0].attributes["name"], np.arange(42))
    assert "3 frames of 42 vertices" in repr(film)
    with pytest.raises(ValueError, match="read-only"):
        film.positions[0, 0, 0] = 1.0


def test_between_frames_are_straight_lines() -> None:
    film = qg.Animation(BALL, GROWING, np.array([0.0, 1.0, 3.0]))
    np.testing.assert_allclose(film.at(2.0), 3 * BALL.vertices)
    np.testing.assert_allclose(film.at(0.0), BALL.vertices)
    np.testing.assert_allclose(film.at(3.0), 4 * BALL.vertices)
    assert np.array_equal(qg.Animation(BALL, GROWING[:1]).at(0.0), BALL.vertices)
    for time in (3.5, -0.1, np.nan, None, "1", [0, 1]):
        with pytest.raises(qg.ParameterError, match="from 0 to 3"):
            film.at(time)
    for frame in (slice(0, 2), 0.5, "0", [0, 1]):
        with pytest.raises(qg.ParameterError, match="a frame is a whole number"):
            film[frame]


def test_it_is_made_of_whatever_holds_a_mesh_and_numbers() -> None:
    single = np.asfortranarray(GROWING.astype(np.float32))
    single.setflags(write=False)
    before = single.copy()
    for positions in (GROWING.tolist(), tuple(GROWING), single):
        film = qg.Animation((BALL.vertices, BALL.faces), positions, (0, 1, 3), "one thing")
        np.testing.assert_allclose(film.positions, GROWING, rtol=1e-6)
        assert film.notes == ("one thing",)
        assert film[np.int64(2)].n_vertices == 42
    np.testing.assert_array_equal(single, before)
    given = GROWING.copy()
    film = qg.Animation(BALL, given)
    given += 1  # what is done to the array afterwards is not done to the animation
    assert np.array_equal(film.positions, GROWING)


def test_a_file_holds_all_of_it(tmp_path: Path) -> None:
    film = qg.Animation(BALL, GROWING, np.array([0.0, 1.0, 3.0]), ("one thing", "another"))
    film.to_npz(tmp_path / "film.npz")
    back = qg.Animation.from_npz(tmp_path / "film.npz")
    assert np.array_equal(back.positions, film.positions)
    assert np.array_equal(back.times, film.times)
    assert back.notes == film.notes
    assert np.array_equal(back.surface.faces, BALL.faces)
    assert np.array_equal(back.surface.attributes["name"], np.arange(42))


def test_what_is_no_animation_is_refused(tmp_path: Path) -> None:
    lost = GROWING.copy()
    lost[1, 5] = np.inf
    for positions, times, said in [
        (GROWING[0], (), r"shape \(frames, 42, 3\), got \(42, 3\)"),
        (GROWING[:, :-1], (), "shape"),
        (GROWING[:0], (), "shape"),
        (lost, (), "the first is 1"),
        (GROWING, (0, 1), "3 growing numbers"),
        (GROWING, (0, 2, 1), "growing"),
        (GROWING, (0, 1, np.nan), "growing"),
    ]:
        with pytest.raises(qg.ParameterError, match=said):
            qg.Animation(BALL, positions, np.array(times, dtype=float))
    for positions, times, said in [
        ([GROWING[0], GROWING[1][:-1]], (), "positions must be numbers in an array"),
        ([BALL, BALL], (), "positions must be real numbers, got an array of object"),
        (GROWING + 0j, (), "positions must be real numbers, got an array of complex128"),
        ("abc", (), "positions must be real numbers"),
        (GROWING, ("a", "b", "c"), "times must be real numbers"),
        (GROWING, None, "times must be real numbers"),
    ]:
        with pytest.raises(qg.ParameterError, match=said):
            qg.Animation(BALL, positions, times)
    for mesh, said in [
        (None, "cannot take a mesh from"),
        ((lost[1], BALL.faces), r"vertices\[5\]"),
        ((BALL.vertices, BALL.faces + 1), r"refers to vertex 42, but there are 42"),
    ]:
        with pytest.raises(qg.MeshError, match=said):
            qg.Animation(mesh, GROWING)
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(qg.MeshError, match=r"other.npz: .*no positions"):
        qg.Animation.from_npz(tmp_path / "other.npz")
    np.savez(
        tmp_path / "bad.npz", positions=lost, times=np.arange(3.0), notes=np.array([], str), vertices=BALL.vertices,
        faces=BALL.faces,
    )  # fmt: skip
    with pytest.raises(qg.MeshError, match=r"bad.npz: .*damaged"):
        qg.Animation.from_npz(tmp_path / "bad.npz")


def test_a_single_step_has_no_chart() -> None:
    """A bar beside no other says nothing."""
    charts = ["<svg" in qg.Animation(BALL, GROWING[:count])._repr_html_() for count in (1, 2, 3)]
    assert charts == [False, False, True]
