"""What `match` returns: the map from X to Y, how good it is, and why it was chosen; and what one does with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, MirrorOption, PartialOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.wrap import Wrap, wrap_surface
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching import map_files, map_landmarks, map_transfer
from qgeo_filters.matching.map_errors import map_errors
from qgeo_filters.matching.maps.barycentric import BarycentricMap, nearest_around
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.match_story import html_story, story
from qgeo_filters.repair.welding import welded
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices, frozen


@dataclass(frozen=True, eq=False)
class MatchResult:
    """Map from each vertex of X to a vertex of Y, and what people do with one.

    Attributes
    ----------
    x, y : Surface
        The shapes as they were given.
    p2p : (n_x,) int64
        Vertex of Y for each vertex of X; -1: no partner.
    inverse : (n_y,) int64
        Vertex of X for each vertex of Y; -1: no partner.
    functional_map : (20, 20) float64
        C in the eigenfunctions of the distances: ``phi_x @ C`` approximates ``phi_y[p2p]``, for unit-area shapes.
    c_xy : float
        Distance of the first 20 eigenfunctions, paired along the map (paper, sec. 4.2), see `spectral_distance`; both
        in the last metric that the shapes were prepared in, which is the lifted one.
    distortion : (n_x,) float64
        Mean over points q of :math:`|d_X(p, q) - d_Y(Tp, Tq)|`, in units of sqrt(area).
    score : float
        Mean of the distortion over the area: 0 for an isometry.
    runner_up : float
        Mean distortion of the best other map that keeps the orientation; inf if none was proposed.
    margin : float
        How many times the chosen map's cost (strain, tearing, folding, unlike parts) the runner-up's is.
    orientation : float
        See `orientation`: near 0.7 for a map between shapes of the same handedness; negative if Y is a mirror image.
    hks_agreement : float
        Of heat kernels along the map, see `hks_agreement`: above 0.9 between poses of one shape.
    confident : bool
        Whether the map stands clear of the others, keeps distances, relates like parts, has one orientation, and left
        and right can be told: of an open sheet nobody knows which side is out, see `Surface.winding`.
    explanation : str
        Why it is confident, or what is ambiguous, in a sentence; and which shape was inside out.
    regions_x, regions_y : (n_x,), (n_y,) int32
        Regions of equal number on both shapes, see `eigenfunction_regions`.
    positions : (n_x, 3) float64
        X deformed onto Y, in Y's frame and unit.
    barycentric : BarycentricMap
        Point within a triangle of Y for each vertex of X: that nearest to its position, near its vertex.
    log : MatchLog
        Every map that was proposed, and what became of it: why this one was chosen.
    repairs : tuple of str
        What was repaired before, a sentence each, beginning with "X: " or "Y: "; empty if nothing was. A vertex that
        had to go has no partner.
    landmark_errors : (k,) float64
        Distance on Y between the image of each landmark that was given and its partner, in units of sqrt(area).
    overlap_x, overlap_y : float
        Share of the area of either shape, as it was matched, that has a partner: 1 but for partial matches. Of a shape
        that was repaired or wrapped, that is the repaired surface or the wrap: ``p2p`` tells which given vertices have
        none, such as those deep inside.
    wrap_x, wrap_y : float
        The ``alpha`` of the closed surface that was matched in place of either shape, see `wrap_surface`; 0: none was.
    normalize, partial, mirror : bool, bool or "auto", {"auto", "no", "yes"}
        The options of `match` that it was found with.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> y = x.with_vertices(2 * x.vertices + [5, 0, 0])  # as large again, and elsewhere
    >>> found = qg.match(x, y)
    >>> found.transfer(np.where(x.vertices[:, 0] > 0, 1, 0))[:8]  # labels: by majority
    array([0, 0, 1, 1, 0, 0, 0, 0])
    >>> np.allclose(found.transfer(x.vertices), x.vertices, atol=0.01)  # numbers: interpolated
    True
    >>> found.landmarks([17, 140]).vertices
    array([ 17, 140])
    """

    x: Surface
    y: Surface
    p2p: IndexArray
    inverse: IndexArray
    functional_map: FloatArray
    c_xy: float
    distortion: FloatArray
    score: float
    runner_up: float
    margin: float
    orientation: float
    hks_agreement: float
    confident: bool
    explanation: str
    regions_x: npt.NDArray[np.int32]
    regions_y: npt.NDArray[np.int32]
    positions: FloatArray
    barycentric: BarycentricMap
    log: MatchLog
    repairs: tuple[str, ...] = ()
    landmark_errors: FloatArray = field(default_factory=lambda: frozen(np.zeros(0)))
    overlap_x: float = 1.0
    overlap_y: float = 1.0
    wrap_x: float = 0.0
    wrap_y: float = 0.0
    normalize: bool = True
    partial: PartialOption = "auto"
    mirror: MirrorOption = "auto"

    @cached_property
    def around_x(self) -> Wrap | None:
        """The closed surface that was matched in place of X, None: none was; made again for a result from a file."""
        return wrap_surface(self.x, alpha=self.wrap_x) if self.wrap_x else None

    @cached_property
    def around_y(self) -> Wrap | None:
        """That which was matched in place of Y."""
        return wrap_surface(self.y, alpha=self.wrap_y) if self.wrap_y else None

    @cached_property
    def inverse_barycentric(self) -> BarycentricMap:
        """Point within a triangle of X for each vertex of Y: where the deformed X is nearest, near its `inverse`."""
        joined, _ = welded(self.x.vertices, self.x.faces)
        return nearest_around(self.y.vertices, self.inverse, self.positions, self.x.faces, joined)

    def transfer(
        self,
        values: npt.ArrayLike,
        to: Literal["y", "x"] = "y",
        *,
        interpolate: bool | None = None,
        missing: Any = None,
    ) -> np.ndarray:
        """Values of the vertices of one shape on those of the other.

        Parameters
        ----------
        values : array-like, shape (n, ...)
            One for each vertex of the shape that they come from: numbers, vectors (by their components), colours,
            texture coordinates; labels that are whole numbers, booleans or text.
        to : {"y", "x"}
            "y": values of X on Y, "x": values of Y on X.
        interpolate : bool, optional
            Whether values are interpolated within a triangle, or taken for labels. By default floating-point numbers
            are interpolated; for whole numbers that measure something, such as colours from 0 to 255, say True.
        missing : optional
            What stands at vertices without a partner; by default NaN, -1, False, "" or None, by the type of the values.

        Returns
        -------
        (m, ...) array
            Of the values' type; whole numbers that were interpolated are float64. A label is that of most of the area
            which is mapped to the vertex; where nothing is, that of the largest part of the triangle it lies in.

        Raises
        ------
        ParameterError
            Not one value for each vertex; text that is to be interpolated; unsigned labels where a partner is missing,
            and ``missing`` is not given.

        Notes
        -----
        Vectors are not turned along with the surface. Texture coordinates are interpolated within one triangle of the
        source, on one side of every seam, so that each vertex gets a true place of the texture; a triangle of the
        target that lies across a seam has corners on both of its sides, and shows the texture between them squeezed.
        Colours do not know seams: transfer those where that matters.

        Examples
        --------
        >>> x = qg.testing.sample_surface()
        >>> found = qg.match(x, x.with_vertices(2 * x.vertices))
        >>> organ = np.where(x.vertices[:, 0] > 0, "head", "tail")
        >>> [str(name) for name in found.transfer(organ)[:3]]  # (n_y,) labels
        ['tail', 'tail', 'head']
        >>> found.transfer(found.y.vertices, to="x").shape  # (n_x, 3) points of Y
        (162, 3)
        >>> found.transfer(np.arange(162) % 256, interpolate=True).dtype
        dtype('float64')
        """
        source, target = ("X", "Y") if self._forward(to) else ("Y", "X")
        here, there = (self.x, self.y) if source == "X" else (self.y, self.x)
        images, place = (self.p2p, self.inverse_barycentric) if source == "X" else (self.inverse, self.barycentric)
        array = map_transfer.checked_values(values, here.n_vertices, there.n_vertices, source, target)
        if interpolate is None:
            interpolate = array.dtype.kind in "fc"
        if not interpolate:
            return map_transfer.elected(array, here.vertex_areas, images, place, missing)
        if array.dtype.kind not in "fciub":
            raise ParameterError(f"values of type {array.dtype} cannot be interpolated")
        return map_transfer.interpolated(array, place, missing)

    def landmarks(
        self, points: Landmarks | npt.ArrayLike, to: Literal["y", "x"] = "y", *, tolerance: float = 0.05
    ) -> Landmarks:
        """Landmarks of one shape on the other.

        Parameters
        ----------
        points : Landmarks, array-like of int (k,), or array-like (k, 3)
            Of X, or of Y with ``to="x"``: as from a file (`read_landmarks`), as vertices, or as points, which are
            moved to the closest point of the surface. -1 and NaN: not known.
        to : {"y", "x"}
            "y": landmarks of X on Y, "x": landmarks of Y on X.
        tolerance : float
            How far from the surface a point may be, as a share of the diagonal of its bounding box.

        Returns
        -------
        Landmarks
            Points on the surface and the vertices nearest to them, under the same names; NaN and -1 where a landmark
            is not known or has no partner.

        Raises
        ------
        ParameterError
            A landmark off the surface: which one, and how far; a vertex out of range.

        Examples
        --------
        >>> x = qg.testing.sample_surface()
        >>> found = qg.match(x, x.with_vertices(2 * x.vertices))
        >>> found.landmarks([17, 140]).vertices
        array([ 17, 140])
        >>> np.allclose(found.landmarks(x.vertices[[17]]).points, 2 * x.vertices[[17]], atol=0.02)
        True
        """
        given = map_landmarks.as_landmarks(points)
        if self._forward(to):
            place = map_landmarks.located(given, self.x, "X", tolerance)
            image = map_landmarks.images_on_target(place, self.positions, self.p2p, self.y)
        else:
            place = map_landmarks.located(given, self.y, "Y", tolerance)
            near = place.nearest_corner
            starts = np.where(near >= 0, self.inverse[near], -1)
            joined, _ = welded(self.x.vertices, self.x.faces)
            points = place.pulled_back(self.y.vertices)
            image = nearest_around(points, starts, self.positions, self.x.faces, joined)
        found = map_landmarks.landmarks_at(given.names, image, self.y if to == "y" else self.x)
        return Landmarks(found.names, found.points, found.vertices, given.frame)

    def error(self, truth: npt.ArrayLike, *, workers: int | None = None) -> FloatArray:
        """Geodesic distance on Y from each image to the true one, in units of sqrt(area) of Y, shape (n_x,).

        Parameters
        ----------
        truth : array-like of int, shape (n_x,)
            True vertex of Y for each vertex of X; -1: not known.
        workers : int, optional
            Threads; all cores by default.

        Returns
        -------
        (n_x,) float64
            NaN where the truth is not known, or the map has no partner: ``np.nanmean`` is the mean over the rest.

        Raises
        ------
        ParameterError, MeshError
            Not that many vertices, or vertices out of range.

        See Also
        --------
        qgeo_filters.evaluation.geodesic_error : the same of any map; `symmetric_errors` also of the mirrored truth.
        """
        target = checked_indices(truth, self.y.n_vertices, "truth", missing=True)
        if len(target) != len(self.p2p):
            raise ParameterError(f"truth must hold a vertex for each of the {len(self.p2p)} of X, got {len(target)}")
        repaired = any(line.startswith("Y: ") for line in self.repairs)
        return map_errors(self.y, self.p2p, target, repaired, self.around_y, workers)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write a table with a row for each vertex of X.

        Its columns are ``x_vertex`` and ``y_vertex`` (from 0; -1: no partner), the point of Y that the vertex is mapped
        to (``y_x``, ``y_y``, ``y_z``), its triangle of Y and the weights of the triangle's corners (``y_face``,
        ``weight_0`` to ``weight_2``), and the ``distortion`` there, in units of sqrt(area). Numbers that there are not
        are empty cells, which ``pandas.read_csv`` reads as NaN.
        """
        map_files.write_map_table(path, self.p2p, self.barycentric, self.y, self.distortion)

    def to_npz(self, path: str | PathLike[str]) -> None:
        """Write everything, both shapes included, to an .npz file that `from_npz` reads and ``numpy.load`` opens.

        The arrays have the names of the attributes; ``x_vertices``, ``x_faces``, ``y_vertices`` and ``y_faces`` are the
        shapes, ``barycentric_faces``, ``barycentric_corners`` and ``barycentric_coordinates`` the map into triangles.

        Raises
        ------
        ParameterError
            A shape with an attribute of Python objects.
        """
        map_files.write_arrays(path, map_files.arrays_of(self))

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> MatchResult:
        """The result that `to_npz` wrote, or ``qgeo match`` as result.npz.

        Raises
        ------
        MeshError
            A file that is none, or is damaged; the message starts with the path.
        """
        return cls(**map_files.read_match(path, cls))

    def __repr__(self) -> str:
        return story(self)

    def _repr_html_(self) -> str:
        return html_story(self)

    @staticmethod
    def _forward(to: str) -> bool:
        if to not in ("x", "y"):
            raise ParameterError(f"to must be 'y' (values of X on Y) or 'x' (values of Y on X), got {to!r}")
        return to == "y"
