"""Words of landmark files: lines, positions, and what stands for a landmark that is missing."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from qgeo_filters.errors import MeshError
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.io.text_numbers import plain_text

Point = tuple[float, float, float]
MISSING: Point = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class LandmarkSet:
    """One of the sets of landmarks of a file.

    Attributes
    ----------
    called : tuple of str
        What the file calls it; nothing where it holds one set only.
    landmarks : Landmarks
    """

    called: tuple[str, ...]
    landmarks: Landmarks


def text_of(content: bytes) -> str:
    """Text in UTF-8, or else in Windows' western European encoding; lines end with line feeds."""
    plain = plain_text(content)
    try:
        return plain.decode("utf-8")
    except UnicodeDecodeError:
        return plain.decode("cp1252", errors="replace")


def without_head(text: str) -> str:
    """The text with the comments at its beginning empty; further on a ``#`` may be that of a name."""
    return re.sub(r"\A(?:[^\S\n]*(?:#[^\n]*)?(?:\n|\Z))+", lambda head: "\n" * head[0].count("\n"), text)


def number(word: object, place: str) -> float:
    """A finite number, or NaN for what stands for a missing one (NA, NaN, nothing); `MeshError` for all else."""
    if isinstance(word, str):
        text = word.strip()
        if text.lower() in ("", "na", "nan"):
            return math.nan
        if not text.isascii() or "_" in text:
            raise MeshError(f"{place}: {text[:40]!r} is no number")
        word = text
    try:
        if isinstance(word, bool):
            raise TypeError
        value = float(word)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise MeshError(f"{place}: {str(word)[:40]!r} is no number") from None
    if math.isinf(value):
        raise MeshError(f"{place}: {str(word)[:40]!r} is beyond all numbers")
    return value


def position(words: Sequence[object], place: str) -> Point:
    """Position of three words, NaN where all are missing."""
    if len(words) != 3:
        raise MeshError(f"{place}: a position needs 3 coordinates, got {len(words)}")
    x, y, z = (number(word, place) for word in words)
    missing = sum(map(math.isnan, (x, y, z)))
    if missing not in (0, 3):
        raise MeshError(f"{place}: {missing} of 3 coordinates are missing")
    return x, y, z


def whole_number(word: str, place: str) -> int:
    """A whole number; -1 for what stands for a missing one."""
    value = number(word, place)
    if math.isnan(value):
        return -1
    if value != math.floor(value) or abs(value) > 2**53:
        raise MeshError(f"{place}: {word[:40]!r} is no whole number")
    return int(value)


def words_of(point: Sequence[float], missing: str) -> list[str]:
    """Coordinates with the digits that give back every bit, or three times the word for a missing one."""
    return [missing if math.isnan(value) else repr(float(value)) for value in point]
