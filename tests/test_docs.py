"""The pages of docs/: each public name and each example is on one, links lead somewhere, Sphinx has no complaint."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import pickle
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from conftest import ROOT

import qgeo_filters as qg
import qgeo_widgets as qw

DOCS = ROOT / "docs"
EXAMPLES = sorted((DOCS / "examples").glob("plot_*.py"))
PAGES = sorted([*DOCS.glob("*.md"), *(DOCS / "api").glob("*.rst")])
REPOSITORY = "https://example.org/repository"


def module(name: str) -> ModuleType:
    """A file of docs/ that conf.py takes."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


text = module("repository_text")


def listed_names() -> list[str]:
    """Dotted names of all autosummary tables, in order."""
    names = []
    for page in sorted((DOCS / "api").glob("*.rst")):
        current = ""
        for line in page.read_text(encoding="utf-8").splitlines():
            if line.startswith(".. currentmodule:: "):
                current = line.split()[-1]
            elif re.fullmatch(r"   \w+", line) and current:
                names.append(f"{current}.{line.strip()}")
    return names


def test_every_public_name_is_in_the_reference_once() -> None:
    # Modules are shown by their own names, and the version is on every page.
    public = {f"qgeo_filters.{name}" for name in qg.__all__} - {
        "qgeo_filters.evaluation",
        "qgeo_filters.testing",
        "qgeo_filters.__version__",
    }
    public |= {f"qgeo_widgets.{name}" for name in qw.__all__}
    public |= {f"qgeo_filters.evaluation.{name}" for name in qg.evaluation.__all__}
    listed = listed_names()
    assert public <= set(listed)
    assert len(set(listed)) == len(listed)


def test_what_the_reference_lists_is_there() -> None:
    for name in listed_names():
        home, _, last = name.rpartition(".")
        assert hasattr(importlib.import_module(home), last), name


def test_every_page_is_in_a_table_of_contents() -> None:
    tables = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    for page in PAGES:
        if page.name not in ("index.md", "index.rst"):
            assert re.search(rf"^ *(.*<)?{page.stem}>?$", tables, re.MULTILINE), f"{page.name} is in no toctree"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_and_to_examples_lead_somewhere(page: Path) -> None:
    shown = text.with_repository_text(page.read_text(encoding="utf-8"), REPOSITORY)
    targets = re.findall(r"\]\(([^)\s#]+)", re.sub(r"^```.*?^```$", "", shown, flags=re.MULTILINE | re.DOTALL))
    targets += re.findall(r"^:link: (\S+)$", shown, re.MULTILINE)
    for target in targets:
        if target.startswith("gallery/plot_"):
            assert (DOCS / "examples" / Path(target).with_suffix(".py").name).is_file(), target
        elif target.startswith(REPOSITORY):
            file = target.removeprefix(REPOSITORY).split("/main/")[1]
            assert (ROOT / file).exists(), target
        elif not re.match(r"[a-z]+:", target) and not target.startswith(("gallery/", "api/")):
            assert (DOCS / target).exists(), target


def test_sections_of_the_repository_are_taken_in_whole() -> None:
    page = "before\n\n<!-- text of README.md: Installing -->\n\nafter\n"
    shown = text.with_repository_text(page, REPOSITORY)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    part = readme[readme.index("## Installing") : readme.index("## In a notebook")].rstrip()
    assert shown == f"before\n\n{part}\n\n\nafter\n"


def test_a_section_that_is_gone_is_an_error_with_those_that_are_there() -> None:
    with pytest.raises(ValueError, match=r"README.md has no heading 'Gone'; it has .*'Installing'"):
        text.with_repository_text("<!-- text of README.md: Gone -->", REPOSITORY)


def test_links_are_those_of_the_pages() -> None:
    given = "[a](../README.md#x) ![p](p.svg) [c](sets.py) [d](../notebooks) [e](https://e.org) [f](#g)\n"
    given += "```\n[h](sets.py)\n```\n"
    assert text.with_links(given, "benchmarks/README.md", REPOSITORY) == (
        f"[a](index.md#x) ![p](../benchmarks/p.svg) [c]({REPOSITORY}/blob/main/benchmarks/sets.py) "
        f"[d]({REPOSITORY}/tree/main/notebooks) [e](https://e.org) [f](#g)\n```\n[h](sets.py)\n```\n"
    )


def test_headings_within_fences_are_none() -> None:
    given = "# a\n```sh\n# comment\n```\nrest\n# b\n"
    assert text.section(given, "a", "x.md") == "# a\n```sh\n# comment\n```\nrest\n"


def test_the_house_is_drawn_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    picture = module("house_picture")
    floors, arrows = picture.floors_and_arrows()
    assert all(upper > lower for upper, lower in arrows)
    drawn = picture.house_picture(floors, arrows)
    assert drawn.count("<path ") == len(arrows)
    words = re.sub(r"</?text[^>]*>|\n", " ", drawn)
    assert not [name for names in floors for name in names if not re.search(rf"(^|\W){re.escape(name)}(\W|$)", words)]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_begin_with_a_title_and_take_no_helper_of_ours(path: Path) -> None:
    """A copy of the file alone runs: it imports what is installed, and reads no file of the repository."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    title, line, *_ = (ast.get_docstring(tree) or "").splitlines()
    assert line == "=" * len(title)
    assert "\n# %%\n" in source
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom | ast.Import):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
            assert all(importlib.util.find_spec(name.split(".")[0]) for name in names)
    assert "QGEO_DATA" not in source


@pytest.mark.slow
def test_an_example_that_takes_too_long_fails_the_build(tmp_path: Path) -> None:
    """A gallery of two examples with the settings of ours, and a bound that one of them is above."""
    pytest.importorskip("sphinx_gallery", reason="the extra docs is not installed")
    settings = (
        "import runpy, sys\n"
        f"ours = runpy.run_path({str(DOCS / 'conf.py')!r})['sphinx_gallery_conf']\n"
        "import gallery_seconds\n"
        "gallery_seconds.MOST_SECONDS = 2\n"
        "extensions = ['sphinx_gallery.gen_gallery']\n"
        "kept = {name: ours[name] for name in ('reset_modules', 'reset_modules_order', 'filename_pattern')}\n"
        "sphinx_gallery_conf = {'examples_dirs': 'examples', 'gallery_dirs': 'gallery', **kept}\n"
    )
    busy = "import time\nend = time.process_time() + 2.2\nwhile time.process_time() < end:\n    pass\n"
    files = {
        "conf.py": settings,
        "index.rst": "Title\n=====\n\n.. toctree::\n\n   gallery/index\n",
        "examples/GALLERY_HEADER.rst": "Gallery\n=======\n",
        "examples/plot_quick.py": '"""\nQuick\n=====\n\n"""\n1 + 1\n',
        "examples/plot_slow.py": '"""\nSlow\n====\n\n"""\n' + busy,
    }
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content, encoding="utf-8")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "dummy"]
    built = subprocess.run([*command, tmp_path, tmp_path / "_build"], capture_output=True, text=True)
    assert built.returncode == 1
    assert re.findall(r"WARNING: (\S+) takes \d+ processor seconds", built.stderr) == ["plot_slow.py"], built.stderr


def test_there_are_fifteen_examples_at_least() -> None:
    assert len(EXAMPLES) >= 15


def documented_members(cls: type) -> set[str]:
    """Public methods and properties of a class and its bases, but for what every filter has."""
    bases = [base for base in cls.__mro__ if base is cls or base not in qg.Filter.__mro__]
    return {
        f"qgeo_filters.{cls.__name__}.{name}"
        for base in bases
        for name, value in vars(base).items()
        if not name.startswith("_") and hasattr(value, "__get__") and inspect.getdoc(value)
    }


@pytest.mark.slow
def test_the_pages_are_built_without_a_warning(tmp_path: Path) -> None:
    """Everything is read and every link followed; no page is written, and no example run: ``make docs`` does both."""
    pytest.importorskip("sphinx_gallery", reason="the extra docs is not installed")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-D", "plot_gallery=0", "-b", "dummy"]
    built = subprocess.run([*command, DOCS, tmp_path], cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    read = {file.relative_to(tmp_path / ".doctrees").with_suffix("") for file in tmp_path.rglob("*.doctree")}
    assert {page.relative_to(DOCS).with_suffix("") for page in PAGES} <= read
    assert {Path("api") / "generated" / name for name in listed_names()} <= read
    for name in ("Collection", "Pipeline", "PreparedShape", "Surface"):  # most of what they do stands in their bases
        page = pickle.loads(
            (tmp_path / ".doctrees" / "api" / "generated" / f"qgeo_filters.{name}.doctree").read_bytes()
        )
        assert documented_members(getattr(qg, name)) <= set(page.ids)
