"""Maps of farthest points to vertices that compete: hypotheses, lifted, and their mirrored maps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.extrema_reflections import extrema_reflections
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.initialization.landmark_maps import landmark_maps
from qgeo_filters.matching.initialization.sign_search import sign_search
from qgeo_filters.matching.initialization.upsampling import coarse_lift, laplacian_lift, zoomout_lift
from qgeo_filters.matching.maps.map_distance import mean_distortion
from qgeo_filters.matching.maps.orientation import normal_cosines
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.parallel import concurrently


@dataclass(frozen=True, eq=False)
class Candidate:
    """A coarse map, right in the large or not.

    Attributes
    ----------
    p2p : (s,) int
        Vertex of Y for each of X's `mapped_points`.
    mean_distortion : float
        See `mean_distortion`.
    orientation : float
        See `orientation`; over some of the triangles.
    number : int
        In the log of the problem.
    penalty, unlikeness : float
        See `MatchProblem.penalties`, 1 without hints, and `MatchProblem.unlikeness`.
    """

    p2p: IndexArray
    mean_distortion: float
    orientation: float
    number: int
    penalty: float = 1.0
    unlikeness: float = 1.0

    @property
    def rank(self) -> float:
        """What candidates are sorted by: the distortion, times how unlike surroundings are, and the penalty."""
        return self.unhinted_rank * self.penalty

    @property
    def unhinted_rank(self) -> float:
        """The same, whatever the hints say."""
        return self.mean_distortion * self.unlikeness


def mapped_points(problem: MatchProblem) -> IndexArray:
    """The vertices of X that candidates map: its first farthest points."""
    return problem.x.fps[: problem.parameters.candidate_points]


def candidates(problem: MatchProblem) -> list[Candidate]:
    """Different maps from X to Y, those of least rank first.

    Maps that neither keep nor reverse the orientation are left out, unless there are no others.
    """
    given, log = problem.parameters, problem.log
    hypotheses = sign_search(problem)
    # For a reflection, what is left near the identity may keep distances better than any reflection does.
    bound = np.inf
    if hypotheses and not problem.reflection:
        least = max(_rank(problem, hypotheses[0]), given.candidate_floor)
        bound = given.candidate_ratio * least + given.ratio_slack
    worth = [h for h in hypotheses if _rank(problem, h) <= bound]
    for h in hypotheses:
        if _rank(problem, h) > bound:
            log.drop(h.number, dearer_than(problem, bound))
    guesses = extrema_reflections(problem) if problem.reflection else landmark_maps(problem)
    points, triangles = mapped_points(problem), _largest_triangles(problem.x, given.candidate_triangles)
    if problem.reflection:
        some = triangles[: given.rough_triangles]
        turned = [h for h in worth if _rough_orientation(problem, h, some) < given.rough_orientation]
        for h in turned:
            log.drop(h.number, "keeps the orientation of the shape: no reflection")
        worth = [h for h in worth if h not in turned]
    vertices = np.concatenate([points, triangles.ravel()])

    def measured(number: int, images: IndexArray) -> Candidate:
        p2p, corners = images[: len(points)], images[len(points) :].reshape(-1, 3)
        cosine = float(normal_cosines(problem.y.unit, corners).mean())
        return _candidate(problem, p2p, mean_distortion(problem, p2p), cosine, number)

    tasks = [(h.number, partial(zoomout_lift, problem, h, vertices)) for h in worth]
    tasks += [(guess.number, partial(laplacian_lift, problem, guess, vertices)) for guess in guesses]
    found = sorted(concurrently(lambda task: measured(task[0], task[1]()), tasks), key=lambda c: c.rank)
    for c in found:
        log.note(c.number, mean_distortion=c.mean_distortion, orientation=c.orientation)
    one_sided = [c for c in found if abs(c.orientation) > given.one_sided]
    for c in found if one_sided else ():
        if abs(c.orientation) <= given.one_sided:
            log.drop(c.number, f"neither keeps nor reverses the orientation (within {given.one_sided:g} of 0)")
    return one_sided or found


def mirrored_map(problem: MatchProblem, c: Candidate, mirror: IndexArray, *, of_y: bool) -> Candidate:
    """A candidate composed with a self-symmetry: the map that keeps distances as well and reverses the orientation.

    Parameters
    ----------
    mirror : (n,) int
        Vertex nearest to the mirror point of each vertex of Y, or of X if not ``of_y``.
    """
    x = problem.x
    if of_y:
        p2p = mirror[c.p2p]
    else:
        rows = x.fps_distances[: len(c.p2p)]
        p2p = c.p2p[rows[:, mirror[x.fps[: len(rows)]]].argmin(axis=0)]
    distortion = mean_distortion(problem, p2p)
    number = problem.log.propose(f"#{c.number} by the symmetry of {'Y' if of_y else 'X'}", distortion, -c.orientation)
    return _candidate(problem, p2p, distortion, -c.orientation, number)


def _candidate(problem: MatchProblem, p2p: IndexArray, distortion: float, turned: float, number: int) -> Candidate:
    """A map of the mapped points with all that it is ranked by."""
    points = mapped_points(problem)
    penalty, unlikeness = float(problem.penalties(points, p2p)), float(problem.unlikeness(points, p2p))
    return Candidate(p2p, distortion, turned, number, penalty, unlikeness)


def dearer_than(problem: MatchProblem, bound: float) -> str:
    """The rule that drops maps of a rank above the bound, in words."""
    unlike = "" if problem.reflection else ", times how unlike the parts are"
    hints = ", or disagrees with the hints" if problem.known else ""
    return f"distorts distances by more than {bound:.3f}{unlike}{hints}"


def _rank(problem: MatchProblem, h: Hypothesis) -> float:
    return h.mean_distortion * float(problem.dearness(h.points, h.p2p))


def _rough_orientation(problem: MatchProblem, h: Hypothesis, triangles: IndexArray) -> float:
    """Orientation of a hypothesis by its first eigenfunctions: what it will be once it has grown, but for a little."""
    images = coarse_lift(problem, h, triangles.ravel()).reshape(-1, 3)
    return float(normal_cosines(problem.y.unit, images).mean())


def _largest_triangles(x: PreparedShape, count: int) -> IndexArray:
    """The largest triangle at each of the first farthest points, (t, 3)."""
    order = np.argsort(x.unit.face_areas, kind="stable")
    largest = np.empty(x.n_vertices, dtype=np.int64)
    largest[x.unit.faces[order]] = order[:, None]  # the last one stays
    return x.unit.faces[largest[x.fps[:count]]].astype(np.int64)
