"""The house keeps its order: imports run down its floors, in no circle, and no private name leaves its module.

Read from the sources alone (`ast`); nothing of the package is imported. Imports inside functions count as those at
the top do. Those under ``if TYPE_CHECKING`` are freer in one thing: they may close a circle, as nothing runs them, but
they too may not run up. The lists named ``KNOWN_...`` hold what is still wrong and who mends it; an entry that is no
longer needed fails the test, so that they can only shrink.
"""

from __future__ import annotations

import ast
import graphlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

# From the ground up. A module stands on the floor of its longest prefix here; it may import from the floors below and
# from its own.
FLOORS: list[list[str]] = [
    ["_typing", "_deprecation", "_log", "defaults", "errors"],
    [
        "array_likes",
        "atomic",
        "barycentric",
        "caching",
        "cholesky",
        "connectivity",
        "edge_collapse",
        "equal_rows",
        "fingerprint",
        "held_arrays",
        "html_repr",
        "jit",
        "memory",
        "mesh_connectivity",
        "missing_values",
        "nested_dissection",
        "parallel",
        "result_folder",
        "sampling",
        "triangle_geometry",
        "validation",
    ],
    ["io"],
    ["repair"],
    ["surface"],
    ["closest_points"],
    ["decimation"],
    ["hosts"],
    ["differential"],
    # geodesics: the metric and what unfolds; methods of distances; paths; what users call; all of it compiled
    ["geodesics.metric", "geodesics.distance_solver", "geodesics.flat_corners", "geodesics.unfolding"],
    ["geodesics.dijkstra", "geodesics.dgg", "geodesics.mmp"],
    ["geodesics.path"],
    ["geodesics"],
    ["spectral"],
    ["deformation"],
    # matching, in the order of a run
    ["matching.registration_stages", "matching.shape_parameters", "matching.reflection_parameters"],
    ["matching.parameters", "matching.match_log", "matching.hints"],
    ["matching.level", "matching.fine_shape", "matching.intrinsic_shape", "matching.matchable"],
    ["matching.prepared_shape"],
    ["matching.known_parts"],
    ["matching.problem"],
    ["matching.maps"],
    ["matching.initialization"],
    ["matching.schedule"],
    ["matching.smooth_shells"],
    ["matching.selection"],
    ["matching"],
    ["animation"],
    ["report.colors"],  # NumPy and matplotlib alone: filters paint as pictures do
    ["filters"],
    ["testing"],
    ["evaluation"],
    ["collection"],
    ["report"],
    ["compilation"],  # compiles the kernels of all floors below
    ["qgeo_filters"],  # the names that users see, each loaded when it is asked for
    ["cli"],
    ["__main__"],
    ["qgeo_widgets"],
]

# (importer, imported): who mends it
KNOWN_ARROWS_UP: dict[tuple[str, str], str] = {}
KNOWN_CIRCLES: dict[tuple[str, str], str] = {}
# file of tests or benchmarks, name: who mends it
KNOWN_LOANS: dict[tuple[str, str], str] = {}
# Names that begin with an underscore and are public all the same.
PUBLIC_UNDERSCORES = {
    "_replace",  # of every NamedTuple
    "_cache",  # of Numba's dispatchers: there is no other way to a cache of one's own
    "_asdict",
    "_trait_values",  # traitlets: the only way to let go of a trait's value without an event
}


class Arrow(NamedTuple):
    """One import: who takes what ('' for the whole module) from whom, and whether only type checkers follow it."""

    importer: str
    imported: str
    name: str
    typing_only: bool


def read_modules() -> dict[str, ast.Module]:
    """Syntax tree of each module of both packages, by its dotted name without the leading ``qgeo_filters``."""
    found = {}
    for folder in (ROOT / "qgeo_filters", ROOT / "widgets" / "qgeo_widgets"):
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name.removeprefix("qgeo_filters.")] = ast.parse(path.read_text(encoding="utf-8"), str(path))
    return found


MODULES = read_modules()


def import_statements(tree: ast.AST, typing_only: bool = False) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Imports anywhere in a tree, and whether they stand under ``if TYPE_CHECKING``."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node, typing_only
        elif isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            yield from import_statements(ast.Module(node.body, []), True)
            yield from import_statements(ast.Module(node.orelse, []), typing_only)
        else:
            yield from import_statements(node, typing_only)


def arrows(importer: str, tree: ast.Module) -> Iterator[Arrow]:
    """What a file takes from the two packages."""
    for node, typing_only in import_statements(tree):
        if isinstance(node, ast.Import):
            taken = [(alias.name, "") for alias in node.names]
        else:
            assert node.level == 0 or importer == "qgeo_filters", f"{importer}: imports are absolute, but in the root"
            taken = [(node.module or "", alias.name) for alias in node.names]
        for module, name in taken:
            if not getattr(node, "level", 0) and module.partition(".")[0] not in ("qgeo_filters", "qgeo_widgets"):
                continue  # Python has modules of equal names: io
            module = module.removeprefix("qgeo_filters.")
            inner = name if module == "qgeo_filters" else f"{module}.{name}"
            if inner in MODULES:
                yield Arrow(importer, inner, "", typing_only)
            elif module in MODULES and (module, name) != ("qgeo_filters", "__version__"):
                yield Arrow(importer, module, name, typing_only)


ARROWS = [arrow for name, tree in MODULES.items() for arrow in arrows(name, tree)]


def floor(module: str) -> int:
    """Number of the floor on which a module stands, from the ground up."""
    numbers = {name: number for number, names in enumerate(FLOORS) for name in names}
    prefix = module
    while prefix not in numbers:
        assert "." in prefix, f"{module} stands on no floor: give it one in FLOORS"
        prefix = prefix.rpartition(".")[0]
    return numbers[prefix]


def circles(graph: dict[str, set[str]]) -> set[tuple[str, ...]]:
    """A circle for each knot of modules that import one another; each is cut open before the next is sought."""
    found = set()
    while True:
        try:
            graphlib.TopologicalSorter(graph).prepare()
        except graphlib.CycleError as error:
            circle = error.args[1]  # each is imported by the next
            found.add(tuple(sorted(set(circle))))
            graph[circle[1]].discard(circle[0])
        else:
            return found


def private(name: str) -> bool:
    """Whether a name is meant for its own module."""
    return name.startswith("_") and not name.endswith("__") and name not in PUBLIC_UNDERSCORES


def own_names(tree: ast.Module) -> set[str]:
    """Every name that a module defines or assigns, on its own objects too."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and ast.unparse(node.value) == "self":
            names.add(node.attr)
    return names


def taken_off_others(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Private attributes that are read or set on anything but ``self`` and ``cls``, and their lines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and private(node.attr) and ast.unparse(node.value) not in ("self", "cls"):
            yield node.attr, node.lineno


def unsettled(found: set, known: dict) -> list[str]:
    """What is wrong and not known to be, and what is known and wrong no more."""
    fresh, done = sorted(found - set(known)), sorted(set(known) - found)
    return [f"new, and not allowed: {one}" for one in fresh] + [
        f"mended, take it out of the list: {one}" for one in done
    ]


def test_imports_run_down_the_floors() -> None:
    up = {(a.importer, a.imported) for a in ARROWS if floor(a.importer) < floor(a.imported)}
    assert not unsettled(up, KNOWN_ARROWS_UP)


def test_every_floor_is_lived_on() -> None:
    """A name in the list that no module has would guard nothing."""
    listed = [name for names in FLOORS for name in names]
    assert not [name for name in listed if not any(m == name or m.startswith(f"{name}.") for m in MODULES)]
    assert len(set(listed)) == len(listed)


def test_no_circle_of_modules() -> None:
    graph: dict[str, set[str]] = {name: set() for name in MODULES}
    for arrow in ARROWS:
        if not arrow.typing_only and (arrow.importer, arrow.imported) not in KNOWN_ARROWS_UP:
            graph[arrow.importer].add(arrow.imported)
    assert not unsettled(circles(graph), KNOWN_CIRCLES)


def test_no_private_name_is_imported() -> None:
    """Modules such as `_typing` are private to the package, not to a floor."""
    assert not [arrow for arrow in ARROWS if private(arrow.name)]


def test_private_attributes_stay_in_their_module() -> None:
    """``other._x`` is right where this module made `_x`; a base class of another module lends its own to ``self``."""
    for module, tree in MODULES.items():
        own = own_names(tree)
        assert not [f"{module}:{line}: {name}" for name, line in taken_off_others(tree) if name not in own]


def test_tests_and_benchmarks_need_no_private_name() -> None:
    """Neither imported, nor taken off a module, nor put in its place.

    A benchmark takes none off an object either. A test of a widget may: what a browser would do to it goes through
    its parts.
    """
    found = set()
    for folder in ("tests", "benchmarks"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            place, tree = path.relative_to(ROOT).as_posix(), ast.parse(path.read_text(encoding="utf-8"))
            lent = list(arrows(place, tree))
            aliases = {arrow.imported.rpartition(".")[2] for arrow in lent if not arrow.name}
            found |= {(place, arrow.name) for arrow in lent if private(arrow.name)}
            own = own_names(tree)
            for node in ast.walk(tree):
                if isinstance(node, ast.Attribute) and private(node.attr):
                    owner = ast.unparse(node.value)
                    if owner in aliases or (
                        folder == "benchmarks" and owner not in ("self", "cls") and node.attr not in own
                    ):
                        found.add((place, node.attr))
                elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("setattr"):
                    for name in node.args[:2]:  # an object and a name, or a dotted name
                        if isinstance(name, ast.Constant) and isinstance(name.value, str):
                            last = name.value.rpartition(".")[2]
                            found |= {(place, last)} if private(last) else set()
    assert not unsettled(found, KNOWN_LOANS)


def test_benchmarks_import_what_there_is() -> None:
    """They are run by hand and seldom, so that a rename would go unseen until then."""
    missing = []
    for path in sorted((ROOT / "benchmarks").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in (
                "qgeo_filters",
                "qgeo_widgets",
            ):
                module = importlib.import_module(node.module or "")
                for name in (alias.name for alias in node.names):
                    if not hasattr(module, name) and importlib.util.find_spec(f"{node.module}.{name}") is None:
                        missing.append(f"{path.name}: {node.module}.{name}")
    assert not missing
