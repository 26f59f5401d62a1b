"""A match as a record of a store, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.collection.records import Record
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.compatibility import SPARE_EIGENPAIRS, compatibility_of_spectra
from qgeo_filters.matching.map_files import DOCUMENT, arrays_of, fields_of
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.shape_arrays import corners_of
from qgeo_filters.spectral.canonical import group_multiplets
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface

# Eigenpairs that are compared.
_COMPARED = 20
# What the shapes and the triangles give back.
_DERIVED = ("x_", "y_", "barycentric_corners", DOCUMENT)


def record_of_match(found: MatchResult, x: PreparedShape, y: PreparedShape, seconds: float) -> Record:
    """Arrays and values of a match; both shapes are records of their own."""
    plain = {name: array for name, array in arrays_of(found).items() if not name.startswith(_DERIVED)}
    values = {name: array.item() for name, array in plain.items() if array.ndim == 0}
    values |= {"explanation": found.explanation, "repairs": list(found.repairs), "log": found.log.table()}
    values |= {"d_s": pair_compatibility(found, x, y), "seconds": seconds}
    return Record({name: array for name, array in plain.items() if array.ndim}, values)


def match_of_record(record: Record, x: Surface, y: Surface) -> MatchResult:
    """The match that a record was made of, equal bit for bit.

    Raises
    ------
    MeshError
        Arrays that do not fit the surfaces.
    """
    arrays: dict[str, Any] = dict(record.arrays)
    arrays |= {"x_vertices": x.vertices, "x_faces": x.faces, "y_vertices": y.vertices, "y_faces": y.faces}
    faces = arrays["barycentric_faces"]
    if faces.max(initial=-1) >= y.n_faces:
        raise MeshError(f"barycentric_faces of the match must be below {y.n_faces}")
    arrays["barycentric_corners"] = corners_of(faces, y)
    return MatchResult(**fields_of(arrays, record.values, MatchResult))


def pair_compatibility(found: MatchResult, x: PreparedShape, y: PreparedShape) -> float:
    """D(S) of the two shapes along the map, see `compatibility`; NaN where a vertex has no partner."""
    image = _on_repaired(found.p2p, x.repair, y.repair)
    k = min(_COMPARED, *(shape.embedding(-1).eigenfunctions.shape[1] for shape in (x, y)))
    if (image < 0).any():
        return float("nan")
    return compatibility_of_spectra(
        [_wide_spectrum(shape) for shape in (x, y)], [np.arange(len(image)), image], k=k
    ).d_s


def _wide_spectrum(shape: PreparedShape) -> Spectrum:
    """A few more eigenfunctions than are compared, at full resolution."""
    embedding = shape.embedding(-1)
    count = min(_COMPARED + SPARE_EIGENPAIRS, embedding.eigenfunctions.shape[1])
    values = embedding.eigenvalues[:count]
    functions = shape.interpolation @ embedding.eigenfunctions[:, :count].astype(np.float64)
    return Spectrum(values, functions, shape.full.vertex_areas / shape.full.area, group_multiplets(values))


def _on_repaired(p2p: IndexArray, of: Repair | None, on: Repair | None) -> IndexArray:
    """A map between the given vertices as one between those that were matched."""
    image = p2p if of is None else p2p[of.origin]
    return image if on is None else np.where(image >= 0, on.vertex_of_original[np.maximum(image, 0)], -1)
