"""A prepared shape as arrays and plain values, and back: what another process needs to go on without computing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.decimation import Proxy
from qgeo_filters.errors import MeshError, reason
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.hosts.wrap import Wrap
from qgeo_filters.matching.intrinsic_shape import IntrinsicShape, MetricEmbedding
from qgeo_filters.matching.level import Level
from qgeo_filters.matching.mirror_curve import MirrorPlane
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.search import rough_reflections
from qgeo_filters.matching.symmetry import TOLERANCE, reflection_of
from qgeo_filters.matching.symmetry_result import Symmetry
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

Arrays = dict[str, np.ndarray]
_INTRINSIC = ("fps_distances", "log_hks", "smoothed_mean_curvature", "relief")
_OF_SYMMETRY = ("p2p", "nearest", "side", "fixed", "asymmetry", "regions")


def arrays_of_shape(shape: PreparedShape) -> tuple[Arrays, dict[str, Any]]:
    """Everything expensive that matching takes from a shape, computed where it is not yet.

    Returns
    -------
    arrays : dict of str to array
        Proxies, distances from farthest points, spectra in each metric and of the Laplacian, heat kernels, curvature,
        the self-symmetry and what may be one; the repaired surface, where one had to be repaired.
    values : dict of str to what JSON holds
    """
    # First this, as `match` does: distances from farthest points are then those that it would have.
    shape.prepare()
    reflection_of(shape, shape.parameters)
    quick = shape.parameters.first_attempt()
    arrays: Arrays = {}
    for number, reflection in enumerate(rough_reflections(shape, quick)):
        arrays[f"rough_reflection_{number}"] = reflection
    for place, embedding in enumerate(shape.embeddings):
        arrays[f"eigenvalues_{place}"] = embedding.eigenvalues
        arrays[f"eigenfunctions_{place}"] = embedding.eigenfunctions
        arrays[f"fps_distances_{place}"] = embedding.fps_distances
        arrays |= _spectrum_arrays(f"spectrum_{place}", embedding.spectrum, areas=False)
    arrays["fps"] = shape.fps
    arrays |= {name: getattr(shape.intrinsic, name) for name in _INTRINSIC}
    arrays |= _spectrum_arrays("laplacian", shape.laplacian_spectrum)
    levels = {"fine": (shape.oriented, shape.fine_proxy), "coarse": (shape.fine_proxy.surface, shape.proxy)}
    for name, (above, proxy) in levels.items():
        if proxy.surface is not above:
            arrays |= {f"{name}_vertices": proxy.surface.vertices, f"{name}_faces": proxy.surface.faces}
        arrays |= {f"{name}_{part}": getattr(proxy, of) for part, of in _OF_PROXY.items()}
    values: dict[str, Any] = {"winding": shape.winding}
    found: Symmetry = shape.symmetries[TOLERANCE, shape.parameters]
    arrays |= {f"symmetry_{name}": getattr(found, name) for name in _OF_SYMMETRY}
    places = found.barycentric
    arrays |= {"symmetry_faces": places.faces, "symmetry_coordinates": places.coordinates}
    arrays |= {f"symmetry_curve_{number}": curve for number, curve in enumerate(found.curve)}
    if found.plane is not None:
        arrays |= {"symmetry_plane": np.stack([found.plane.normal, found.plane.origin])}
        values["symmetry_plane_deviation"] = found.plane.deviation
    values["symmetry"] = {name: getattr(found, name) for name in _SYMMETRY_VALUES}
    if shape.repair is not None:
        mended = shape.repair
        arrays |= {"repaired_vertices": mended.surface.vertices, "repaired_faces": mended.surface.faces}
        arrays |= {f"repair_{name}": getattr(mended, name) for name in _OF_REPAIR}
        arrays |= mended.place_arrays
        values |= {"repair": list(mended.report), "wrap_alpha": mended.wrap_alpha}
    return arrays, values


_OF_PROXY = {"places": "faces", "coordinates": "coordinates", "members": "vertices"}
_SYMMETRY_VALUES = ("found", "reason", "score", "orientation", "epsilon")
_OF_REPAIR = ("origin", "vertex_of_original", "face_origin", "turned")


def shape_of_arrays(
    given: Surface, arrays: Mapping[str, np.ndarray], values: Mapping[str, Any], parameters: MatchingParameters
) -> PreparedShape:
    """The prepared shape that `arrays_of_shape` took apart: equal bit for bit, and nothing is computed.

    Parameters
    ----------
    given : Surface
        The surface that was prepared.
    arrays, values
        As they came out of `arrays_of_shape`.
    parameters : MatchingParameters
        Those that it was prepared with.

    Raises
    ------
    MeshError
        Arrays that are missing, or do not fit together: indices are checked, as kernels do not look at them again.
    """
    try:
        shape = _restored(given, {name: frozen(array) for name, array in arrays.items()}, values, parameters)
    except (KeyError, IndexError, TypeError) as error:
        raise MeshError(f"the arrays of a prepared shape do not fit together ({reason(error)})") from error
    _check(shape)
    return shape


def _restored(
    given: Surface, arrays: Arrays, values: Mapping[str, Any], parameters: MatchingParameters
) -> PreparedShape:
    # Past __init__, which checks, repairs and decimates; what it sets is set here.
    shape = object.__new__(PreparedShape)
    shape.parameters, shape.given, shape.winding = parameters, given, values["winding"]
    shape.repair = _repair(given, arrays, values)
    shape.full = given if shape.repair is None else shape.repair.surface
    shape.oriented = shape.full.turned_over() if shape.winding == "inward" else shape.full
    shape.fine_proxy = _proxy("fine", shape.oriented, arrays)
    shape.proxy = _proxy("coarse", shape.fine_proxy.surface, arrays)
    Level.__init__(shape, shape.proxy.surface)
    shape.intrinsic = IntrinsicShape(shape.surface, shape.unit, parameters)
    embeddings = [
        MetricEmbedding(
            weight,
            arrays[f"eigenvalues_{place}"],
            arrays[f"eigenfunctions_{place}"],
            _spectrum(f"spectrum_{place}", arrays, shape.intrinsic.areas),
            arrays[f"fps_distances_{place}"],
        )
        for place, weight in enumerate(parameters.curvature_weights)
    ]
    laplacian = _spectrum("laplacian", arrays, arrays["laplacian_areas"])
    known = {name: arrays[name] for name in _INTRINSIC}
    shape.intrinsic.restore(embeddings, arrays["fps"], laplacian_spectrum=laplacian, **known)
    shape.symmetries = {(TOLERANCE, parameters): _symmetry(shape.full, arrays, values)}
    shape.rough_reflections = {parameters.first_attempt(): _numbered("rough_reflection_", arrays)}
    return shape


def _check(shape: PreparedShape) -> None:
    """Raise `MeshError` for indices out of range, and tables that are not as long as the shape has vertices."""
    n, fine, full = shape.n_vertices, shape.fine_proxy.surface.n_vertices, shape.full.n_vertices
    symmetry = shape.symmetries[TOLERANCE, shape.parameters]
    rough = shape.rough_reflections[shape.parameters.first_attempt()]
    indices = [
        ("fps", shape.fps, len(shape.fps), n),
        ("coarse_members", shape.proxy.vertices, n, fine),
        ("coarse_places", shape.proxy.faces, fine, shape.surface.n_faces),
        ("fine_members", shape.fine_proxy.vertices, fine, full),
        ("fine_places", shape.fine_proxy.faces, full, shape.fine_proxy.surface.n_faces),
        ("symmetry_nearest", symmetry.nearest, full, full),
        ("symmetry_p2p", symmetry.p2p, full, full),
        *((f"rough_reflection_{i}", one, n, n) for i, one in enumerate(rough)),
    ]
    for name, array, count, limit in indices:
        whole = array.dtype.kind == "i" and array.shape == (count,)
        if not whole or array.min(initial=0) < 0 or array.max(initial=0) >= limit:
            raise MeshError(f"{name} of a prepared shape must be {count} numbers from 0 to {limit - 1}")
    functions: list[tuple[np.ndarray, int]] = [(one.eigenfunctions, len(one.eigenvalues)) for one in shape.embeddings]
    functions += [(one.spectrum.eigenfunctions, one.spectrum.k) for one in shape.embeddings]
    functions += [(shape.laplacian_spectrum.eigenfunctions, shape.laplacian_spectrum.k)]
    functions += [(shape.log_hks, 3), (shape.smoothed_mean_curvature[:, None], 1)]
    functions += [(shape.relief[:, None], 1)]
    functions += [(one.fps_distances.T, len(one.fps_distances)) for one in shape.embeddings]
    functions += [(shape.fps_distances.T, len(shape.fps_distances))]
    if any(array.shape != (n, k) or array.dtype.kind != "f" for array, k in functions):
        raise MeshError(f"spectra and distances of a prepared shape must have values at all of its {n} vertices")


def _spectrum_arrays(name: str, spectrum: Spectrum, *, areas: bool = True) -> Arrays:
    group = np.empty(spectrum.k, np.int64)
    for number, members in enumerate(spectrum.multiplets):
        group[list(members)] = number
    found = {
        f"{name}_eigenvalues": spectrum.eigenvalues,
        f"{name}_eigenfunctions": spectrum.eigenfunctions,
        f"{name}_multiplets": group,
    }
    return found | ({f"{name}_areas": spectrum.areas} if areas else {})


def _spectrum(name: str, arrays: Arrays, areas: FloatArray) -> Spectrum:
    group = arrays[f"{name}_multiplets"]
    multiplets = tuple(tuple(np.flatnonzero(group == number).tolist()) for number in range(group.max(initial=-1) + 1))
    return Spectrum(arrays[f"{name}_eigenvalues"], arrays[f"{name}_eigenfunctions"], areas, multiplets)


def _proxy(name: str, above: Surface, arrays: Arrays) -> Proxy:
    """The proxy of a surface; a surface that was small enough is its own."""
    own = f"{name}_vertices" not in arrays
    surface = above if own else Surface(arrays[f"{name}_vertices"], arrays[f"{name}_faces"])
    faces = arrays[f"{name}_places"]
    corners = frozen(surface.faces[faces].astype(np.int64))
    return Proxy(faces, corners, arrays[f"{name}_coordinates"], surface, arrays[f"{name}_members"])


def _repair(given: Surface, arrays: Arrays, values: Mapping[str, Any]) -> Repair | None:
    if "repair" not in values:
        return None
    surface = Surface(arrays["repaired_vertices"], arrays["repaired_faces"])
    origin, vertex_of_original, face_origin, turned = (arrays[f"repair_{name}"] for name in _OF_REPAIR)
    made = given, surface, origin, vertex_of_original, face_origin, turned, tuple(values["repair"])
    if "wrap_faces" not in arrays:
        return Repair(*made)
    faces = arrays["wrap_faces"]
    return Wrap(
        *made, BarycentricMap(faces, corners_of(faces, surface), arrays["wrap_coordinates"]), values["wrap_alpha"]
    )


def _symmetry(full: Surface, arrays: Arrays, values: Mapping[str, Any]) -> Symmetry:
    faces = arrays["symmetry_faces"]
    places = BarycentricMap(faces, corners_of(faces, full), arrays["symmetry_coordinates"])
    plane = None
    if "symmetry_plane" in arrays:
        normal, origin = arrays["symmetry_plane"]
        plane = MirrorPlane(normal, origin, values["symmetry_plane_deviation"])
    per_vertex: dict[str, Any] = {name: arrays[f"symmetry_{name}"] for name in _OF_SYMMETRY}
    curve = tuple(_numbered("symmetry_curve_", arrays))
    return Symmetry(**values["symmetry"], **per_vertex, barycentric=places, curve=curve, plane=plane)


def corners_of(faces: IndexArray, surface: Surface) -> IndexArray:
    """Corners (n, 3) of triangles of a surface (n,), -1 where there is none."""
    there = surface.faces[np.maximum(faces, 0)].astype(np.int64)
    return frozen(np.where((faces >= 0)[:, None], there, -1))


def _numbered(prefix: str, arrays: Arrays) -> list[np.ndarray]:
    """Arrays of one prefix, in the order of their numbers."""
    count = sum(name.startswith(prefix) for name in arrays)
    return [arrays[f"{prefix}{number}"] for number in range(count)]
