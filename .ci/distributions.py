"""Builds the wheel and the source distribution, checks what they hold, and uses the wheel in bare environments.

    python .ci/distributions.py [--only-build] [--output dist]

What is built is the last commit, whatever lies about in the folder. Links and pictures of the README, which an index
shows elsewhere, become absolute addresses of the tag of this version.
"""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ADDRESS = "https://github.com/qgeo-filters/qgeo-filters"
PICTURES = "https://raw.githubusercontent.com/qgeo-filters/qgeo-filters"
#: Files that the wheel must hold.
IN_WHEEL = [
    "qgeo_filters/py.typed",
    "qgeo_filters/__main__.py",
    "qgeo_filters/cli/result.schema.json",
    "qgeo_widgets/py.typed",
    "qgeo_widgets/page/page.html",
    "qgeo_widgets/static/renderer.js",
    "qgeo_widgets/static/three.LICENSE",
]
#: Beginnings of names that it must not.
NOT_IN_WHEEL = ("tests", "benchmarks", "notebooks", "docs", ".ci")
#: Files that the source distribution must hold.
IN_SOURCE = ["LICENSE", "README.md", "CHANGELOG.md", "pyproject.toml", "qgeo_filters/__init__.py", "tests/conftest.py"]

_EVERY_NAME = "import {0} as package; [getattr(package, name) for name in package.__all__]"


def run(*command: str | Path, cwd: Path = ROOT) -> str:
    """Standard output of a command that must succeed."""
    print("$", *command, flush=True)
    words = [str(part) for part in command]
    return subprocess.run(words, cwd=cwd, check=True, stdout=subprocess.PIPE, text=True).stdout


def readme_for_index(text: str, version: str) -> str:
    """The README with the addresses of what its relative links lead to."""

    def absolute(match: re.Match[str]) -> str:
        before, target = match.groups()
        base = f"{PICTURES}/v{version}" if target.endswith((".png", ".svg", ".gif")) else f"{ADDRESS}/blob/v{version}"
        return f"{before}{base}/{target}"

    return re.sub(r"""(\]\(|src="|href=")(?![a-z]+:|#)([^)"\s]+)""", absolute, text)


def built(output: Path) -> tuple[Path, Path]:
    """The wheel and the source distribution of the last commit."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(tree, filter="data")
        (version,) = re.findall(r'__version__ = "(.+)"', (tree / "qgeo_filters" / "__init__.py").read_text("utf-8"))
        readme = tree / "README.md"
        readme.write_text(readme_for_index(readme.read_text("utf-8"), version), "utf-8")
        run(sys.executable, "-m", "build", "--outdir", output, cwd=tree)
    (wheel,) = output.glob(f"*-{version}-*.whl")
    (source,) = output.glob(f"*-{version}.tar.gz")
    return wheel, source


def check_contents(wheel: Path, source: Path) -> None:
    """Raise where something is missing, or too much."""
    within = zipfile.ZipFile(wheel).namelist()
    with tarfile.open(source) as files:
        in_source = {name.partition("/")[2] for name in files.getnames()}
    missing = [name for name in IN_WHEEL if name not in within] + [name for name in IN_SOURCE if name not in in_source]
    extra = [name for name in within if name.startswith(NOT_IN_WHEEL)]
    modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / "qgeo_filters").rglob("*.py")}
    missing += sorted(modules - set(within))
    if missing or extra:
        raise SystemExit(f"missing: {missing}; not to be there: {extra}")
    run(sys.executable, "-m", "twine", "check", "--strict", wheel, source)


def bare(folder: Path, requirement: str) -> Path:
    """Folder of the commands of a new environment that holds this only."""
    venv.create(folder, with_pip=True)
    commands = folder / ("Scripts" if sys.platform == "win32" else "bin")
    run(commands / "python", "-m", "pip", "install", "-q", "--disable-pip-version-check", requirement)
    run(commands / "python", "-m", "pip", "check")
    return commands


def use(wheel: Path) -> None:
    """The wheel in an environment of its own, from another folder: alone, then with all extras the main job."""
    with tempfile.TemporaryDirectory() as folder:
        elsewhere = Path(folder) / "elsewhere"
        elsewhere.mkdir()
        alone = bare(Path(folder) / "alone", str(wheel))
        print(run(alone / "qgeo", "info", "--system", cwd=elsewhere))
        run(alone / "python", "-c", _EVERY_NAME.format("qgeo_filters"), cwd=elsewhere)
        complete = bare(Path(folder) / "complete", f"{wheel}[all]")
        run(complete / "qgeo", "demo", cwd=elsewhere)
        run(complete / "python", "-c", _EVERY_NAME.format("qgeo_widgets"), cwd=elsewhere)
        if not (elsewhere / "qgeo-out" / "demo" / "report.html").is_file():
            raise SystemExit("qgeo demo wrote no report")


def main() -> None:
    """Build, check, and use."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    parser.add_argument("--only-build", action="store_true", help="do not install")
    arguments = parser.parse_args()
    wheel, source = built(arguments.output.resolve())
    check_contents(wheel, source)
    if not arguments.only_build:
        use(wheel)
    print(f"{wheel}\n{source}")


if __name__ == "__main__":
    main()
