"""Tables of a benchmark: printed as Markdown while they grow, and kept as JSON where `--json FILE` asks for it.

    with recorded() as record:
        table = record.table("closed, 3400 vertices", "method", "CPU s")
        table.row("graph", "0.1")

`results/` has the files that were kept, and `readme_tables.py` writes the tables of README.md from them.
"""

from __future__ import annotations

import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")
_STRING = r'"(?:[^"\\]|\\.)*"'


class Table:
    """Rows under one title; cells are text, as they are shown."""

    def __init__(self, title: str, columns: Sequence[str], align: str = "") -> None:
        self.title, self.columns, self.align = title, list(columns), align or "l" * len(columns)
        self.rows: list[list[str]] = []

    def row(self, *cells: object) -> None:
        """Add a row, and print it."""
        if len(cells) != len(self.columns):
            raise ValueError(f"{len(cells)} cells for {len(self.columns)} columns: {cells}")
        self.rows.append([str(cell) for cell in cells])
        print(line(self.rows[-1]), flush=True)

    def head(self) -> str:
        """Names of the columns, and the rule below them."""
        return f"{line(self.columns)}\n|{'|'.join({'l': '---', 'r': '---:'}[side] for side in self.align)}|"

    def markdown(self) -> str:
        """The whole table."""
        return "\n".join([self.head(), *map(line, self.rows)])


class Record:
    """What one run found.

    Attributes
    ----------
    arguments : list of str
        The command line's, without ``--json FILE``.
    tables : list of Table
    notes : list of str
        Sentences beside the tables.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        self.arguments = list(arguments)
        self.file: Path | None = None
        if "--json" in self.arguments:
            place = self.arguments.index("--json")
            if place + 1 == len(self.arguments):
                sys.exit("--json needs a file")
            self.file = Path(self.arguments[place + 1])
            del self.arguments[place : place + 2]
        self.tables: list[Table] = []
        self.notes: list[str] = []
        self._load = load()

    def table(self, title: str, *columns: str, align: str = "") -> Table:
        """A new table; its head is printed, below its title if it has one."""
        self.tables.append(Table(title, columns, align))
        print(f"\n**{title}**\n" if title else "")
        print(self.tables[-1].head(), flush=True)
        return self.tables[-1]

    def markdown(self, title: str, text: str) -> Table:
        """A table that another made, printed too."""
        columns, rule, *rows = ([cell.strip() for cell in row.strip()[1:-1].split("|")] for row in text.splitlines())
        table = self.table(title, *columns, align="".join("r" if cell.endswith(":") else "l" for cell in rule))
        for cells in rows:
            table.row(*cells)
        return table

    def note(self, sentence: str) -> None:
        """Print a sentence, and keep it."""
        self.notes.append(sentence)
        print(f"\n{sentence}", flush=True)

    def content(self) -> dict[str, Any]:
        """What the file holds."""
        threads = [f"{name}={os.environ[name]}" for name in _THREADS if name in os.environ]
        return {
            # Files and folders by their last names: where they lie here says nothing to others.
            "command": " ".join(
                [*threads, "python", f"benchmarks/{Path(sys.argv[0]).name}", *map(_name, self.arguments)]
            ),
            "evaluation_data": "QGEO_DATA" in os.environ,
            "machine": machine(),
            "load": [self._load, load()],
            "commit": commit(),
            "date": date.today().isoformat(),
            "tables": [vars(table) for table in self.tables],
            "notes": self.notes,
        }


@contextmanager
def recorded(arguments: Sequence[str] | None = None) -> Iterator[Record]:
    """Context of a run, whose record is written at its end, if it comes to it."""
    record = Record(sys.argv[1:] if arguments is None else arguments)
    yield record
    if record.file:
        record.file.write_text(as_json(record.content()), encoding="utf-8")


def as_json(content: dict[str, Any]) -> str:
    """The content as JSON, each row of a table on a line."""
    text = json.dumps(content, indent=1, ensure_ascii=False)
    row = rf"\[\s*({_STRING}(?:,\s*{_STRING})*)\s*\]"
    return re.sub(row, lambda found: f"[{', '.join(re.findall(_STRING, found[1]))}]", text) + "\n"


def machine() -> str:
    """CPU model, number of cores, and the versions that matter most."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = info.read_text().splitlines()
        model = next((x.split(":")[1].strip() for x in lines if x.startswith("model name")), model)
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}"


def load() -> float | None:
    """Processes that wanted to run in the last minute, on average, this one among them; None where nobody counts."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


def commit() -> str:
    """The last commit that changed the package, and a plus where files of it differ."""

    def git(*command: str) -> str:
        found = subprocess.run(["git", *command], cwd=ROOT, capture_output=True, text=True, check=False)
        return found.stdout.strip()

    package = ("--", "qgeo_filters", "widgets")
    return git("log", "-1", "--format=%h", *package) + ("+" if git("status", "--short", *package) else "")


def line(cells: Sequence[str]) -> str:
    """One row of a Markdown table."""
    return f"| {' | '.join(cells)} |"


def _name(argument: str) -> str:
    return Path(argument).name if "/" in argument or "\\" in argument else argument
