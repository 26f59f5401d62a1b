"""Filters that move a mesh: poses of another one taken over, and the way to another pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from qgeo_filters._typing import RepairOption
from qgeo_filters.animation.interpolate import interpolate, maps_of
from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_filters.animation.poses import listed_poses, pose_surface, same_triangles
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.animation.transfer import transfer_deformation
from qgeo_filters.caching import cache
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.changes import Changes
from qgeo_filters.filters.registry import registered
from qgeo_filters.hosts.dispatch import as_given
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.parallel import default_workers
from qgeo_filters.surface import Surface


class MovingFilter(Filter):
    """A filter that puts the vertices elsewhere and says how far: ``qgeo_displacement``."""

    pointwise = True  # what needs repair is repaired where the map is sought

    outputs = {"qgeo_displacement": "(n, 3), mesh units: from where the vertex was to where it is"}

    def __call__(
        self, mesh: Any, *, repair: RepairOption = "auto", progress: bool = False, workers: int | None = None
    ) -> Any:
        """Mesh of the same kind elsewhere, see `Filter`; with ``repair="wrap"`` the map is sought between wraps."""
        if repair != "wrap":
            return super().__call__(mesh, repair=repair, progress=progress, workers=workers)
        # What moves is the mesh that was given: what lies deep inside has no place on the wrap, and comes along.
        with cache.held(), default_workers(workers):
            self.repair_, (surface, _) = None, as_given(mesh, "wrap")
            shift = self.moved(surface, progress, "wrap") - surface.vertices
        return self._written(mesh, surface, Changes({"qgeo_displacement": shift}, shift))

    def repaired_parameters(self, repair: Repair) -> dict[str, Any]:
        """Those of `Filter`; `ParameterError` on a wrap, whose vertices are none of the mesh."""
        if not repair.keeps_vertices:
            name = type(self).__name__
            raise ParameterError(
                f"{name} moves the vertices that were given, and none of a wrap: call it alone with repair='wrap', and "
                "the other filters with what it gives"
            )
        return super().repaired_parameters(repair)

    def moved(self, surface: Surface, progress: bool, repair: RepairOption) -> np.ndarray:
        """New positions (n, 3), by maps for which meshes are repaired in such a way; what a subclass implements."""
        raise NotImplementedError(f"{type(self).__name__} must implement moved")

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Displacement by attribute name."""
        return {"qgeo_displacement": self.moved(surface, progress, "auto") - surface.vertices}

    def apply(self, surface: Surface, progress: bool = False) -> Surface:
        """The surface elsewhere, with all of its attributes and the displacement."""
        added = self.compute(surface, progress)
        return surface.with_vertices(surface.vertices + added["qgeo_displacement"]).with_attributes(added)


@registered
class DeformationTransfer(MovingFilter):
    """Moves the mesh as poses of another one move that, with no markers; see `transfer_deformation`.

    Parameters
    ----------
    source : mesh of any kind, or path
        The other mesh at rest, as the filtered one is.
    poses : array, mesh or path, or any iterable of them; of one MeshSet each layer is a pose
        Of the source, as in `transfer_deformation`; what can be gone through only once is kept as a list.
    frame : int
        Number of the pose in which the mesh comes back, from 0, negative ones from the end; all are in ``transfer_``.
    correspondence : MatchResult, BarycentricMap or array-like of int, optional
        As in `transfer_deformation`, of source and mesh; found if it is not given, and together with the
        `Correspondence` filter only once.
    same_pose, same_body, scans, align, accept_unsure : bool
        See `transfer_deformation`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> pose = surface.vertices * [1, 1, 1.2]
    >>> filter = qg.DeformationTransfer(source=surface, poses=[pose], correspondence=np.arange(162))
    >>> out = filter(surface.with_vertices(2 * surface.vertices))
    >>> np.allclose(out.vertices, 2 * pose), sorted(out.attributes)
    (True, ['qgeo_displacement'])
    """

    transfer_: Transfer
    """All poses of the last call, and those of the source."""

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """With itself."""
        pose = surface.vertices * [1.0, 1.0, 1.1]
        return cls(source=surface, poses=[pose], correspondence=np.arange(surface.n_vertices))

    def __init__(
        self,
        *,
        source: Any = None,
        poses: Any = None,
        frame: int = -1,
        correspondence: Any = None,
        same_pose: bool = True,
        same_body: bool = False,
        scans: bool = False,
        align: bool = True,
        accept_unsure: bool = False,
    ) -> None:
        self.source = source
        self.poses = poses
        self.frame = frame
        self.correspondence = correspondence
        self.same_pose = same_pose
        self.same_body = same_body
        self.scans = scans
        self.align = align
        self.accept_unsure = accept_unsure

    def moved(self, surface: Surface, progress: bool, repair: RepairOption) -> np.ndarray:
        """Positions in the chosen pose."""
        if self.source is None or self.poses is None:
            raise ParameterError(
                "DeformationTransfer needs the source and its poses: DeformationTransfer(source=mesh, poses=[...])"
            )
        source, _ = as_given(self.source, "auto")
        self.poses = _kept(self.poses)
        found = self.correspondence
        if found is None:
            found = stages.correspondence_of(source, surface, True, progress, repair_x=repair, repair_y=repair)
        self.transfer_ = transfer_deformation(
            source,
            self.poses,
            surface,
            found,
            same_pose=self.same_pose,
            same_body=self.same_body,
            scans=self.scans,
            align=self.align,
            accept_unsure=self.accept_unsure,
            repair=repair,
            progress=progress,
        )
        count = len(self.transfer_)
        if not -count <= self.frame < count:
            raise ParameterError(f"frame must be from {-count} to {count - 1}, got {self.frame!r}")
        return self.transfer_.positions[self.frame]


@registered
class Interpolate(MovingFilter):
    """Moves the mesh a part of the way to another pose, as rigid as possible; see `interpolate`.

    Parameters
    ----------
    target : mesh of any kind, path or array (n, 3), or any iterable of them
        The other pose, or the poses that the way goes through, as in `interpolate`.
    t : float
        0: where the mesh is, 1: where the (first) target is, 2: the second.
    correspondence : MatchResult, BarycentricMap or array-like of int, optional
        As in `interpolate`; by default a mesh of the same triangles corresponds vertex by vertex, and any other is
        matched, together with the `Correspondence` filter only once.
    accept_unsure : bool
        Whether a match that is not sure is used all the same, with a warning.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> other = surface.with_vertices(surface.vertices + 1)
    >>> half = qg.Interpolate(target=other, t=0.5)(surface)
    >>> np.allclose(half.vertices, surface.vertices + 0.5)
    True
    """

    animation_: Animation
    """The frame of the last call, with notes."""

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """Towards itself, stretched."""
        return cls(target=surface.with_vertices(surface.vertices * [1.0, 1.0, 1.2]))

    def __init__(
        self, *, target: Any = None, t: float = 0.5, correspondence: Any = None, accept_unsure: bool = False
    ) -> None:
        self.target = target
        self.t = t
        self.correspondence = correspondence
        self.accept_unsure = accept_unsure

    def moved(self, surface: Surface, progress: bool, repair: RepairOption) -> np.ndarray:
        """Positions at t."""
        if self.target is None:
            raise ParameterError("Interpolate needs the other pose: Interpolate(target=mesh, t=0.5)")
        if np.ndim(self.t):
            raise ParameterError(f"t must be one number, got {self.t!r}: interpolate has the frames of several")
        self.target = _kept(self.target)
        targets = list(listed_poses(self.target, "target"))
        maps = maps_of(self.correspondence, len(targets))
        for k, target in enumerate(targets):
            with concerning(f"pose {k}"):
                other, _ = pose_surface(surface, target)
            if maps[k] is None and not same_triangles(surface, other):
                maps[k] = stages.correspondence_of(surface, other, True, progress, repair_x=repair, repair_y=repair)
        self.animation_ = interpolate(surface, targets, self.t, maps, accept_unsure=self.accept_unsure)
        return self.animation_.positions[0]


def _kept(poses: Any) -> Any:
    """The same, a list where they can be gone through only once: a filter may be applied again."""
    return list(poses) if isinstance(poses, Iterator) else poses
