"""Installs the lowest versions that pyproject.toml admits, in an environment of their own, and runs some tests on them.

    python .ci/oldest.py [--environment DIR] [--only-constraints] [TESTS ...]

`name>=version` becomes `name==version`, of the package's own dependencies and of the extras below; what these need in
turn is whatever fits. The tests are those that touch each dependency, in about five minutes; others may be named.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Extras whose lowest versions are installed too: hosts of a few hundred MB are left to the newest versions' tests.
EXTRAS = ("meshlab", "pyvista", "files", "zarr")
#: What the tests themselves need, at any version.
TOOLS = ("pytest>=8", "pytest-cov", "pytest-randomly", "hypothesis", "jsonschema", "pygeodesic", "potpourri3d")
#: Tests that touch each dependency.
SMOKE = (
    "tests/geodesics/test_exact.py",
    "tests/geodesics/test_matrix.py",
    "tests/spectral/test_spectrum.py",
    "tests/differential/test_curvature.py",
    "tests/io/test_ply.py",
    "tests/io/test_gltf.py",
    "tests/io/test_grids.py",
    "tests/io/test_written_for_others.py",
    "tests/hosts/test_meshlab.py",
    "tests/hosts/test_pyvista.py",
    "tests/filters/test_pipeline.py",
    "tests/matching/test_match_result.py",
    "tests/test_caching.py",
    "tests/test_parallel.py",
    "tests/test_report.py",
    "tests/cli/test_commands.py",
    "tests/cli/test_stage_display.py",
)


def lowest(requirement: str) -> str | None:
    """The lowest version that a requirement admits, as a constraint; None for one that names none, or this package."""
    found = re.match(r"\s*([A-Za-z0-9][\w.-]*)\s*(?:\[[^\]]*\])?\s*(>=|==)\s*([\w.]+)", requirement)
    return f"{found[1]}=={found[3]}" if found else None


def constraints(project: dict[str, object]) -> list[str]:
    """Lowest versions of what the package needs, and of its extras."""
    extras = project["optional-dependencies"]
    assert isinstance(extras, dict)
    needed = [*project["dependencies"], *(one for extra in EXTRAS for one in extras[extra])]  # type: ignore[misc]
    return sorted({one for requirement in needed if (one := lowest(requirement))}, key=str.lower)


def main() -> None:
    """Install and test."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--environment", type=Path, help="folder of the environment; one that goes away by default")
    parser.add_argument("--only-constraints", action="store_true", help="print them, and do nothing else")
    parser.add_argument("tests", nargs="*", default=list(SMOKE))
    chosen = parser.parse_args()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    text = "".join(f"{line}\n" for line in constraints(project))
    if chosen.only_constraints:
        sys.stdout.write(text)
        return
    with tempfile.TemporaryDirectory() as temporary:
        folder = chosen.environment or Path(temporary, "oldest")
        file = Path(temporary, "constraints.txt")
        file.write_text(text, encoding="utf-8")
        venv.EnvBuilder(with_pip=True, clear=True).create(folder)
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        package = f"{ROOT}[{','.join(EXTRAS)}]"
        run(python, "-m", "pip", "install", "-q", "-c", file, package, *TOOLS)
        run(python, "-m", "pip", "check")
        # What is installed is tested, not the sources beside the tests.
        run(python, "-P", "-m", "pytest", "-q", "-p", "no:cacheprovider", *chosen.tests)


def run(*command: str | Path) -> None:
    """A command that must succeed."""
    print("$", *command, flush=True)
    subprocess.run([str(part) for part in command], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
