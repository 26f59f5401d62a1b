"""What a user knows decides among the symmetries of a shape, and is contradicted in words where it is wrong."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import bent, blob, creature, limbed

import qgeo_filters as qg
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.hints import Hints
from qgeo_filters.matching.match_log import CHOSEN
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.surface import Surface

# A body with head and tail alike, two limbs on each side, and its back up: turned by half about z it is itself.
LIMBS = ((0.6, 0.7, -0.5), (-0.6, 0.7, -0.5), (0.6, -0.7, -0.5), (-0.6, -0.7, -0.5), (0.0, 1.0, 0.4), (0.0, -1.0, 0.4))
LENGTHS = (1.0, 1.0, 1.0, 1.0, 0.8, 0.8)
#: Of the sides of x, y: what each symmetry of the body does to them.
SYMMETRIES = {"same": (1, 1), "half turn": (-1, -1), "left to right": (-1, 1), "front to back": (1, -1)}


def body() -> tuple[np.ndarray, np.ndarray]:
    return limbed(LIMBS, LENGTHS)


@functools.cache
def pair() -> tuple[PreparedShape, PreparedShape]:
    """The body and a pose of it, which bends front and back alike: each of the four symmetries fits equally well."""
    vertices, faces = body()
    return PreparedShape(Surface(vertices, faces)), PreparedShape(Surface(bent(vertices, 0.15), faces))


def image(name: str) -> np.ndarray:
    """The map of all vertices that a symmetry is."""
    vertices, _ = body()
    moved = vertices * [*SYMMETRIES[name], 1]
    return np.linalg.norm(vertices[None] - moved[:, None], axis=2).argmin(axis=1)


def tips() -> np.ndarray:
    """Vertex at the end of each limb."""
    vertices, _ = body()
    directions = np.array(LIMBS) / np.linalg.norm(LIMBS, axis=1)[:, None]
    return (directions @ vertices.T).argmax(axis=1)


def gaps(p2p: np.ndarray, name: str) -> np.ndarray:
    """Distance on Y of each image from that by the symmetry, in sqrt(area)."""
    y = pair()[1]
    vertices = body()[0]
    moved = np.linalg.norm(vertices[p2p] - vertices[image(name)], axis=1)
    return moved / np.sqrt(y.surface.area)


# -- one landmark chooses among equally good maps ------------------------------------------------------------


@pytest.mark.parametrize("name", list(SYMMETRIES))
def test_landmarks_choose_the_symmetry_everywhere(name: str) -> None:
    """One at the tip of a limb says it all, also that Y is a mirror image."""
    tip = tips()[0]
    found = qg.match(*pair(), landmarks=[(tip, image(name)[tip])])
    distance = gaps(found.p2p, name)
    assert distance.mean() < 0.02
    assert distance.max() < 0.2
    assert found.landmark_errors[0] < 0.05
    turned = np.prod(SYMMETRIES[name])
    assert np.sign(found.orientation) == turned
    assert found.explanation.endswith("it agrees with the hints")
    # Who says that Y is a mirror image may be mistaken, and without a landmark both maps would be as good.
    assert ("mirror image" in found.explanation) == (turned < 0)
    assert not found.confident or turned > 0


def test_a_landmark_that_is_off_by_an_edge_or_two_spoils_nothing() -> None:
    x, y = pair()
    tip, other = tips()[[0, 4]]
    there = image("half turn")[[tip, other]]
    near = np.argsort(y.distances(there), axis=1)[:, 8]
    exact = qg.match(x, y, landmarks=np.column_stack([[tip, other], there]))
    found = qg.match(x, y, landmarks=np.column_stack([[tip, other], near]))
    assert y.distances([there[0]])[0, near[0]] > 0.02
    assert gaps(found.p2p, "half turn").mean() < gaps(exact.p2p, "half turn").mean() + 0.01
    assert "it agrees with the hints" in found.explanation


def test_labels_choose_the_symmetry_everywhere() -> None:
    """The front is 7 on X; on Y it is the back that is, roughly: the border is drawn elsewhere, and much is unknown."""
    x, y = pair()
    here, there = x.surface.vertices[:, 1], body()[0][:, 1]
    labels = np.where(here > 0.4, 7, np.where(here < -0.5, 3, -1)), np.where(there < -0.5, 7, -1)
    found = qg.match(x, y, labels=labels)
    assert min(gaps(found.p2p, name).mean() for name in ("half turn", "front to back")) < 0.02
    assert min(gaps(found.p2p, name).mean() for name in ("same", "left to right")) > 0.2
    assert found.landmark_errors.shape == (0,)


# -- hints that cannot be right ------------------------------------------------------------------------------


def test_a_landmark_that_contradicts_the_others_is_named_and_has_no_say() -> None:
    good = tips()[[0, 1, 4]]
    there = image("half turn")
    pairs = [*zip(good, there[good], strict=True), (tips()[2], tips()[0])]
    found = qg.match(*pair(), landmarks=pairs)
    assert gaps(found.p2p, "half turn").mean() < 0.02
    assert not found.confident
    said = f"landmark 3 (vertex {tips()[2]} of X, vertex {tips()[0]} of Y) contradicts the rest: it is "
    assert found.explanation.startswith(said)
    assert "landmark 0" not in found.explanation
    far = float(found.explanation.removeprefix(said).split()[0])
    assert far == pytest.approx(found.landmark_errors[3], abs=0.006)
    assert found.landmark_errors[:3].max() < 0.05
    assert found.landmark_errors[3] > 0.3


def test_a_single_landmark_that_no_map_can_follow_contradicts_the_shapes() -> None:
    """The tip of a limb does not belong on the back."""
    vertices, _ = body()
    back = int(np.linalg.norm(vertices - [0, 0, 0.7], axis=1).argmin())
    found = qg.match(*pair(), landmarks=[(tips()[0], back)])
    assert not found.confident
    assert found.explanation.startswith(f"landmark 0 (vertex {tips()[0]} of X, vertex {back} of Y) contradicts the sha")
    assert min(gaps(found.p2p, name).mean() for name in SYMMETRIES) < 0.03


# -- how they come in ----------------------------------------------------------------------------------------


def shapes() -> tuple[Surface, Surface]:
    return Surface(*blob(2, 1)), Surface(*blob(3, 1))


def test_landmarks_may_be_vertices_points_or_named() -> None:
    x, y = shapes()
    pairs = np.array([[3, 500], [90, 17]])
    expected = Hints.of(x, y, pairs)
    points = tuple(s.vertices[pairs[:, side]] + 1e-3 for side, s in enumerate((x, y)))
    named = qg.Landmarks(["a", "b"], vertices=pairs[:, 0]), qg.Landmarks(["c", "b", "a"], [[9, 9, 9], *points[1][::-1]])
    for landmarks in (pairs.tolist(), [tuple(p) for p in pairs], points, [p.tolist() for p in points], named):
        np.testing.assert_array_equal(Hints.of(x, y, landmarks).landmarks, expected.landmarks)
    np.testing.assert_array_equal(Hints.of(x, y, [*pairs, pairs[0]]).landmarks, pairs)
    assert not expected.landmarks.flags.writeable
    assert bool(expected)


BAD_LANDMARKS = {
    r"pairs .* at least one, got shape \(0,\)": [],
    r"pairs .* got shape \(2, 3\)": [(1, 2, 3), (4, 5, 6)],
    r"must be pairs": [(1, 2), (3,)],
    r"must be pairs .* got float64": [(0.5, 2)],
    r"landmark 1 is vertex 162 of X, which has 162 vertices, numbered from 0 \(2 such: 1, 2\)": [
        (1, 2),
        (162, 4),
        (999, 5),
    ],
    r"landmark 0 is vertex -1 of Y": [(1, -1)],
    r"vertex 5 of X belongs to vertices 6, 7 of Y \(1 such: 5\)": [(5, 6), (5, 7)],
    r"vertex 6 of Y belongs to vertices 4, 5 of X": [(4, 6), (5, 6)],
    r"two arrays of one shape \(k, 3\).* \(2, 3\) and \(1, 3\)": ([[0, 0, 1.0]] * 2, [[0, 0, 1.0]]),
    r"landmark 0 is .* from the nearest vertex of Y.* \(1 such: 0\)": ([[0, 0, 1.0]], [[0, 0, 9.0]]),
    r"landmark 0 on X is \[nan, 0.0, 1.0\]: coordinates must be finite": ([[np.nan, 0, 1.0]], [[0, 0, 1.0]]),
    r"those of X are nose, those of Y tail": (
        qg.Landmarks(["nose"], vertices=[1]),
        qg.Landmarks(["tail"], vertices=[1]),
    ),
    r"two landmarks of Y are called 'a'": (
        qg.Landmarks(["a"], vertices=[1]),
        qg.Landmarks(["a", "a"], vertices=[1, 2]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("message", list(BAD_LANDMARKS))
def test_landmarks_that_cannot_be_are_refused_before_anything_is_computed(message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        qg.match(*shapes(), landmarks=BAD_LANDMARKS[message])


ONE, MANY = np.zeros(162, dtype=np.int64), np.zeros(642, dtype=np.int64)
BAD_LABELS = {
    r"two arrays": ONE,
    r"labels of Y must be a whole number for each of its 642 vertices, got shape \(641,\)": (ONE, MANY[1:]),
    r"labels of X must be whole numbers, negative where unknown, got float64": (ONE + 0.5, MANY),
    r"no number in common: those of X are 0, those of Y 1": (ONE, MANY + 1),
    r"no number in common: those of X are all unknown": (ONE - 1, MANY),
}


@pytest.mark.parametrize("message", list(BAD_LABELS))
def test_labels_that_cannot_be_are_refused(message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        qg.match(*shapes(), labels=BAD_LABELS[message])


def test_a_landmark_on_what_a_repair_removes_is_refused_in_a_sentence_unless_something_is_left_near_it() -> None:
    """A crumb far away, one beside the surface, and a vertex without a face inside: each on the vertices as given."""
    vertices, faces = creature(level=2)
    n, x = len(vertices), Surface(vertices, faces)
    crumbs = np.array([[5.0, 0, 0], [5.1, 0, 0], [5, 0.1, 0]]), vertices[7] + 0.01 * np.eye(3)
    middle = np.zeros((1, 3))
    mess = (
        np.concatenate([vertices, *crumbs, middle]),
        np.concatenate([faces, [[n, n + 1, n + 2], [n + 3, n + 4, n + 5]]]),
    )
    for vertex in (n + 1, n + 6):
        said = (
            rf"landmark 1 is vertex {vertex} of X, which had to go when that was repaired, and is [.\d]+ from what is "
        )
        with pytest.raises(ParameterError, match=said + r"left of it \(1 such: 1\)"):
            qg.match(mess, x, landmarks=[(0, 0), (vertex, 7)])
        with pytest.raises(ParameterError, match=f"landmark 0 is vertex {vertex} of Y"):
            qg.match(x, mess, landmarks=[(7, vertex)])
        with pytest.raises(ParameterError, match=f"landmark 0 is vertex {vertex} of X"):
            qg.match(mess, x, landmarks=[(vertex, 7)], partial=True, normalize=False)
    near, itself = (qg.match(mess, x, landmarks=[(vertex, 7)]) for vertex in (n + 4, 7))
    np.testing.assert_array_equal(near.p2p, itself.p2p)
    assert near.p2p[7] == 7


def test_a_landmark_deep_inside_a_wrap_is_refused_in_a_sentence() -> None:
    mesh = in_pieces(creature(level=3))
    n = len(mesh[0])
    with pytest.raises(ParameterError, match=f"landmark 1 is vertex {n - 1} of Y, which had to go"):
        qg.match(mesh, mesh, landmarks=[(0, 0), (1, n - 1)], repair="wrap")


# -- the measure ---------------------------------------------------------------------------------------------


def test_the_error_of_a_map_is_how_far_it_takes_surroundings_from_where_they_belong() -> None:
    """Of the symmetries' maps, the one that the hints tell has none; others that of the tip's images."""
    x, y = pair()
    tip, there = tips()[0], image("half turn")[tips()[0]]
    problem = MatchProblem.of(x, y, landmarks=[(tip, there)])
    known, points = problem.known, np.arange(x.n_vertices)
    assert known is not None
    maps = np.array([image(name) for name in SYMMETRIES])
    errors = known.errors(points, maps)[:, 0]
    right = list(SYMMETRIES).index("half turn")
    assert errors[right] < 0.01
    assert np.delete(errors, right).min() > 0.3
    far = y.distances([there])[0, maps[:, tip]]
    np.testing.assert_allclose(known.landmark_errors(maps[0]), far[0], atol=1e-4)
    # The surroundings are nearer to where they should be than the tip of the limb is.
    np.testing.assert_allclose(errors, np.maximum(far - MatchingParameters.hint_softness, 0), atol=0.12)
    np.testing.assert_allclose(problem.penalties(points, maps), 1 + errors / MatchingParameters.hint_scale)
    assert known.contradicted(maps[0]).tolist() == [True]
    assert known.agreeing(maps[0]) is None
    assert known.agreeing(maps[right]) is not None
    # A spike is no agreement: the landmark alone is put where it belongs.
    spike = maps[0].copy()
    spike[tip] = there
    assert known.landmark_errors(spike)[0] == 0
    assert known.contradicted(spike).tolist() == [True]


def test_nothing_known_is_nothing_changed() -> None:
    x, y = pair()
    assert MatchProblem.of(x, y).known is None
    assert (MatchProblem.of(x, y).penalties(np.arange(5), np.zeros((3, 5), dtype=np.int64)) == 1).all()


def test_the_log_says_what_was_proposed_by_hints() -> None:
    pairs = [(tip, image("half turn")[tip]) for tip in tips()[[0, 1, 4]]]
    _, log = qg.match(*pair(), landmarks=pairs, log=True)
    assert "distances from what is known" in {entry.proposed_by for entry in log}
    assert sum(entry.fate == CHOSEN for entry in log) == 1
