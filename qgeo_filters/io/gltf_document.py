"""The JSON of a glTF file and the bytes that it speaks of, checked where they are used.

Everything here may come from a damaged file: an index, a count or an offset is believed only once it was compared with
what is there, so that no array grows larger than the file.
"""

from __future__ import annotations

import base64
import binascii
import json
import reprlib
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes, urlsplit

from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.damage import DAMAGED_FILE

_MAGIC = b"glTF"
_JSON, _BINARY = b"JSON", b"BIN\0"


@dataclass(frozen=True, eq=False)
class Document:
    """An opened glTF file.

    Attributes
    ----------
    tree : dict
        Its JSON.
    binary : bytes
        The first binary chunk of a GLB file; empty for a text file.
    path : path
        Its file, beside which those lie that it names.
    buffers : dict of int to bytes
        Those that were asked for so far.
    """

    tree: dict[str, Any]
    binary: bytes
    path: Path
    buffers: dict[int, bytes] = field(default_factory=dict)

    def elements(self, kind: str) -> list[Any]:
        """All elements of one kind ("nodes", "accessors" ...); none where the file has none."""
        found = self.tree.get(kind, [])
        if not isinstance(found, list):
            raise MeshError(f"{kind} is {reprlib.repr(found)}, expected a list")
        return found

    def element(self, kind: str, index: Any, who: str) -> dict[str, Any]:
        """The element that ``who`` refers to, or `MeshError` where there is none of this index."""
        found = self.elements(kind)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise MeshError(f"{who} refers to {kind}[{reprlib.repr(index)}], but there are {len(found)}")
        return mapping(found[index], f"{kind}[{index}]")

    def buffer(self, index: int, who: str) -> bytes:
        """Bytes of a buffer: inside the file, in a data URI, or in a file beside it."""
        if index not in self.buffers:
            entry, name = self.element("buffers", index, who), f"buffers[{index}]"
            length, uri = whole(entry, "byteLength", name), entry.get("uri")
            data = self.binary if uri is None and index == 0 else self._at(uri, length, name)
            if len(data) < length:
                raise MeshError(f"{name} should hold {length} bytes, but only {len(data)} are there")
            self.buffers[index] = data[:length]
        return self.buffers[index]

    def view(self, index: Any, who: str) -> tuple[bytes, int]:
        """Bytes of a buffer view and the step between its items, 0 for none."""
        entry, name = self.element("bufferViews", index, who), f"bufferViews[{index}]"
        owner = entry.get("buffer")
        compression = next((key for key in extensions(entry, name) if "meshopt_compression" in key), None)
        if compression and "uri" not in self.element("buffers", owner, name):  # else the same uncompressed
            raise MeshError(
                f"its buffers are compressed ({compression}), which is not read; write the file without "
                "(gltfpack: leave out -c and -cc)"
            )
        start, length = whole(entry, "byteOffset", name, 0), whole(entry, "byteLength", name)
        self.element("buffers", owner, name)
        data = self.buffer(int(owner or 0), name)
        if start + length > len(data):
            raise MeshError(f"{name} ends at byte {start + length} of buffers[{owner}], which has {len(data)}")
        return data[start : start + length], whole(entry, "byteStride", name, 0)

    def _at(self, uri: Any, length: int, name: str) -> bytes:
        if not isinstance(uri, str):
            raise MeshError(f"{name} has no data: neither a URI nor a binary chunk of the file")
        if uri[:5].lower() == "data:":
            kind, _, data = uri.partition(",")
            try:
                return base64.b64decode(data) if kind.endswith(";base64") else unquote_to_bytes(data)
            except (binascii.Error, ValueError) as error:
                raise MeshError(f"the data URI of {name} cannot be decoded ({reason(error)})") from error
        if urlsplit(uri).scheme or urlsplit(uri).netloc:
            raise MeshError(f"{name} lies at {reprlib.repr(uri)}; only files beside this one are read")
        file = self.path.parent / unquote(uri)
        if "\0" in uri or not file.is_file():
            raise MeshError(f"{name} is in the file {unquote(uri)!r}, which is missing beside it")
        with file.open("rb") as stream:
            return stream.read(min(length, file.stat().st_size))


def opened(path: Path) -> Document:
    """The document of a file, binary or text, told by its first bytes.

    Raises
    ------
    MeshError
        No glTF 2, or a file that was cut off.
    """
    content = path.read_bytes()
    text, binary = _chunks(content) if content[:4] == _MAGIC else (content, b"")
    try:
        tree = json.loads(text.rstrip(b"\0").decode("utf-8-sig"))  # the chunk may be filled up with zeros
    except DAMAGED_FILE as error:
        raise MeshError(f"not a readable glTF file ({reason(error)})") from error
    if not isinstance(tree, dict) or not isinstance(tree.get("asset"), dict):
        raise MeshError("not a readable glTF file (its JSON has no 'asset')")
    version = str(tree["asset"].get("version"))
    if version.split(".")[0] != "2":
        raise MeshError(f"glTF of version {version[:20]} is not read, only 2; convert it first")
    return Document(tree, binary, path)


def mapping(value: Any, name: str) -> dict[str, Any]:
    """The value, which must be a JSON object."""
    if not isinstance(value, dict):
        raise MeshError(f"{name} is {reprlib.repr(value)}, expected an object")
    return value


def extensions(entry: dict[str, Any], name: str) -> dict[str, Any]:
    """Extensions of an element by their names."""
    return mapping(entry.get("extensions", {}), f"extensions of {name}")


def whole(entry: dict[str, Any], key: str, name: str, default: int | None = None) -> int:
    """The whole number of this key, from 0."""
    value = entry.get(key, default)
    if isinstance(value, float) and value.is_integer():  # some exporters write 3.0
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise MeshError(f"{key} of {name} is {reprlib.repr(value)}, expected a whole number")
    return value


def _chunks(content: bytes) -> tuple[bytes, bytes]:
    """JSON and the first binary chunk of a GLB file; chunks of other kinds are passed over, as the format wants it."""
    if len(content) < 20:
        raise MeshError(f"not a readable glTF file ({len(content)} bytes are too few)")
    version, length = struct.unpack_from("<II", content, 4)
    if version != 2:
        raise MeshError(f"GLB of version {version} is not read, only 2; convert it first")
    found: dict[bytes, bytes] = {}
    start = 12
    while start + 8 <= min(length, len(content)):
        size, kind = struct.unpack_from("<I4s", content, start)
        if start + 8 + size > len(content):
            raise MeshError(f"the file is cut off: {len(content)} bytes of {max(length, start + 8 + size)}")
        found.setdefault(kind, content[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON not in found:
        raise MeshError("not a readable glTF file (no JSON inside)")
    return found[_JSON], found.get(_BINARY, b"")
