"""The arrays of a page: one block of bytes, compressed once, in which a description names its parts."""

from __future__ import annotations

import base64
import gzip
from typing import Any

from qgeo_widgets.rendering.encoding import converted

_ALIGNMENT = 8


class PageBlock:
    """Arrays one behind the other; equal ones once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0
        self._places: dict[bytes, int] = {}

    def placed(self, item: Any) -> Any:
        """The same with ``{"bytes_at": ..., "length": ...}`` in place of arrays, which are added."""
        return converted(item, lambda array: self._add(array.tobytes()))

    def text(self) -> str:
        """The block as base64 of gzip."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), mtime=0)).decode()

    def _add(self, data: bytes) -> dict[str, int]:
        at = self._places.get(data)
        if at is None:
            at = self._places[data] = self._length
            padded = data + bytes(-len(data) % _ALIGNMENT)
            self._parts.append(padded)
            self._length += len(padded)
        return {"bytes_at": at, "length": len(data)}
