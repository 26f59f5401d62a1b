"""Numbers of a text and the lines that they stand on: what OFF, OBJ, STL and PLY have in common.

`numpy.loadtxt` wants equal columns, and `numpy.fromstring` tells what it cannot read by a warning only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import MeshError

_BLANKS = np.zeros(256, dtype=bool)
_BLANKS[list(b" \t\n\r\v\f")] = True
_BLANK = re.compile(rb"\s")
_PIECE = 1 << 22  # bytes split at once: a word takes ten times its length while it is apart
_MARKS = ((b"\xef\xbb\xbf", None), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers of a text up to the first word that is none.

    Attributes
    ----------
    values : (t,) float64
    starts : (k + 1,) int64
        First value of each line that has any, and t.
    lines : (k,) int64
        Which lines these are, from 1.
    stopped_by : str
        What is wrong with the word behind the last value; empty at the end of the text.
    """

    values: FloatArray
    starts: IndexArray
    lines: IndexArray
    stopped_by: str

    @property
    def counts(self) -> IndexArray:
        """Number of values of each line, shape (k,)."""
        return np.diff(self.starts)

    def require_all(self) -> None:
        """Raise `MeshError` where the text holds a word that is no number."""
        if self.stopped_by:
            raise MeshError(self.stopped_by)


def plain_text(content: bytes) -> bytes:
    """Text without byte-order mark, in an encoding that agrees with ASCII, each line ended by a line feed alone."""
    for mark, encoding in _MARKS:
        if content.startswith(mark):
            content = content[len(mark) :]
            if encoding:
                content = content.decode(encoding, errors="replace").encode()
    return content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def without_comments(text: bytes) -> bytes:
    """Text without what follows a ``#``; the lines keep their numbers."""
    return re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text


def numbers_of(text: bytes) -> Numbers:
    """Numbers of a text whose lines end with line feeds."""
    values, bad_word = _parsed(text)
    codes = np.frombuffer(text, dtype=np.uint8)
    blank = _BLANKS[codes]
    begins = ~blank
    begins[1:] &= blank[:-1]
    words = np.flatnonzero(begins)
    line_of_word = np.searchsorted(np.flatnonzero(codes == ord("\n")), words) + 1
    stopped_by = "" if bad_word is None else f"line {line_of_word[len(values)]}: {bad_word!r} is no number"
    lines = line_of_word[: len(values)]
    starts = np.flatnonzero(np.diff(lines, prepend=0))
    return Numbers(values, np.append(starts, len(values)), lines[starts], stopped_by)


def read_text(path: Path) -> bytes:
    """`plain_text` of a file."""
    return plain_text(path.read_bytes())


def whole(values: FloatArray) -> np.ndarray:
    """Which values are whole numbers that float64 tells apart."""
    return (values == np.floor(values)) & (np.abs(values) < 2**53)


def _parsed(text: bytes) -> tuple[FloatArray, str | None]:
    """Values up to the first word that is no number, and that word."""
    pieces = [np.empty(0)]
    position = 0
    while position < len(text):
        blank = _BLANK.search(text, position + _PIECE)
        piece = text[position : blank.start() if blank else len(text)]
        position += len(piece)
        words = piece.split()
        try:
            if b"_" in piece:  # Python's, no file's
                raise ValueError
            pieces.append(np.fromiter(map(float, words), np.float64, len(words)))
        except ValueError:
            good = next((k for k, word in enumerate(words) if not _is_number(word)), len(words))
            pieces.append(np.fromiter(map(float, words[:good]), np.float64, good))
            if good < len(words):
                return np.concatenate(pieces), words[good][:40].decode(errors="replace")
    return np.concatenate(pieces), None


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return b"_" not in word
