"""The poses of ``qgeo compatibility``: each read, its spectrum, its map; what is wrong with one is its own affair."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.cli.in_turn import Batch
from qgeo_filters.cli.job import Job
from qgeo_filters.filters import stages
from qgeo_filters.matching.compatibility import SPARE_EIGENPAIRS, are_one_mesh, check_baselines
from qgeo_filters.matching.matchable import check_matchable
from qgeo_filters.parallel import default_workers
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface

_ACCURACY = 1e-3  # of distances, as everywhere


@dataclass(frozen=True, eq=False)
class Pose:
    """A pose that can be compared, and its place on the command line."""

    place: int
    surface: Surface
    spectrum: Spectrum
    image: IndexArray


class GoodPoses:
    """What can be compared of the poses of a job, in steps, each of which may leave some out.

    Parameters
    ----------
    job : Job
    batch : Batch
        Names what is left out.
    needed : collection of int
        Poses without which nothing is to be found: what is wrong with one of them is raised.
    workers : int, optional
    """

    def __init__(self, job: Job, batch: Batch, needed: Collection[int], workers: int | None) -> None:
        self._job, self._batch, self._needed, self._workers = job, batch, needed, workers
        self.surfaces, self.places = job.read_good(batch, needed)

    def spectra(self, k: int, curvature_weight: float) -> dict[int, Spectrum]:
        """Spectrum of each pose, by its place; of those that have one."""
        found = {}

        def spectrum(pose: int) -> None:
            surface = self.surfaces[pose]
            stages.check_spectrum(surface, k)
            metric = stages.metric_of(surface, "mean_curvature", curvature_weight)
            found[self.places[pose]] = stages.spectrum_of(
                metric, min(k + SPARE_EIGENPAIRS, surface.n_vertices), "area", "auto", "graph", _ACCURACY
            )

        self._each(spectrum)
        return found

    def maps(self, first: int) -> dict[int, IndexArray]:
        """Vertex of each pose for each of the first baseline, by its place: equal numbers, or found by `match`."""
        if not are_one_mesh(self.surfaces):
            # Looked at before anything is matched: the others may be poses of one mesh.
            self._each(lambda pose: check_matchable(self.surfaces[pose], repaired=self._job.repairs[pose] is not None))
        baseline = self.surfaces[self.places.index(first)]
        same = np.arange(baseline.n_vertices)
        if are_one_mesh(self.surfaces):
            return dict.fromkeys(self.places, same)
        found = {first: same}

        def image(pose: int) -> None:
            if self.places[pose] != first:
                matched = stages.correspondence_of(baseline, self.surfaces[pose], True, partial=False)
                found[self.places[pose]] = matched.p2p

        self._each(image)
        return found

    def _each(self, task: Callable[[int], None]) -> None:
        needed = [pose for pose, place in enumerate(self.places) if place in self._needed]
        with default_workers(self._workers):
            good = self._job.keep_good(self._batch, needed, task)
        self.places = [self.places[pose] for pose in good]
        self.surfaces = [self.surfaces[pose] for pose in good]


def compared(
    job: Job, batch: Batch, baselines: tuple[int, int], k: int, weight: float, workers: int | None
) -> list[Pose]:
    """The poses of a job that can be compared with its baselines; the others are named.

    Raises
    ------
    ParameterError
        Fewer than two poses, or baselines that are not two of them.
    """
    check_baselines(len(job.paths), baselines)
    poses = GoodPoses(job, batch, baselines, workers)
    with job.stage("spectra"):
        spectra = poses.spectra(k, weight)
    with job.stage("maps"):
        maps = poses.maps(baselines[0])
    return [Pose(p, s, spectra[p], maps[p]) for p, s in zip(poses.places, poses.surfaces, strict=True)]
