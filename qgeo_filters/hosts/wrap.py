"""A closed surface shrunk around a mesh that no repair can mend, with the way back to the vertices that were given.

What CT gives, or a character made of garments: hundreds of handles and pieces, sheets that cross, walls with two sides.
The wrap is what can be seen of it from outside, through openings larger than a given size.

References
----------
Portaneri, Rouxel-Labbe, Hemmer, Cohen-Steiner, Alliez, "Alpha wrapping with an offset", SIGGRAPH 2022, as PyMeshLab
has it from CGAL.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.connectivity import vertex_components
from qgeo_filters.equal_rows import occurring
from qgeo_filters.errors import DisconnectedError, MeshError, ParameterError, require_package
from qgeo_filters.hosts.arrays import is_path, raw_mesh
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.repair.sound import SoundMesh, sound_mesh
from qgeo_filters.repair.triangle_soup import most_lost, repaired_mesh
from qgeo_filters.repair.winding import relative_volume
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

_log = logging.getLogger(__name__)

#: Openings up to this fraction of the diagonal are closed; raw CT skulls have the genus 2 then, at 2 % one to five.
ALPHA = 0.03
# Distance of the wrap from the mesh, relative to alpha.
_OFFSET = 0.05
# A sheet wrapped on both sides is two offsets thick in the mean, an arm twenty and more.
_SHEET = 6.0


@dataclass(frozen=True, eq=False, repr=False)
class Wrap(Repair):
    """A closed surface around a mesh, in place of its repair, see `wrap_surface`.

    ``origin`` is the nearest original vertex of each vertex of the wrap, ``vertex_of_original`` the nearest vertex of
    the wrap of each original one, ``face_origin`` the nearest original face of each middle of a triangle.

    Attributes
    ----------
    places : BarycentricMap
        Nearest point of the wrap for each original vertex; none for those that lie too deep inside.
    alpha : float
        As it was given to `wrap_surface`.

    Examples
    --------
    >>> sphere = qg.testing.sample_surface()
    >>> soup = sphere.vertices[sphere.faces].reshape(-1, 3) * 1.01, np.arange(960).reshape(-1, 3)
    >>> wrap = qg.wrap_surface(soup, alpha=0.1)
    >>> wrap.surface.is_manifold, wrap.surface.genus, bool((wrap.vertex_of_original >= 0).all())
    (True, 0, True)
    """

    places: BarycentricMap
    alpha: float

    @property
    def keeps_vertices(self) -> bool:
        """False: its vertices are its own."""
        return False

    @property
    def wrap_alpha(self) -> float:
        """`alpha`."""
        return self.alpha

    @property
    def place_arrays(self) -> dict[str, np.ndarray]:
        """Triangles and weights of `places`."""
        return {"wrap_faces": self.places.faces, "wrap_coordinates": self.places.coordinates}

    def map_back(self, values: npt.ArrayLike) -> np.ndarray:
        """Values at the original vertices: interpolated, or of the nearest vertex where they are whole numbers."""
        return self.places.pulled_back(self._of_repaired(values))

    def places_on_given(self, places: BarycentricMap) -> BarycentricMap:
        """Nearest points of triangles of ``given``, for points of triangles of the wrap."""
        return closest_points(places.pulled_back(self.surface.vertices), self.given)

    def areas_on_given(self, areas: FloatArray) -> FloatArray:
        """Area of each original vertex: of the vertices of the wrap to which it is the nearest one."""
        return np.bincount(self.origin, areas, minlength=len(self.vertex_of_original)).astype(np.float64)


def wrap_surface(obj: Any, *, alpha: float = ALPHA) -> Wrap:
    """Closed manifold surface around whatever triangles there are: what ``repair="wrap"`` makes.

    Pass it to `match` or `self_symmetry` in place of the mesh for another ``alpha``: results are on the given vertices.

    For scans and models that are refused otherwise: one-sided, with hundreds of handles, made of many pieces that touch
    or cross. Openings and gaps up to ``alpha`` are closed, hollows inside are left out, and details below ``alpha`` are
    smoothed in hollows. Not for open sheets, such as a face scanned from one side: a wrap has two sides.

    Parameters
    ----------
    obj : Surface, (V, F), mesh object or path
        As for `repair_surface`.
    alpha : float
        Fraction of the diagonal of the bounding box: the size of the triangles, and of the openings that are closed.

    Returns
    -------
    Wrap
        The attributes of a vertex of the wrap are those of the nearest vertex that was given.

    Raises
    ------
    ParameterError
        ``alpha`` is not between .001 and .5.
    MeshError
        An open sheet, or several bodies apart from each other of which none has nine tenths of the area.

    Examples
    --------
    >>> box = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]]
    >>> sides = [[0, 1, 3], [0, 2, 3], [4, 5, 7], [4, 6, 7], [0, 1, 5], [0, 4, 5], [2, 3, 7], [2, 6, 7]]
    >>> wrap = qg.wrap_surface((box, sides), alpha=0.1)  # two sides are missing, larger than alpha
    Traceback (most recent call last):
        ...
    qgeo_filters.errors.MeshError: the mesh is an open sheet, or open wider than 10 % of the diagonal: ...
    >>> qg.wrap_surface((box, [*sides, [0, 2, 6], [0, 4, 6], [1, 3, 7], [1, 5, 7]]), alpha=0.1).surface.genus
    0
    """
    if not isinstance(alpha, (float, int, np.floating, np.integer)) or not 0.001 <= alpha <= 0.5:
        raise ParameterError(f"alpha must be a fraction of the diagonal, from 0.001 to 0.5, got {alpha!r}")
    sound = sound_mesh(raw_mesh(obj, repair=True))
    with path_in_errors(obj if is_path(obj) else None):
        vertices, faces = _alpha_wrap(sound, alpha)
        try:
            repaired = repaired_mesh(sound_mesh(RawMesh(vertices, faces, {})), most_lost=most_lost("auto"))
        except DisconnectedError:
            raise DisconnectedError(
                f"the wrap falls into bodies that are more than {100 * alpha:.3g} % of the diagonal apart, none of "
                "which has nine tenths of the area: pass the one that is meant, or "
                "wrap_surface(mesh, alpha=...) with a larger alpha"
            ) from None
        surface = Surface.from_raw(repaired.mesh)
        if 2 * relative_volume(surface.vertices, surface.faces) * np.sqrt(surface.area) < (
            _SHEET * _OFFSET * alpha * _diagonal(sound)
        ):
            raise MeshError(
                f"the mesh is an open sheet, or open wider than {100 * alpha:.3g} % of the diagonal: a wrap would go "
                "inside and have two sides; match it as it is, as a part of a whole if there is one (partial=True)"
            )
    given = obj if isinstance(obj, Surface) else Surface.from_raw(sound.raw)
    return _wrap(given, surface, sound, alpha, repaired.report)


def _diagonal(sound: SoundMesh) -> float:
    used = sound.vertices[occurring(sound.faces, len(sound.vertices))]
    return float(np.linalg.norm(np.ptp(used, axis=0)))


def _alpha_wrap(sound: SoundMesh, alpha: float) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of the wrap, where the mesh is."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a wrap")
    corners, size = sound.vertices[sound.faces].reshape(-1, 3), _diagonal(sound)
    middle = corners.mean(axis=0)
    if not size:
        raise MeshError("all vertices of the mesh are at one place: there is nothing to wrap")
    meshes = pymeshlab.MeshSet(verbose=False)
    # Loose triangles: of a mesh whose faces are not of one orientation some are lost on the way to CGAL.
    loose = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    meshes.add_mesh(pymeshlab.Mesh((corners - middle) / size, loose))
    percent = 100 * alpha
    meshes.generate_alpha_wrap(
        alpha=pymeshlab.PercentageValue(percent), offset=pymeshlab.PercentageValue(_OFFSET * percent)
    )
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix() * size + middle, mesh.face_matrix()


def _wrap(given: Surface, surface: Surface, sound: SoundMesh, alpha: float, said: tuple[str, ...]) -> Wrap:
    """The wrap with its vertices and those of the mesh beside each other."""
    vertices, faces = sound.vertices, sound.faces
    used = occurring(faces, len(vertices))
    origin = used[cKDTree(vertices[used]).query(surface.vertices)[1]]
    attributes = {name: values[origin] for name, values in given.attributes.items()}
    surface = Surface(surface.vertices, surface.faces, attributes)
    places = closest_points(vertices, surface)
    gap = np.linalg.norm(places.pulled_back(surface.vertices) - vertices, axis=1)
    off = np.isin(np.arange(len(vertices)), used, invert=True) | (gap > alpha * _diagonal(sound))
    places = places.only(~off)
    nearest = places.nearest_corner
    face_origin = closest_points(surface.vertices[surface.faces].mean(axis=1), Surface(vertices, faces)).faces
    report = [*sound.notes, _sentence(sound, surface, alpha), *said]
    if off.any():
        lost = counted(int(off.sum()), "vertex has", "vertices have")
        report.append(f"{lost} no place on it: loose, or too deep inside")
    for change in report:
        _log.info("wrap: %s", change)
    turned = np.zeros(surface.n_faces, dtype=bool)
    return Wrap(
        given,
        surface,
        frozen(origin),
        frozen(nearest),
        frozen(face_origin),
        frozen(turned),
        tuple(report),
        places,
        float(alpha),
    )


def _sentence(sound: SoundMesh, surface: Surface, alpha: float) -> str:
    edges = np.concatenate([sound.faces[:, :2], sound.faces[:, 1:]])
    pieces = len(np.unique(vertex_components(edges, len(sound.vertices))[1][sound.faces[:, 0]]))
    of = f" in {pieces} pieces" if pieces > 1 else ""
    return (
        f"{counted(len(sound.faces), 'face')}{of} wrapped in a closed surface of {surface.n_faces} faces and genus "
        f"{surface.genus}; openings up to {100 * alpha:.3g} % of the diagonal are closed"
    )
