"""glTF files written by hand, so that tests say byte for byte what a reader is given."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

COMPONENT_TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class GltfFile:
    """A scene under construction: ``tree`` is its JSON, to be bent at will, ``binary`` its one buffer."""

    def __init__(self) -> None:
        self.binary = b""
        self.tree: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
        }

    def view(self, data: bytes, **entries: Any) -> int:
        """Index of a new buffer view with these bytes."""
        self.binary += bytes(-len(self.binary) % 4)
        start = len(self.binary)
        self.binary += data
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": start, "byteLength": len(data), **entries})
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, **entries: Any) -> int:
        """Index of a new accessor with these values, of their own type."""
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[1 if values.ndim == 1 else values.shape[1]]
        code = COMPONENT_TYPES[values.dtype.str[1:]]
        entry = {"bufferView": self.view(values.tobytes()), "componentType": code, "count": len(values), "type": kind}
        self.tree["accessors"].append({**entry, **entries})
        return len(self.tree["accessors"]) - 1

    def primitive(self, points: np.ndarray, indices: np.ndarray | None = None, **entries: Any) -> dict[str, Any]:
        """A new primitive of the first mesh."""
        made: dict[str, Any] = {"attributes": {"POSITION": self.accessor(points)}, **entries}
        if indices is not None:
            made["indices"] = self.accessor(indices)
        self.tree["meshes"][0]["primitives"].append(made)
        return made

    def write(self, path: Path) -> Path:
        """Write as GLB, or as text with the buffer inside where the suffix is .gltf."""
        tree = dict(self.tree)
        if path.suffix == ".gltf":
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
            tree.setdefault("buffers", [{"byteLength": len(self.binary), "uri": uri}])
            path.write_text(json.dumps(tree))
            return path
        tree.setdefault("buffers", [{"byteLength": len(self.binary)}])
        text = json.dumps(tree).encode()
        path.write_bytes(
            glb((b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", self.binary + bytes(-len(self.binary) % 4)))
        )
        return path


def glb(*chunks: tuple[bytes, bytes]) -> bytes:
    """The bytes of a binary glTF file."""
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
