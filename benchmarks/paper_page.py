"""One page of what the paper prints beside what is measured: Markdown, and HTML that holds its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from paper_study import Claim, Part
from record import Record

from qgeo_filters.atomic import atomic_write
from qgeo_filters.report.html import StoredPicture, Table, formatted, write_report

TITLE = "The paper's tables and figures"
SOURCE = "S. Das, S. M. Bhandarkar, Principal Curvature Guided Surface Geometry Aware Global Shape Representation, 2018"


def write_page(out: Path, parts: Sequence[Part], setting: str) -> None:
    """Write ``paper.md``, which shows the pictures of ``figures/``, and ``paper.html``, which needs no other file."""
    claims = claim_table([claim for part in parts for claim in part.claims])
    lines = [f"# {TITLE}", f"{SOURCE}. {setting}", markdown(claims)]
    for part in parts:
        lines += [f"## {part.title}", *map(markdown, part.tables)]
        lines += [f"![{caption}](figures/{name}.png)\n\n{caption}" for name, caption in part.pictures]
    with atomic_write(out / "paper.md") as file:
        file.write(("\n\n".join(lines) + "\n").encode())
    pictures = [
        StoredPicture(out / "figures" / f"{name}.png", caption) for part in parts for name, caption in part.pictures
    ]
    tables = [claims, *(table for part in parts for table in part.tables)]
    write_report(
        out / "paper.html", TITLE, subtitle=f"{SOURCE}. {setting}", pictures=pictures, tables=tables, tables_first=True
    )


def recorded_tables(record: Record, parts: Sequence[Part]) -> None:
    """Put the claims and all tables of the parts into a record; bars within cells become slashes."""
    claims = claim_table([claim for part in parts for claim in part.claims])
    for table in (claims, *(table for part in parts for table in part.tables)):
        kept = record.table(table.title, *(str(column).replace("|", "/") for column in table.columns))
        for row in table.rows:
            kept.row(*(formatted(value).replace("|", "/") for value in row))


def claim_table(claims: Sequence[Claim]) -> Table:
    """The claims as a table."""
    rows = [(claim.text, claim.printed, claim.measured, claim.verdict) for claim in claims]
    return Table("Which claims hold on this data", rows, ["claim", "printed", "measured", "on this data"])


def markdown(table: Table) -> str:
    """The table in Markdown, its title in bold above and its note below."""
    columns = [str(column).replace("|", r"\|") for column in table.columns]
    lines = [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(formatted(value).replace('|', '/') for value in row)} |" for row in table.rows]
    return f"**{table.title}**\n\n" + "\n".join(lines) + (f"\n\n{table.note}" if table.note else "")
