"""The house as it stands: its floors, what lives on them, and how many imports run from each to those below.

Read from `tests/test_house.py`, which reads the sources; drawn as SVG, whose text can be searched and selected.
"""

from __future__ import annotations

import importlib.util
from collections import Counter
from pathlib import Path
from types import ModuleType
from xml.sax.saxutils import escape

from qgeo_filters.atomic import atomic_write

ROOT = Path(__file__).resolve().parents[1]
WIDTH, LABEL, LINE, GAP = 980, 600, 19, 6  # pixels
LETTERS = 88  # of a line of names
INK, PALE, ARROW = "#1f2d3d", "#eef2f7", "#3b6ea5"


def house() -> ModuleType:
    """The module that knows the floors and all imports."""
    spec = importlib.util.spec_from_file_location("house_of_qgeo", ROOT / "tests" / "test_house.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def floors_and_arrows() -> tuple[list[list[str]], Counter[tuple[int, int]]]:
    """Names of each floor from the ground up, and the number of imports from one floor to another."""
    known = house()
    arrows = Counter((known.floor(arrow.importer), known.floor(arrow.imported)) for arrow in known.ARROWS)
    return known.FLOORS, Counter({pair: count for pair, count in arrows.items() if pair[0] != pair[1]})


def house_picture(floors: list[list[str]], arrows: Counter[tuple[int, int]]) -> str:
    """SVG of the floors, the top one first, with an arc for each pair of floors of which one imports the other."""
    lines = [_lines(", ".join(names)) for names in floors]
    heights = [LINE * len(text) + 10 for text in lines]
    tops, y = {}, 10
    for number in reversed(range(len(floors))):
        tops[number] = y
        y += heights[number] + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + 10}" font-family="sans-serif"',
        ' font-size="13">',
        "<title>Floors of the package and the imports between them</title>",
        f'<rect width="{WIDTH}" height="{y + 10}" fill="white"/>',
    ]
    middle = {number: tops[number] + heights[number] / 2 for number in tops}
    for (upper, lower), count in sorted(arrows.items()):
        reach = 24 + 440 * (middle[lower] - middle[upper]) / y
        parts.append(
            f'<path d="M {LABEL + 10} {middle[upper]:.0f} C {LABEL + reach:.0f} {middle[upper]:.0f}, '
            f'{LABEL + reach:.0f} {middle[lower]:.0f}, {LABEL + 10} {middle[lower]:.0f}" fill="none" '
            f'stroke="{ARROW}" stroke-opacity=".35" stroke-width="{0.5 + 0.45 * count**0.5:.2f}">'
            f"<title>{escape(', '.join(floors[upper][:3]))} takes from {escape(', '.join(floors[lower][:3]))}: "
            f"{count} imports</title></path>"
        )
    for number, text in enumerate(lines):
        parts.append(
            f'<rect x="10" y="{tops[number]}" width="{LABEL}" height="{heights[number]}" rx="4" fill="{PALE}"/>'
        )
        for row, line in enumerate(text):
            baseline = tops[number] + LINE * (row + 1)
            parts.append(f'<text x="20" y="{baseline}" fill="{INK}">{escape(line)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def write_house_picture(path: Path) -> None:
    """Draw it into a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as file:
        file.write(house_picture(*floors_and_arrows()).encode())


def _lines(text: str) -> list[str]:
    """Names broken into lines."""
    lines = [""]
    for word in text.split(" "):
        if len(lines[-1]) + len(word) > LETTERS:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
