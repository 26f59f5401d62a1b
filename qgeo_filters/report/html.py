"""A report in one file: pictures, numbers and parameters as a web page that loads nothing from anywhere."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from itertools import zip_longest
from os import PathLike
from pathlib import Path
from typing import Any
from urllib.parse import quote

from matplotlib.figure import Figure

from qgeo_filters.atomic import atomic_write
from qgeo_filters.report.glossary import meaning
from qgeo_filters.report.panels import DPI
from qgeo_filters.report.style import STYLESHEET

_WIDE = 5.5  # inches
_HALF_PAGE = 90  # characters in half the width of the page
_GAP = 3  # characters between columns
_SENTENCE = 40  # characters from which a cell is read, not looked at


@dataclass(frozen=True)
class Picture:
    """A figure of the report.

    Attributes
    ----------
    name : str
        Name of its file, without suffix.
    figure : Figure
    caption : str
        What is seen, in a sentence.
    """

    name: str
    figure: Figure
    caption: str

    @cached_property
    def png(self) -> bytes:
        """The figure as a PNG file."""
        buffer = io.BytesIO()
        # Without a time stamp and a version: the same figure gives the same bytes.
        self.figure.savefig(buffer, format="png", metadata={"Software": None})
        return buffer.getvalue()

    @property
    def wide(self) -> bool:
        """Whether it takes the whole width of the page."""
        return bool(self.figure.get_figwidth() > _WIDE)


@dataclass(frozen=True)
class StoredPicture:
    """A picture of the report that was written before.

    Attributes
    ----------
    path : Path
        Of a PNG file at the resolution of this package's figures.
    caption : str
    """

    path: Path
    caption: str

    @property
    def png(self) -> bytes:
        """The file."""
        return self.path.read_bytes()

    @property
    def wide(self) -> bool:
        """Whether it takes the whole width of the page."""
        return int.from_bytes(self.png[16:20], "big") > _WIDE * DPI  # the width in a PNG file's first chunk


@dataclass(frozen=True)
class Link:
    """A cell of a table that leads to another page.

    Attributes
    ----------
    text : str
    file : str
        Name of the page, beside this one.
    """

    text: str
    file: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Meaning:
    """A cell that says what the number beside it means.

    Attributes
    ----------
    text : str
    """

    text: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Table:
    """Rows of numbers or words under a heading.

    Attributes
    ----------
    title : str
    rows : sequence of sequences
    columns : sequence of str
        Headings; none by default.
    note : str
        A sentence under the table.
    """

    title: str
    rows: Sequence[Sequence[Any]]
    columns: Sequence[str] = ()
    note: str = ""

    @classmethod
    def of(cls, title: str, values: Mapping[str, Any], note: str = "") -> Table:
        """Table of two columns, name and value."""
        return cls(title, list(values.items()), note=note)

    @classmethod
    def explained(cls, title: str, values: Mapping[str, Any], command: str = "", note: str = "") -> Table:
        """Table of three columns: name, value and what the value means, as `glossary.meaning` has it."""
        rows = [(name, value, Meaning(meaning(name, command))) for name, value in values.items()]
        return cls(title, rows if any(row[2].text for row in rows) else [row[:2] for row in rows], note=note)


def formatted(value: Any) -> str:
    """A value as a reader wants it: six digits, words for truth, lists cut short."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}".replace("-", "−")
    if isinstance(value, Mapping):
        return ", ".join(f"{name} = {formatted(item)}" for name, item in value.items()) or "–"
    if isinstance(value, (list, tuple)):
        separator = "; " if any(isinstance(item, (list, tuple)) for item in value) else ", "
        shown = separator.join(formatted(item) for item in value[:12])
        return (f"{shown}, … ({len(value)})" if len(value) > 12 else shown) or "–"
    return str(value)


def report_page(
    title: str,
    *,
    subtitle: str = "",
    pictures: Sequence[Picture | StoredPicture] = (),
    tables: Sequence[Table] = (),
    footer: str = "",
    tables_first: bool = False,
) -> str:
    """Text of a self-contained web page; pictures are base64 PNG, nothing is loaded from elsewhere.

    Parameters
    ----------
    title, subtitle : str
    pictures : sequence of Picture or StoredPicture
    tables : sequence of Table
    footer : str
    tables_first : bool
        Whether the numbers come before the pictures.
    """
    sections = [
        f"""<section class="pictures" aria-label="Pictures">
{_figures(pictures)}</section>
""",
        f"""<section class="tables" aria-label="Numbers">
{"".join(map(_table, tables))}</section>
""",
    ]
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(title)}</title>
<style>{STYLESHEET}</style>
</head>
<body>
<header><h1>{escape(title)}</h1>{_paragraph(subtitle)}</header>
<main>
{"".join(reversed(sections) if tables_first else sections)}</main>
<footer>{_paragraph(footer)}</footer>
</body>
</html>
"""


def write_report(path: str | PathLike[str], title: str, **content: Any) -> None:
    """Write `report_page` to a file, whole or not at all."""
    with atomic_write(path) as file:
        # Bytes of a file name that are no text come as lone surrogates.
        file.write(report_page(title, **content).encode("utf-8", errors="backslashreplace"))


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>" if text else ""


def _figures(pictures: Sequence[Picture | StoredPicture]) -> str:
    """All figures: narrow ones stand two in a row, and of an odd number the last has its row to itself."""
    narrow = [place for place, picture in enumerate(pictures) if not picture.wide]
    alone = narrow[-1] if len(narrow) % 2 and len(pictures) > 1 else None
    kinds = ["wide" if picture.wide else "alone" if i == alone else "" for i, picture in enumerate(pictures)]
    return "".join(map(_figure, pictures, kinds))


def _figure(picture: Picture | StoredPicture, kind: str) -> str:
    data = base64.b64encode(picture.png).decode("ascii")
    caption = escape(picture.caption)
    named = f' class="{kind}"' if kind else ""
    image = f'<img src="data:image/png;base64,{data}" alt="{caption}">'
    return f"<figure{named}>{image}<figcaption>{caption}</figcaption></figure>\n"


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in table.columns)
    head = f"<thead><tr>{head}</tr></thead>" if head else ""
    body = "".join(_row(row) for row in table.rows)
    content = f'<div class="scroll"><table>{head}<tbody>{body}</tbody></table></div>'
    lines = [[formatted(value) for value in row] for row in (*table.rows, table.columns)]
    explained = " explained" if any(isinstance(row[-1], Meaning) for row in table.rows) else ""
    longest = [max(map(len, column)) for column in zip_longest(*lines, fillvalue="")]
    wide = " wide" if sum(longest) + _GAP * len(longest) > _HALF_PAGE else ""
    kind = f"table{wide}{explained}"
    return f'<div class="{kind}"><h2>{escape(table.title)}</h2>{content}{_paragraph(table.note)}</div>\n'


def _row(row: Sequence[Any]) -> str:
    first, *others = row
    cells = "".join(f"<td{_kind(value)}>{_cell(value)}</td>" for value in others)
    return f'<tr><th scope="row">{_cell(first)}</th>{cells}</tr>'


def _kind(value: Any) -> str:
    """The class of a cell, as an attribute."""
    if isinstance(value, Meaning):
        return ' class="meaning"'
    if isinstance(value, str) and len(value) > _SENTENCE:
        return ' class="sentence"'
    return ' class="number"' if isinstance(value, (int, float)) and not isinstance(value, bool) else ""


def _cell(value: Any) -> str:
    text = escape(formatted(value))
    return f'<a href="{escape(quote(value.file))}">{text}</a>' if isinstance(value, Link) else text
