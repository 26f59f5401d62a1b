"""What a glTF file has per vertex beside positions: colours, and attributes of one's own, named with an underscore.

Normals and texture coordinates belong to corners, which are joined to vertices here; they are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.gltf_accessors import accessor_values
from qgeo_filters.io.gltf_document import Document
from qgeo_filters.io.raw_mesh import counted

_COLORS, _BYTE = "COLOR_0", 5121


def vertex_attributes(
    document: Document, accessors: Mapping[str, Any], decoded: Mapping[str, np.ndarray], count: int, who: str
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Attributes of a primitive under their names here, and those that cannot be read.

    Parameters
    ----------
    accessors : mapping of str to int
        The primitive's own entry.
    decoded : mapping of str to array
        Those that were compressed.
    count : int
        Number of positions, which is that of values too.
    """
    found: dict[str, np.ndarray] = {}
    unread = []
    for key, index in accessors.items():
        if key != _COLORS and not key.startswith("_"):
            continue
        name = "colors" if key == _COLORS else key.lstrip("_") or key
        try:
            values = decoded[key] if key in decoded else accessor_values(document, index, who)
            is_byte = document.element("accessors", index, who).get("componentType") == _BYTE
        except MeshError:
            unread.append(name)
            continue
        if len(values) != count:
            unread.append(name)
            continue
        if key == _COLORS and is_byte and values.dtype.kind == "f":
            values = np.rint(255 * values).astype(np.uint8)
        found[name] = values[:, 0] if values.shape[1] == 1 else values
    return found, unread


def joined_attributes(
    blocks: Sequence[Mapping[str, np.ndarray]], index: IndexArray
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Attributes of all blocks of positions once these were joined to vertices, and what was passed over.

    Parameters
    ----------
    blocks : sequence of mappings of str to array
    index : (total,) int64
        Vertex of each position, of all blocks one after the other.
    """
    attributes, notes = {}, []
    first = np.empty(index.max(initial=-1) + 1, dtype=np.int64)
    first[index[::-1]] = np.arange(len(index))[::-1]
    for name in dict.fromkeys(name for block in blocks for name in block):
        arrays = [block[name] for block in blocks if name in block]
        if len(arrays) < len(blocks) or len({(array.shape[1:], array.dtype) for array in arrays}) > 1:
            notes.append(f"attribute {name!r} passed over, which is not the same for all parts of the scene")
            continue
        values = np.concatenate(arrays)
        attributes[name] = values[first]
        differing = (values != values[first][index]).reshape(len(values), -1).any(axis=1)
        if differing.any():
            n_vertices = len(np.unique(index[differing]))
            where = counted(n_vertices, "vertex", "vertices")
            notes.append(f"attribute {name!r} differs between positions that were joined to {where}; the first is kept")
    return attributes, notes
