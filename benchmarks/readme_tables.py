"""Writes the tables of the READMEs from the files in results/, so that no figure of theirs goes through a hand.

    python benchmarks/readme_tables.py

Between `<!-- results NAME -->` and `<!-- end of results -->` stand the tables of results/NAME.json, or those whose
whole title the pattern in `<!-- results NAME: PATTERN -->` matches; `<!-- results NAME: PATTERN; mean | worst pair -->`
leaves all columns out but the first and those that are named. Several have their titles; the run stands below, and
where there is no pattern the sentences of the script.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from record import ROOT, Table

RESULTS = Path(__file__).with_name("results")
FILES = (ROOT / "README.md", ROOT / "benchmarks" / "README.md")
_BLOCK = re.compile(
    r"^<!-- results (?P<name>\w+)(?:: (?P<pattern>.+?)(?:; (?P<columns>.+?))?)? -->$.*?^<!-- end of results -->$",
    re.MULTILINE | re.DOTALL,
)


def with_tables(text: str, folder: str) -> str:
    """The text with each block as the file has it.

    Parameters
    ----------
    text : str
    folder : str
        Where `results` lies, as seen from the text.

    Raises
    ------
    ValueError
        A pattern that no title matches, or a column that a table does not have.
    """

    def block(found: re.Match[str]) -> str:
        content = json.loads((RESULTS / f"{found['name']}.json").read_text(encoding="utf-8"))
        tables = [one for one in content["tables"] if re.fullmatch(found["pattern"] or ".*", one["title"])]
        if not tables:
            raise ValueError(f"results/{found['name']}.json has no table {found['pattern']!r}")
        parts = [found[0].partition("\n")[0]]
        for one in tables:
            parts += [f"**{one['title']}**"] if len(tables) > 1 else []
            parts.append(_table(one, found["columns"]).markdown())
        parts += content["notes"] if not found["pattern"] else []
        link = f"[{found['name']}.json]({folder}results/{found['name']}.json)"
        return "\n\n".join([*parts, f"<sub>{link}: {run(content)}</sub>", "<!-- end of results -->"])

    return _BLOCK.sub(block, text)


def names(text: str) -> set[str]:
    """Files that a text shows tables of."""
    return {found["name"] for found in _BLOCK.finditer(text)}


def run(content: dict[str, Any]) -> str:
    """When and on what a run was made."""
    first, last = content["load"]
    busy = "" if first is None else f"; load {min(first, last):g} to {max(first, last):g}"
    data = " with QGEO_DATA" if content["evaluation_data"] else ""
    return f"`{content['command']}`{data}, {content['date']}, commit {content['commit']}, {content['machine']}{busy}"


def _table(content: dict[str, Any], wanted: str | None) -> Table:
    """The table as it was kept, or its first column and those that are wanted, in their order."""
    columns = content["columns"]
    places = list(range(len(columns)))
    if wanted:
        if missing := [name for name in wanted.split(" | ") if name not in columns]:
            raise ValueError(f"table {content['title']!r} has no column {missing[0]!r}; it has {columns}")
        places = [0, *map(columns.index, wanted.split(" | "))]
    table = Table(content["title"], [columns[i] for i in places], "".join(content["align"][i] for i in places))
    table.rows = [[row[i] for i in places] for row in content["rows"]]
    return table


def main() -> None:
    """Write them."""
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        new = with_tables(text, "benchmarks/" if file.parent == ROOT else "")
        if new != text:
            file.write_text(new, encoding="utf-8")
            print(f"{file.relative_to(ROOT)}: written")


if __name__ == "__main__":
    main()
