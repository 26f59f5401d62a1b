"""Which meshes of the paper's data set (TOSCA "nonrigid world", about 3400 vertices) can be used as they are.

    python benchmarks/tosca_lowres_table.py FOLDER

prints the table of benchmarks/tosca_lowres.md: for each ``.vert`` / ``.tri`` pair of the folder, the verdict of
the package on the mesh as it is, and what a repair makes of it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.surface import Surface

FORCED = "forced: "


def verdict(surface: Surface) -> str:
    """What the geodesics and the spectrum say to the mesh as it is."""
    reasons = []
    if surface.nonmanifold_edges.size:
        reasons.append(f"{surface.nonmanifold_edges.size} edges of three or more faces")
    elif surface.nonmanifold_vertices.size:
        reasons.append(f"{surface.nonmanifold_vertices.size} vertices with more than one fan")
    if surface.components[0] > 1:
        reasons.append(f"{surface.components[0]} pieces")
    return "refused: " + ", ".join(reasons) if reasons else "runs"


def row(file: Path) -> tuple[str, ...]:
    """One line of the table."""
    try:
        surface = Surface.read(file)
    except MeshError as error:
        return file.stem, "", "", f"refused: {str(error).removeprefix(f'{file}: ')}", "", "", "", "refused"
    return file.stem, str(surface.n_vertices), str(surface.n_faces), verdict(surface), *repaired(surface)


def repaired(mesh: Surface) -> tuple[str, str, str, str]:
    """Sizes after repair, share of the area kept, and the report; which of them must be forced."""
    repair = repair_surface(mesh, force=True)
    surface = repair.surface
    surface.require_manifold("the table")
    surface.require_connected("the table")
    share = f"{100 * surface.area / mesh.area:.2f} %"
    forced = FORCED if surface.area < 0.99 * mesh.area else ""
    sentences = [re.sub(r"; the largest, kept,.*| \([\d, .]+\)$", "", sentence) for sentence in repair.report]
    return str(surface.n_vertices), str(surface.n_faces), share, forced + ("; ".join(sentences) or "nothing to do")


def table(folder: Path) -> str:
    """The table as Markdown."""

    def order(file: Path) -> tuple[str, int]:
        name, number = re.fullmatch(r"(\D+)(\d*)", file.stem).groups()  # type: ignore[union-attr]
        return name, int(number or 0)

    rows = [row(file) for file in sorted(folder.glob("*.vert"), key=order)]
    runs = sum(cells[3] == "runs" for cells in rows)
    repairable = sum(cells[7] != "refused" for cells in rows)
    forced = sum(cells[7].startswith(FORCED) for cells in rows)
    head = ("mesh", "vertices", "faces", "as it is", "vertices", "faces", "area kept", "with repair")
    lines = [
        "# The paper's meshes (TOSCA, low resolution)",
        "",
        "Made by `python benchmarks/tosca_lowres_table.py FOLDER`. The data are not part of this project.",
        "",
        f"Of {len(rows)} meshes {runs} run as they are; {repairable - forced} run with `repair=True`, and {forced} "
        'more with `repair="force"`, as more than a hundredth of their area goes.',
        "",
        "| " + " | ".join(head) + " |",
        "|---|--:|--:|---|--:|--:|--:|---|",
        *("| " + " | ".join(cells) + " |" for cells in rows),
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_dir():
        sys.exit("usage: python benchmarks/tosca_lowres_table.py FOLDER (with .vert and .tri files)")
    print(table(Path(sys.argv[1])), end="")
