"""What people do with a map, on ellipsoids where every image is known; no match is run."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import known_match
import numpy as np
import pytest
from known_match import PLACE, TURN, ellipsoids, moved, without_partners
from shapes import grid

import qgeo_filters as qg
from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.geodesics.pairs import paired_distances
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.match_result import MatchResult


@pytest.fixture(scope="module")
def found() -> MatchResult:
    return ellipsoids()


@pytest.fixture(scope="module")
def part(found: MatchResult) -> MatchResult:
    """The same with the lower halves of both shapes without a partner."""
    lower_y = ((found.y.vertices - PLACE) @ TURN.T)[:, 2] < -0.1
    return without_partners(found, found.x.vertices[:, 2] < -0.05, lower_y)


def on_x(points: np.ndarray) -> np.ndarray:
    """Points of Y as they are on X."""
    return (points - PLACE) @ TURN.T / 2


# -- transfer -----------------------------------------------------------------------------------------


def test_vertices_that_both_shapes_have_get_exact_values(found: MatchResult) -> None:
    """Y's vertices are the first of X: what is defined there comes over whole, whatever it is."""
    values = np.random.default_rng(0).normal(size=(found.x.n_vertices, 2, 3))
    np.testing.assert_allclose(found.transfer(values), values[: found.y.n_vertices], atol=1e-12)
    assert found.transfer(values).shape == (found.y.n_vertices, 2, 3)
    np.testing.assert_allclose(found.transfer(found.x.vertices), on_x(found.y.vertices), atol=1e-12)


def test_linear_functions_are_carried_to_second_order() -> None:
    """A refined Y halves the edges, and takes the errors of interpolation on it to a quarter."""
    errors = []
    for coarse in (2, 3):
        found = ellipsoids(4, coarse)
        errors.append(np.abs(found.transfer(found.y.vertices, to="x") - moved(found.x.vertices)).max())
    assert errors[0] < 0.05
    assert 3.2 < errors[0] / errors[1] < 4.8


def test_there_and_back(found: MatchResult) -> None:
    smooth = np.sin(2 * found.x.vertices[:, 0]) + found.x.vertices[:, 1] * found.x.vertices[:, 2]
    back = found.transfer(found.transfer(smooth), to="x")
    assert np.abs(back - smooth).max() < 0.08 * np.ptp(smooth)
    assert np.array_equal(found.transfer(found.transfer(smooth, to="y"), to="x"), back)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.complex128, np.int16, np.uint8, np.bool_, "U9"])
def test_the_type_of_the_values_stays(found: MatchResult, dtype: np.dtype) -> None:
    values = (found.x.vertices[:, 0] > 0).astype(dtype)
    over = found.transfer(values)
    assert over.dtype == values.dtype
    assert np.array_equal(over, values[: found.y.n_vertices])


def test_labels_are_those_of_most_of_the_area(found: MatchResult) -> None:
    """A speck of one vertex of the fine X is outvoted by what else is mapped there; a vertex of Y has one region."""
    region = np.where(found.x.vertices[:, 0] > 0.2, 7, 2)
    speck = region.copy()
    speck[11] = 99
    assert (found.p2p == found.p2p[11]).sum() > 2
    expected = np.where(on_x(found.y.vertices)[:, 0] > 0.2, 7, 2)
    clear = np.abs(on_x(found.y.vertices)[:, 0] - 0.2) > 0.15
    over = found.transfer(speck)
    assert np.array_equal(over[clear], expected[clear])
    assert set(over) == {2, 7}
    names = np.array(["left", "right"])[(speck == 7).astype(int)]
    assert np.array_equal(found.transfer(names) == "right", over == 7)
    assert np.array_equal(found.transfer(list(names)), found.transfer(names.astype(object)))
    rows = np.column_stack([speck, speck // 2])  # of several columns as one label
    assert np.array_equal(found.transfer(rows), np.column_stack([over, over // 2]))


def test_labels_votes_are_counted_by_hand(found: MatchResult) -> None:
    labels = np.random.default_rng(1).integers(5, size=found.x.n_vertices)
    areas = found.x.vertex_areas
    over = found.transfer(labels)
    for vertex in range(0, found.y.n_vertices, 7):
        votes = np.bincount(labels[found.p2p == vertex], areas[found.p2p == vertex])
        assert over[vertex] == votes.argmax()


def test_labels_where_nothing_is_mapped_go_by_the_triangle(found: MatchResult) -> None:
    """From the coarse shape to the fine one most vertices are nobody's nearest."""
    labels = np.arange(found.y.n_vertices) % 4
    over = found.transfer(labels, to="x")
    place = found.barycentric
    bare = np.setdiff1d(np.arange(found.x.n_vertices), found.inverse)
    assert len(bare) > 400
    for vertex in bare[::40]:
        votes = np.bincount(labels[place.corners[vertex]], place.coordinates[vertex], minlength=4)
        assert votes[over[vertex]] == pytest.approx(votes.max())


def test_whole_numbers_that_measure_are_interpolated_when_asked(found: MatchResult) -> None:
    color = (255 * (found.y.vertices - found.y.vertices.min(axis=0)) / np.ptp(found.y.vertices, axis=0)).astype(
        np.uint8
    )
    over = found.transfer(color, to="x", interpolate=True)
    assert over.dtype == np.float64
    np.testing.assert_allclose(over, found.transfer(color.astype(float), to="x"))
    heights = found.transfer(found.x.vertices[:, 2], interpolate=False)
    assert np.isin(heights, found.x.vertices[:, 2]).all()  # numbers taken as labels are not mixed


@pytest.mark.parametrize(
    ("values", "missing"),
    [
        (np.ones(642), np.nan),
        (np.ones((642, 3), np.float32), np.nan),
        (np.ones(642, int), -1),
        (np.ones((642, 2), np.int8), -1),
        (np.ones(642, bool), False),
        (np.full(642, "bone"), ""),
        (np.full(642, "bone", object), None),
    ],
)
def test_without_a_partner_stands_what_says_so(part: MatchResult, values: np.ndarray, missing: object) -> None:
    over = part.transfer(values)
    lost = part.inverse < 0
    assert 20 < lost.sum() < 120
    expected = np.full_like(over[lost], missing)
    assert over.dtype == values.dtype
    assert over[lost].tolist() == expected.tolist() or np.isnan(over[lost]).all()
    assert (over[~lost] == values[0]).all()
    back = part.transfer(over, to="x")
    assert len(back) == 642


def test_unsigned_labels_need_a_value_for_no_partner(part: MatchResult) -> None:
    with pytest.raises(ValueError, match="uint8 has no value for: say what stands there"):
        part.transfer(np.ones(642, np.uint8))
    assert set(part.transfer(np.ones(642, np.uint8), missing=255)) == {1, 255}
    with pytest.raises(ValueError, match="300 cannot stand for a missing partner among values of type uint8"):
        part.transfer(np.ones(642, np.uint8), missing=300)
    assert set(part.transfer(np.ones(642), missing=-5)) == {1.0, -5.0}
    assert set(part.transfer(np.full(642, "a"), missing="unknown")) == {"a", "unknown"}


def test_texture_coordinates_at_a_seam() -> None:
    """A strip rolled up and closed by doubled vertices: each vertex has a place of the texture on its own side."""
    vertices, faces = grid(24)
    angle = 2 * np.pi * vertices[:, 0]
    rolled = qg.Surface(np.column_stack([np.cos(angle), np.sin(angle), 3 * vertices[:, 1]]), faces)
    turned = qg.Surface(rolled.vertices @ TURN, faces)
    found = known_match.known(rolled, turned, rolled.vertices @ TURN)
    # Of the two vertices of a place either may be the partner: across the seam, and at the seam on any side.
    inner = (vertices[:, 0] > 0.01) & (vertices[:, 0] < 0.99)
    np.testing.assert_allclose(found.transfer(vertices[:, :2])[inner], vertices[inner, :2], atol=1e-9)
    seam = found.transfer(vertices[:, :2])[~inner]
    assert set(seam[:, 0].round(9)) <= {0.0, 1.0}  # one end of the texture or the other, nothing between
    np.testing.assert_allclose(seam[:, 1], vertices[~inner, 1], atol=1e-9)


def test_what_cannot_be_transferred_is_refused(found: MatchResult) -> None:
    with pytest.raises(ValueError, match=r"values have shape \(5,\), but X has 642 vertices$"):
        found.transfer(np.ones(5))
    with pytest.raises(ValueError, match="X has 642 vertices; values of Y go to='x'"):
        found.transfer(np.ones(162))
    with pytest.raises(ValueError, match="Y has 162 vertices; values of X go to='y'"):
        found.transfer(np.ones(642), to="x")
    with pytest.raises(ValueError, match="to must be 'y'"):
        found.transfer(np.ones(642), to="z")
    with pytest.raises(ValueError, match="cannot be interpolated"):
        found.transfer(np.full(642, "a"), interpolate=True)
    with pytest.raises(ValueError, match=r"shape \(\)"):
        found.transfer(3.0)


# -- landmarks ----------------------------------------------------------------------------------------


def test_landmarks_of_vertices_are_the_images_of_these(found: MatchResult) -> None:
    vertices = np.arange(0, found.x.n_vertices, 9)
    over = found.landmarks(vertices)
    np.testing.assert_allclose(over.points, found.transfer(found.y.vertices, to="x")[vertices], atol=1e-9)
    lengths = np.linalg.norm(found.y.vertices[:, None] - over.points, axis=2)
    np.testing.assert_allclose(lengths[over.vertices, np.arange(len(over))], lengths.min(axis=0), atol=1e-9)
    assert over.names == tuple(str(i + 1) for i in range(len(vertices)))


def test_landmarks_within_triangles_there_and_back(found: MatchResult) -> None:
    """Points within triangles come out where the known map takes them, and come back."""
    random = np.random.default_rng(5)
    face = random.integers(found.x.n_faces, size=200)
    points = np.einsum("ij,ijk->ik", random.dirichlet((1, 1, 1), 200), found.x.vertices[found.x.faces[face]])
    given = Landmarks([f"p {i}" for i in range(200)], points, frame="LPS")
    over = found.landmarks(given)
    assert (over.names, over.frame) == (given.names, "LPS")
    # Y is a coarse polyhedron within the image of X: its sagitta is what they differ by.
    assert np.linalg.norm(over.points - moved(points), axis=1).max() < 0.08
    back = found.landmarks(over, to="x")
    assert np.linalg.norm(back.points - points, axis=1).max() < 0.06
    lengths = np.linalg.norm(found.x.vertices[:, None] - back.points, axis=2)
    assert (lengths[back.vertices, np.arange(200)] < np.sort(lengths, axis=0)[2]).all()


def test_landmarks_without_a_partner(part: MatchResult) -> None:
    high, low = int(part.x.vertices[:, 2].argmax()), int(part.x.vertices[:, 2].argmin())
    over = part.landmarks([high, low, -1])
    assert over.vertices[0] >= 0
    assert over.vertices[1:].tolist() == [-1, -1]
    assert np.isnan(over.points[1:]).all()
    assert over.is_known.tolist() == [True, False, False]
    points = part.landmarks(part.x.vertices[[high, low]]).points
    np.testing.assert_allclose(points[0], over.points[0])
    assert np.isnan(points[1]).all()
    assert part.landmarks(over, to="x").is_known.tolist() == [True, False, False]
    assert part.landmarks(moved(part.x.vertices[[low]]), to="x").vertices.tolist() == [-1]


def test_landmarks_off_the_surface_are_refused(found: MatchResult) -> None:
    points = found.x.vertices[[0, 5, 9]].copy()
    points[2] *= 1.6
    with pytest.raises(ValueError, match=r"landmark 2 \('3'\) is 0\.\d+ times the extent of X away .*unit and frame"):
        found.landmarks(points)
    assert found.landmarks(points, tolerance=0.5).is_known.all()
    with pytest.raises(ValueError, match="of Y away"):
        found.landmarks(points, to="x")
    with pytest.raises(ValueError, match=r"landmarks of X\[1\] is vertex 642"):
        found.landmarks([0, 642])
    with pytest.raises(ValueError, match="landmarks are Landmarks, vertices"):
        found.landmarks(np.ones((2, 2)))
    assert len(found.landmarks([])) == 0


def test_landmarks_in_the_other_frame_are_told() -> None:
    """RAS instead of LPS: with x and y negated they would lie on the shape."""
    vertices, faces = grid(8)
    x = qg.Surface(np.add(vertices, [3.0, 4.0, 0.0]), faces)
    found = known_match.known(x, x, x.vertices)
    wrong = Landmarks(points=x.vertices[[3, 40]] * [-1, -1, 1], frame="RAS")
    with pytest.raises(ValueError, match=r"with x and y negated all are on it: .* RAS and LPS"):
        found.landmarks(wrong)
    np.testing.assert_allclose(found.landmarks(wrong.in_frame("LPS")).points, x.vertices[[3, 40]])


# -- error --------------------------------------------------------------------------------------------


def test_error_is_that_of_the_evaluation(found: MatchResult) -> None:
    truth = np.random.default_rng(2).permutation(found.p2p)
    truth[:100] = found.p2p[:100]
    np.testing.assert_array_equal(found.error(truth), geodesic_error(found.p2p, truth, found.y))
    assert (found.error(found.p2p) == 0).all()


def test_error_where_nothing_is_known(part: MatchResult) -> None:
    truth = np.zeros(part.x.n_vertices, int)
    truth[::2] = -1
    errors = part.error(truth)
    assert np.array_equal(np.isnan(errors), (truth < 0) | (part.p2p < 0))
    assert np.isnan(part.error(np.full(part.x.n_vertices, -1))).all()
    with pytest.raises(ValueError, match="each of the 642 of X, got 3"):
        part.error([0, 1, 2])
    with pytest.raises(ValueError, match=r"truth\[0\] is vertex 162"):
        part.error([162] * 642)


def test_error_on_a_target_that_needs_repair(found: MatchResult) -> None:
    """A soup of triangles, and a fin on an edge: the distances are those of the surface that is meant."""
    random = np.random.default_rng(6)
    truth = random.integers(162, size=found.x.n_vertices)
    expected = found.error(truth)
    faces = found.y.faces
    soup = qg.Surface(found.y.vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3))
    corner = np.array([np.flatnonzero(faces.ravel() == vertex)[-1] for vertex in range(162)])  # any of its copies
    a, b = faces[0, :2]
    finned = qg.Surface(np.vstack([found.y.vertices, [[0, 0, 0]]]), np.vstack([faces, [[a, b, 162]]]))
    for repairs in ((), ("Y: something",)):
        torn = replace(found, y=soup, p2p=corner[found.p2p], repairs=repairs)
        np.testing.assert_allclose(torn.error(corner[truth]), expected, rtol=2e-3, atol=1e-9)
    errors = replace(found, y=finned, repairs=("Y: something",)).error(truth)
    np.testing.assert_allclose(errors, expected, rtol=2e-3, atol=1e-9)
    assert np.isfinite(replace(found, y=finned).error(truth)).all()


def test_distances_of_pairs_are_held_in_pieces(found: MatchResult) -> None:
    random = np.random.default_rng(3)
    one, other = random.integers(162, size=(2, 400))
    whole = paired_distances(found.y, one, other)
    np.testing.assert_array_equal(paired_distances(found.y, one, other, held=5 * 162), whole)
    np.testing.assert_array_equal(paired_distances(found.y, one, other, held=1), whole)
    np.testing.assert_allclose(whole, qg.distance_matrix(found.y)[one, other], rtol=1e-5)


# -- files and words ----------------------------------------------------------------------------------


def test_csv_has_a_row_for_each_vertex(part: MatchResult, tmp_path: Path) -> None:
    part.to_csv(tmp_path / "map.csv")
    with (tmp_path / "map.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["x_vertex"]) for row in rows] == list(range(part.x.n_vertices))
    assert [int(row["y_vertex"]) for row in rows] == part.p2p.tolist()
    assert [int(row["y_face"]) for row in rows] == part.barycentric.faces.tolist()
    assert [float(row["distortion"]) for row in rows] == part.distortion.tolist()
    for name in ("y_x", "weight_2"):
        assert [row[name] == "" for row in rows] == (part.p2p < 0).tolist()
    known = np.flatnonzero(part.p2p >= 0)
    points = np.array([[float(rows[i][f"y_{axis}"]) for axis in "xyz"] for i in known])
    assert np.array_equal(points, part.barycentric.pulled_back(part.y.vertices)[known])
    weights = np.array([[float(rows[i][f"weight_{k}"]) for k in range(3)] for i in known])
    assert np.array_equal(weights, part.barycentric.coordinates[known])


def test_npz_gives_back_everything(part: MatchResult, tmp_path: Path) -> None:
    log = MatchLog()
    log.propose("the search", 0.25)
    log.choose(log.propose("extrema, in the lifted metric", 0.125, -0.5))
    x = part.x.with_attributes({"label": np.arange(part.x.n_vertices), "qgeo name": np.full(642, "é")})
    saved = replace(part, x=x, log=log, runner_up=np.inf, confident=False, explanation="a – b\nc", mirror="no")
    saved = replace(saved, normalize=False, partial=True)
    saved.to_npz(tmp_path / "match.npz")
    again = MatchResult.from_npz(tmp_path / "match.npz")
    for name in MatchResult.__dataclass_fields__:
        one, other = getattr(saved, name), getattr(again, name)
        assert type(one) is type(other), name
        if isinstance(one, np.ndarray):
            np.testing.assert_array_equal(other, one)
            assert (other.dtype, other.flags.writeable) == (one.dtype, False), name
        elif isinstance(one, float | bool | str):
            assert one == other
    assert again.x.attributes["qgeo name"].tolist() == ["é"] * 642
    np.testing.assert_array_equal(again.x.vertices, x.vertices)
    np.testing.assert_array_equal(again.y.faces, part.y.faces)
    np.testing.assert_array_equal(again.barycentric.coordinates, part.barycentric.coordinates)
    assert str(again.log) == str(log)
    np.testing.assert_array_equal(again.transfer(x.vertices), saved.transfer(x.vertices))
    assert repr(again) == repr(saved)
    with np.load(tmp_path / "match.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["p2p"], part.p2p)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"p2p": np.full(642, 162)}, "p2p of the match must be 642 numbers from -1 to 161"),
        ({"inverse": np.zeros(161, int)}, "inverse of the match must be 162 numbers"),
        ({"positions": np.zeros((642, 2))}, "positions of the match"),
        ({"barycentric_corners": np.zeros((642, 3), int)}, "corners"),
        ({"x_faces": np.array([[0, 1, 9999]])}, "refers to vertex 9999"),
        ({"qgeo_match": np.array("{")}, "no JSON"),
        ({"qgeo_match": np.array('{"version": 99}')}, "another version"),
    ],
)
def test_npz_that_lies_is_refused(
    found: MatchResult, tmp_path: Path, change: dict[str, np.ndarray], expected: str
) -> None:
    found.to_npz(tmp_path / "match.npz")
    with np.load(tmp_path / "match.npz") as arrays:
        np.savez(tmp_path / "match.npz", **{**arrays, **change})
    with pytest.raises(qg.MeshError, match=f"match.npz: .*{expected}"):
        MatchResult.from_npz(tmp_path / "match.npz")


def test_npz_of_other_things_is_refused(found: MatchResult, tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    with pytest.raises(qg.MeshError, match=r"other\.npz: no match that to_npz wrote"):
        MatchResult.from_npz(tmp_path / "other.npz")
    odd = found.x.with_attributes({"any": np.full(642, None)})
    saved = known_match.known(odd, found.y, found.positions)
    with pytest.raises(ValueError, match="x_attribute_any holds Python objects"):
        saved.to_npz(tmp_path / "objects.npz")
    assert not (tmp_path / "objects.npz").exists()


def test_repr_tells_the_story(found: MatchResult, part: MatchResult) -> None:
    assert repr(found).splitlines() == [
        "MatchResult: 642 vertices of X on 162 of Y",
        "  confident: distances are kept",
        "  distortion 0.0100 sqrt(area) in the mean, 0.0200 at most; "
        "the best other map: 0.2000, at 3.50 times the cost",
        "  orientation 0.70, heat kernels agree to 0.98",
    ]
    told = repr(part).splitlines()[-1]
    share_x, share_y = (100 * np.mean(images < 0) for images in (part.p2p, part.inverse))
    assert told == f"  no partner: {share_x:.1f} % of the vertices of X and {share_y:.1f} % of the vertices of Y"
    mended = replace(part, repairs=("X: 2 faces removed",))
    assert repr(mended).splitlines()[-2:] == [told, "  repaired before: 1 change, see repairs"]
    doubtful = known_match.known(found.x, found.y, found.positions, confident=False, runner_up=np.inf)
    assert "NOT CONFIDENT" in repr(doubtful)
    assert "no other map was proposed" in repr(doubtful)
