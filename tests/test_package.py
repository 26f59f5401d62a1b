"""The package from outside: what importing it costs and needs, and that every public name is there."""

from __future__ import annotations

import ast
import importlib
import json
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from conftest import ROOT

import qgeo_filters as qg


def run(code: str) -> str:
    """Standard output of a fresh interpreter."""
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout


def test_import_loads_no_heavy_package() -> None:
    loaded = json.loads(run("import qgeo_filters, sys, json; print(json.dumps(sorted(sys.modules)))"))
    heavy = {
        "numba",
        "open3d",
        "pymeshlab",
        "pyvista",
        "vedo",
        "meshio",
        "igl",
        "matplotlib",
        "ipywidgets",
        "pythreejs",
        "dask",
        "zarr",
    }
    assert not heavy & set(loaded)


@pytest.mark.parametrize("name", qg.__all__)
def test_every_public_name_loads_and_is_documented(name: str) -> None:
    value = getattr(qg, name)
    if callable(value):
        assert value.__doc__, f"{name} has no docstring"


def public_names_for_type_checkers() -> dict[str, str]:
    """Module of each name that ``if TYPE_CHECKING:`` re-exports in the package's ``__init__``, by name."""
    tree = ast.parse(Path(qg.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    modules = {}
    for line in block.body:
        assert isinstance(line, ast.ImportFrom)
        assert line.level == 1
        for alias in line.names:
            assert alias.asname == alias.name  # the form that PEP 484 takes as a re-export
            modules[alias.name] = line.module or ""
    return modules


def test_type_checkers_see_the_names_that_run_time_has() -> None:
    seen = public_names_for_type_checkers()
    assert set(seen) == set(qg.__all__) - {"__version__"}
    for name, module in seen.items():
        expected = importlib.import_module(f"qgeo_filters.{module or name}")
        assert getattr(qg, name) is (getattr(expected, name) if module else expected), name
    assert set(qg.__all__) <= set(dir(qg))


@pytest.mark.parametrize("package", ["qgeo_filters", "qgeo_widgets"])
def test_the_packages_say_that_they_are_typed(package: str) -> None:
    assert (Path(importlib.import_module(package).__file__).parent / "py.typed").is_file()


@pytest.mark.slow
def test_mypy_sees_the_types_of_the_public_face(tmp_path: Path) -> None:
    """Not ``Any``, which every name was while they came from ``__getattr__`` alone."""
    code = tmp_path / "use.py"
    expected = {
        "match": "-> qgeo_filters.matching.match_result.MatchResult",
        "self_symmetry": "-> qgeo_filters.matching.symmetry_result.Symmetry",
        "quasi_geodesic": "-> qgeo_filters.geodesics.path.geodesic_path.GeodesicPath",
        "QuasiGeodesicSpectrum": "-> qgeo_filters.filters.spectral.QuasiGeodesicSpectrum",
    }
    lines = [f"reveal_type(qg.{name})" for name in expected]
    code.write_text("\n".join(["import qgeo_filters as qg", *lines, ""]))
    cache = ROOT / ".mypy_cache"  # the type check before the tests has filled it
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", "--cache-dir", cache, code],
        capture_output=True,
        text=True,
        env={**os.environ, "MYPYPATH": str(ROOT)},
    )
    revealed = [line for line in found.stdout.splitlines() if "Revealed type" in line]
    assert len(revealed) == len(expected), found.stdout + found.stderr
    for line, returned in zip(revealed, expected.values(), strict=True):
        assert returned in line


def test_the_version_is_written_in_one_place() -> None:
    assert metadata.version("qgeo-filters") == qg.__version__
    files = [ROOT / "pyproject.toml", *ROOT.glob("qgeo_filters/**/*.py"), *ROOT.glob("widgets/**/*.py")]
    written = [file for file in files if f'"{qg.__version__}"' in file.read_text(encoding="utf-8")]
    assert written == [ROOT / "qgeo_filters" / "__init__.py"]


def test_no_public_name_is_that_of_a_module_which_would_take_its_place() -> None:
    """Importing ``qgeo_filters.x`` sets ``qg.x`` to the module, whatever the package meant by it."""
    modules = {path.stem for path in Path(qg.__file__).parent.iterdir()}
    assert modules & set(qg.__all__) == {"testing", "evaluation"}


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'sharpen'"):
        _ = qg.sharpen


def test_old_names_are_taken_with_a_warning_that_says_the_new_one() -> None:
    for _ in range(2):  # each time, not the first alone
        with pytest.warns(DeprecationWarning, match="Descriptor is now called PreparedShape") as caught:
            assert qg.Descriptor is qg.PreparedShape
        assert caught[0].filename == __file__
    assert "Descriptor" not in dir(qg)


def test_arrays_need_no_host() -> None:
    code = """
import sys
for name in ("open3d", "pymeshlab", "pyvista", "trimesh", "ipywidgets"):
    sys.modules[name] = None  # as if it were not installed
import qgeo_filters as qg
from qgeo_filters.testing import sample_surface
s = sample_surface()
print(qg.QuasiGeodesicSpectrum(k=3)((s.vertices, s.faces)).attributes["qgeo_phi"].shape)
"""
    assert run(code).strip() == "(162, 3)"


def test_a_missing_package_is_named_with_its_extra() -> None:
    code = """
import sys
sys.modules["pymeshlab"] = None
from qgeo_filters.errors import require_package, MissingPackageError
try:
    require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
except MissingPackageError as error:
    print(error)
"""
    assert "pip install 'qgeo-filters[meshlab]'" in run(code)


def test_readme_table_lists_every_attribute() -> None:
    from qgeo_filters.filters.registry import registered_filters

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name, cls in registered_filters().items():
        if isinstance(cls.outputs, dict):
            for attribute, meaning in cls.outputs.items():
                assert f"| `{attribute}` | `{name}` | {meaning} |" in readme
